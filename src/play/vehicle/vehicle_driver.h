// Control of vehicles: ground under the wheels, gears and steering. Their forces are in solve/vehicles.
#pragma once

#include "scene/query.h"
#include "solve/vehicles/vehicle.h"

#include <array>
#include <span>
#include <vector>

namespace lockstone::sim {

/// The ground that the cast of a wheel found.
struct WheelHit {
    FirstHit hit; ///< no shape: the cast hit nothing
    Real length;  ///< of the suspension [m]
};

class VehicleDriver {
  public:
    /// Casts the wheels; the bounds of the tick must be known. Wakes the dynamic bodies under the wheels of awake
    /// vehicles, and sleeping vehicles with other shapes under their wheels than before. Returns true if it woke a
    /// body.
    bool cast(Model& w, const Scene& scene);
    /// Steers and shifts the awake vehicles. The result is valid until the next call.
    std::span<solve::DrivenVehicle> drive(const Scene& scene);
    /// Writes the memory of the vehicles to the state after the solver. Keeps a vehicle awake that is driven or in
    /// which anything turns.
    void store(Model& w) const;
    std::span<solve::DrivenVehicle> driven() { return vehicles; }
    /// Fills all data that cast() and drive() write with a byte, to expose reads of stale data.
    void poison(std::byte with);

  private:
    bool stands_as_before(const Scene& scene, std::uint32_t vehicle_row);

    /// Cached triangles around the last cast of each wheel, for wheels that are cast as balls.
    using WheelFaces = std::array<collide::NearFaces, vehicle_wheels_max>;
    std::vector<WheelFaces> near;                               ///< by row of the vehicle
    std::vector<std::array<WheelHit, vehicle_wheels_max>> hits; ///< by row of the vehicle
    std::vector<solve::DrivenVehicle> vehicles;                 ///< by row, only awake vehicles
};

} // namespace lockstone::sim
