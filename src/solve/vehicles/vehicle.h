// Vehicles: for each wheel a suspension row and two tyre rows, for each vehicle a train of rotating masses.
//
//   row          D = (d, xc ; -d, xg)   d: normal n, forwards f, left s;  xc = K_c^-1 (rc x d), xg = -K_g^-1 (rg x d)
//   speed        D . (vc, uc, vg, ug)   of the patch of the chassis relative to the ground
//   impulse      p = lambda / m         m: mass of the chassis; velocity units [m/s]
//   mobility     kappa = D . D          with the ground's part times m / mg: speed per impulse
//   spring       p = h k x + a (rate + kappa p)   k = share (2 pi f)^2, a = h^2 k + h c: implicit, so it cannot
//                                                 overshoot
//   stop         unilateral and soft as a contact, below the least suspension length
//   anti-roll    p = h k (xa - xb) + a (rate a - rate b) on a, -p on b
//   tyre         |p| = N grip(slip),  slip = |slide| / |ground speed|,  N the load: implicit in p, so that it can stick
//   spin         I (w' - w) = T + b - m r p   T from the train, b from the brake; solved together with the tyre
//   coupling     e = ce W + sum cg wg: clutch, differential, steering of tracks; |lambda| <= cap; W the engine's speed
//
// A substep: velocities, warm start (springs and tyres start from the last substep's impulses; the train is solved with
// a prediction of the tyres' impulses), solve with bias (springs, stops, bars, tyres), poses, relax (tyres).
// source: implicit springs as in Catto, Soft Constraints, GDC 2011; slip and its combination as in Pacejka, Tire and
// Vehicle Dynamics, 1.2; the rest is this library's own.
#pragma once

#include "base/parallel.h"
#include "solve/bodies/solver_body.h"
#include "solve/vehicles/vehicle_work.h"

#include <span>
#include <string>
#include <vector>

namespace lockstone::solve {

/// The ground under a wheel, from its cast.
struct WheelGround {
    ShapeId shape;      ///< null: the wheel is in the air, and no other member is read
    std::uint32_t body; ///< row of the body columns; SolverBodies::still() for a ground that does not move
    Vec3 point;
    UnitVec3 normal;
    Real length; ///< of the suspension [m]
    Real friction;
    Vec3 velocity; ///< of its surface relative to its body [m/s]
};

/// An awake vehicle, as the tick passes it.
struct DrivenVehicle {
    const VehicleDef* def;
    VehicleInput input;
    /// Memory after the last tick, but with the gears, steering wheel and wheel angles of this tick
    VehicleMemory memory;
    std::uint32_t row;     ///< of the vehicle columns
    std::uint32_t chassis; ///< row of the body columns
    Rotation axes;         ///< of the chassis
    Real ratio;            ///< engine turns per turn of the wheels, 0: neutral, or between gears
    std::array<WheelGround, vehicle_wheels_max> ground;
};

/// A chassis, and a body under one of its wheels, by row.
struct Standing {
    std::uint32_t chassis, ground;
};

/// Solves the vehicles. Vehicles of one convoy push the same bodies, so they are solved in order by one worker. Convoys
/// write no common data, so workers solve them in any order.
class VehicleSolver {
  public:
    /// Call it once a tick, when the bodies are in solver form. `driven` has to keep its address until store().
    void prepare(std::span<DrivenVehicle> driven, const BodyColumns& columns, const StepConstants& step,
                 const SolverBodies& bodies, Tasks* tasks = nullptr);
    /// Call it at the start of a substep, after velocities are integrated.
    void warm_start(const StepConstants& step, SolverBodies& bodies);
    /// Solves springs, stops and bars in the pass with bias; solves tyres in every pass.
    void solve(const StepConstants& step, SolverBodies& bodies, bool bias);
    /// Writes the memory of vehicles, in the order of prepare(), and lists the bodies under their wheels.
    void store(const StepConstants& step, const SolverBodies& bodies, std::span<DrivenVehicle> driven);
    /// The bodies under wheels in the tick of the last store(): vehicles sleep and wake with them.
    std::span<const Standing> standing() const { return stands; }
    /// True where a convoy of this tick has several vehicles.
    bool has_convoys() const { return convoy_begin.size() < vehicles.size() + 1; }
    /// The first fault of this tick's plan, in a sentence; empty if there is none: each vehicle is in one convoy, each
    /// body is pushed by one convoy, and the vehicles of a convoy have ascending order. Builds with assertions call it
    /// for each plan.
    std::string order_fault(const SolverBodies& bodies) const;
    /// Fills all data that prepare() computes in each tick with the byte `with`.
    void poison(std::byte with);

  private:
    void find_convoys(const SolverBodies& bodies);
    template <class Visit> void for_each_vehicle(Visit&& visit) {
        base::for_chunks(tasks, static_cast<std::uint32_t>(convoy_begin.size() - 1), 1,
                         [&](std::uint32_t k, std::uint32_t, std::uint32_t) {
                             for (std::uint32_t i = convoy_begin[k]; i < convoy_begin[k + 1]; ++i)
                                 visit(vehicles[order[i]]);
                         });
    }

    std::int32_t substeps_left = 0; ///< of this tick
    std::vector<Standing> stands;
    std::vector<Vehicle> vehicles;
    std::vector<WeightShares> shares;              ///< by row of the vehicle columns; checked in each tick
    Tasks* tasks = nullptr;                        ///< of this tick
    std::vector<std::uint32_t> order;              ///< vehicles by convoy, then by row
    std::vector<std::uint32_t> convoy_begin = {0}; ///< first index in `order` of each convoy, and the end
    /// A body that a vehicle pushes.
    struct Pushed {
        std::uint32_t body, vehicle;
        friend constexpr auto operator<=>(const Pushed&, const Pushed&) = default;
    };
    std::vector<Pushed> pushed;
    std::vector<std::uint32_t> convoy; ///< by vehicle: the first vehicle of its convoy
};

} // namespace lockstone::solve
