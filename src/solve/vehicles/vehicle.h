// Vehicles: per wheel a suspension row and two tyre rows, per vehicle a train of turning masses.
//
//   row          D = (d, xc ; -d, xg)   d: normal n, forwards f, left s;  xc = K_c^-1 (rc x d), xg = -K_g^-1 (rg x d)
//   speed        D . (vc, uc, vg, ug)   of the patch of the chassis over the ground
//   impulse      p = lambda / m         m: mass of the chassis; velocity units [m/s]
//   mobility     kappa = D . D          with the ground's part times m / mg: speed per impulse
//   spring       p = h k x + a (rate + kappa p)   k = share (2 pi f)^2, a = h^2 k + h c: implicit, cannot overshoot
//   stop         unilateral and soft as a contact, below the least suspension length
//   anti-roll    p = h k (xa - xb) + a (rate a - rate b) on a, -p on b
//   tyre         |p| = N grip(slip),  slip = |slide| / |ground speed|,  N the load: implicit in p, so that it can stick
//   spin         I (w' - w) = T + b - m r p   T from the train, b of the brake; solved together with the tyre
//   coupling     e = ce W + sum cg wg: clutch, differential, steering of tracks; |lambda| <= cap; W the engine's speed
//
// A substep: velocities, warm start (springs and tyres start from the last substep's impulses; the train is solved
// against what the tyres will answer), solve with bias (springs, stops, bars, tyres), poses, relax (tyres).
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

/// What a wheel stands on, as it was cast.
struct WheelGround {
    ShapeId shape;      ///< null: the wheel is in the air, and nothing else is looked at
    std::uint32_t body; ///< row of the body columns; SolverBodies::still() for what rests
    Vec3 point;
    UnitVec3 normal;
    Real length; ///< of the suspension [m]
    Real friction;
    Vec3 velocity; ///< of its surface beside its body's [m/s]
};

/// A vehicle that is awake, as the tick hands it over.
struct DrivenVehicle {
    const VehicleDef* def;
    VehicleInput input;
    /// Of the last tick; gears, the steering wheel and the wheels' angles are those of this one
    VehicleMemory memory;
    std::uint32_t row;     ///< of the vehicle columns
    std::uint32_t chassis; ///< row of the body columns
    Rotation axes;         ///< of the chassis
    Real ratio;            ///< engine turns per turn of the wheels, 0: in neutral or between gears
    std::array<WheelGround, vehicle_wheels_max> ground;
};

/// A chassis and a body that one of its wheels stands on, by row.
struct Standing {
    std::uint32_t chassis, ground;
};

/// Vehicles of one convoy push bodies that others of it push too, so they are solved one after the other; convoys share
/// nothing that is written, so workers take them in any order.
class VehicleSolver {
  public:
    /// Once a tick, when the bodies are in solver form. What is driven stays where it is until store().
    void prepare(std::span<DrivenVehicle> driven, const BodyColumns& columns, const StepConstants& step,
                 const SolverBodies& bodies, Tasks* tasks = nullptr);
    /// At the begin of a substep, after the velocities were integrated.
    void warm_start(const StepConstants& step, SolverBodies& bodies);
    /// Springs, stops and bars in the pass with bias; tyres in every pass.
    void solve(const StepConstants& step, SolverBodies& bodies, bool bias);
    /// What vehicles keep, in the order of prepare(), and what they stood on.
    void store(const StepConstants& step, const SolverBodies& bodies, std::span<DrivenVehicle> driven);
    /// In the tick that was stored last: vehicles sleep and wake with what they stand on.
    std::span<const Standing> standing() const { return stands; }
    /// True where a convoy of this tick has several vehicles.
    bool has_convoys() const { return convoy_begin.size() < vehicles.size() + 1; }
    /// The first fault of this tick's plan in a sentence, or nothing: each vehicle is in one convoy, each body is pushed by one convoy, and the vehicles
    /// of a convoy follow in ascending order. Builds with assertions call it for each plan.
    std::string order_fault(const SolverBodies& bodies) const;
    /// Fills what prepare() makes anew with a byte.
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
    std::vector<WeightShares> shares;              ///< by row; looked at anew in each tick
    Tasks* tasks = nullptr;                        ///< of this tick
    std::vector<std::uint32_t> order;              ///< of vehicles: by convoy, then by row
    std::vector<std::uint32_t> convoy_begin = {0}; ///< in `order`, and the end
    /// A body that a vehicle pushes.
    struct Pushed {
        std::uint32_t body, vehicle;
        friend constexpr auto operator<=>(const Pushed&, const Pushed&) = default;
    };
    std::vector<Pushed> pushed;
    std::vector<std::uint32_t> convoy; ///< by vehicle: the first vehicle of its convoy, when all are found
};

} // namespace lockstone::solve
