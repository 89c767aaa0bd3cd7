// How vehicles are driven: where their wheels stand, gears, steering. What moves them is in solve/vehicles.
#pragma once

#include "scene/query.h"
#include "solve/vehicles/vehicle.h"

#include <array>
#include <span>
#include <vector>

namespace lockstone::sim {

/// What a wheel was cast onto.
struct WheelHit {
    FirstHit hit; ///< of no shape: nothing
    Real length;  ///< of the suspension [m]
};

class VehicleDriver {
  public:
    /// Casts the wheels, once the bounds of the tick are known. Wakes what they stand on, and a vehicle that sleeps when
    /// something else came under its wheels; true when it woke anything.
    bool cast(Model& w, const Scene& scene);
    /// Steers and shifts the vehicles that are awake. Valid until the next call.
    std::span<solve::DrivenVehicle> drive(const Scene& scene);
    /// Writes what the solver left in them to the state. A vehicle that is driven, or in which anything turns, stays awake.
    void store(Model& w) const;
    std::span<solve::DrivenVehicle> driven() { return vehicles; }
    /// Fills what cast() and drive() make anew with a byte.
    void poison(std::byte with);

  private:
    bool stands_as_before(const Scene& scene, std::uint32_t vehicle_row);

    /// Of the wheels of a vehicle that are cast as balls: what they were cast at before.
    using WheelFaces = std::array<collide::NearFaces, vehicle_wheels_max>;
    std::vector<WheelFaces> near;                               ///< by row
    std::vector<std::array<WheelHit, vehicle_wheels_max>> hits; ///< by row
    std::vector<solve::DrivenVehicle> vehicles;                 ///< by row, of those that are awake
};

} // namespace lockstone::sim
