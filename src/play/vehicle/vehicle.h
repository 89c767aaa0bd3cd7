// Vehicles in the solver: per wheel a suspension row and two tyre rows, per vehicle a train of turning masses.
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
// against what the tyres will answer), solve (springs, stops, bars, tyres), poses.
// source: implicit springs as in Catto, Soft Constraints, GDC 2011; slip and its combination as in Pacejka, Tire and
// Vehicle Dynamics, 1.2; the rest is this library's own.
#pragma once

#include "base/parallel.h"
#include "model/vehicle_rows.h"
#include "scene/query.h"
#include "solve/bodies/solver_body.h"

#include <span>
#include <vector>

namespace lockstone::sim {

/// Of a row's turning arm K^-1 (r x d): within 64.
using Arm = I8F24;

inline constexpr Real rpm_per_speed = decimal<Real>("9.54929658551372014613"); ///< 60 / (2 pi)

/// A constraint direction of a wheel.
struct WheelLine {
    UnitVec3 d;
    Vector3<Arm> xc, xg;
    Real belt; ///< speed of the ground's surface along it [m/s]
    Real kappa;
};

/// A curve as the solver reads it: its corners, and the way from each to the next.
struct TyreCurve {
    std::array<Real, 4> x, y;
    std::array<Real, 3> run, rise;
    Real peak;      ///< its highest point
    bool from_zero; ///< it begins at 0, 0
};

/// A wheel within a tick.
struct Wheel {
    bool touches;     ///< the ground, or may within the tick
    bool rides;       ///< its ground moves
    bool ordinary;    ///< numbers of its tyre and its rim that are constant are far from the end of a Real
    bool small;       ///< its load too
    bool small_ahead; ///< and the speeds of its patch for the train
    std::uint32_t ground; ///< entry of SolverBodies
    std::uint32_t tyre, group;
    Real ratio; ///< m / mg, 0 for a ground that nothing moves
    WheelLine normal, along, across;
    Real mixed;                    ///< speed across per impulse along
    Real length_begin, per_length; ///< at the start of the tick [m]; suspension length per separation
    Real length;                   ///< now
    Real compression;              ///< of the spring when the substep began [m], 0: it hangs
    Real pull[2], yield[2];        ///< h k / (1 + a kappa) and a / (1 + a kappa): of rebound and compression
    Real gap, gap_rate; ///< to the stop when the substep began [m]; what closes it within one [m/s]
    Real grip;          ///< factor of the tyre's curves on this ground
    Real radius;
    Real arm;                      ///< spin of its group per impulse [rad/m]
    Real stiff;                    ///< of its spin: mass radius^2 [kg m^2]
    Real kappa_rim;                ///< mobility along with a rim that turns freely
    Real rolling;                  ///< brake of the rolling tyre per load [kg m]
    Real brake_torque;             ///< impulse of the brakes per substep [N m s]
    Real load;                     ///< on the tyre, grip included [m/s]
    Real most_along, most_across;  ///< load times the peaks of its curves
    Real arm_most;                 ///< most that the tyre changes the spin [rad/s]
    Real spring, stop, bars;       ///< impulses along the normal; `bars` is the sum of the anti-roll bars
    Real along_p, across_p, try_p; ///< of the tyre; `try_p` while the train is solved
    Real ahead, aside, ahead_free; ///< speeds of the patch then [m/s]; without the tyre's impulse along
    Real slip, slip_side;
};

/// x / of, as a product with 1 / of where that keeps 22 bits or more.
struct Divisor {
    static constexpr Real inverse_below = Real(1 << 10);
    Real of, inverse;
    bool large;

    static Divisor make(Real of) { return {of, Real(1) / of, of >= inverse_below}; }
    friend Real operator/(Real x, const Divisor& d) { return d.large ? x / d.of : x * d.inverse; }
};

/// What turns as one: a wheel, or a track's wheels.
struct SpinGroup {
    Real inertia, spin_begin, spin; ///< [kg m^2], [rad/s]; spin_begin is that of the substep
    Divisor by_inertia;
    Real torque;               ///< impulse of the train in this substep [N m s]
    Real brake;                ///< most impulse of the brake
    Real brake_spin;           ///< brake / inertia: what it takes of a spin
    Real free;                 ///< spin_begin and what the torque adds
    Real turned;               ///< sum of the spins of the tick's substeps
    std::uint32_t first, last; ///< its wheels are among these
    std::uint32_t on_ground;   ///< how many of its wheels touch
    Real answer;               ///< d spin / d torque
    Real answer_free;          ///< the same while no tyre clings
    bool coupled;              ///< to the train
    bool small;                ///< its spins are far from the end of a Real
};

struct Coupling {
    std::uint32_t source;                       ///< 0..3: differential, else one of the two below
    Real engine;                                ///< ce
    std::array<Real, vehicle_wheels_max> group; ///< cg
    std::array<Real, vehicle_wheels_max> group_square;
    Real engine_answer;    ///< ce^2 / inertia of the engine
    DifferentialKind kind; ///< of a differential
    Real most;             ///< of its torque in a substep: at a closed clutch, without bias [N m s]
    Real cap;              ///< in this substep
    Real impulse;
};
inline constexpr std::uint32_t coupling_clutch = 4, coupling_steering = 5;

/// An anti-roll bar within a tick; a spring as those of wheels.
struct BarRow {
    bool holds;       ///< its wheels touch
    Real kappa;       ///< of both wheels against each other
    Real pull, yield; ///< h k / (1 + a kappa) and a / (1 + a kappa)
};

/// The engine within a tick: the same from tick to tick while it is of the same definition.
struct EngineRow {
    std::int64_t known_rate = 0; ///< substeps per second that it was found for; 0: nothing is found
    EngineDef known;             ///< and of what
    Divisor inertia;
    Real push, drag;                 ///< speed per substep at the full and at the brake torque [rad/s]
    Real per_speed;                  ///< rpm / rpm_max per speed [s]
    Real idle_speed, per_idle;       ///< [rad/s]; 2 / idle_speed
    std::array<Real, 8> run_inverse; ///< of the torque curve
};

/// A vehicle within a tick.
struct Vehicle {
    const VehicleDef* def; ///< of the state; nothing is made or destroyed within a tick
    VehicleInput input;
    VehicleMemory memory;
    std::uint32_t row, chassis; ///< rows of the vehicle and body columns
    Real mass;
    /// [rad/s]; engine turns per turn of the wheels, 0: in neutral or between gears
    Real engine_speed, ratio;
    std::uint32_t group_count, coupling_count;
    bool any_in_air; ///< a group of which no wheel is on the ground
    std::array<TyreCurve, vehicle_tyres_max> along, across;
    EngineRow engine;
    /// Numbers of the engine, and of all that turns, are far from the end of a Real
    bool small_engine, small_train;
    std::array<BarRow, vehicle_couplings_max> bar;
    std::array<Wheel, vehicle_wheels_max> wheel;
    std::array<SpinGroup, vehicle_wheels_max> group;
    std::array<Coupling, vehicle_couplings_max + 2> coupling;
};

/// What a wheel stands on.
struct WheelGround {
    bool found;
    QueryHit hit;
    Real length; ///< of the suspension [m]
};

/// How a vehicle's weight lies on its wheels, and of what that was found: the same from tick to tick.
struct WeightShares {
    std::uint32_t wheel_count;
    std::array<Vec3, vehicle_wheels_max> at; ///< attachments from the centre of mass [m]
    std::array<Real, vehicle_wheels_max> share;
};

/// A chassis and a body that one of its wheels stands on, by row.
struct Standing {
    std::uint32_t chassis, ground;
};

/// Vehicles of one convoy push bodies that others of it push too, so they are solved one after the other; convoys share
/// nothing that is written, so workers take them in any order.
class VehicleSolver {
  public:
    /// Casts the wheels, once the bounds of the tick are known. Wakes what they stand on, and a vehicle that sleeps when
    /// something else came under its wheels; true when it woke anything.
    bool cast(Model& w, const Scene& scene);
    /// Rows, gears, couplings. Once a tick, when the bodies are in solver form.
    void prepare(const Scene& scene, const solve::StepConstants& step, const solve::SolverBodies& bodies);
    /// At the begin of a substep, after the velocities were integrated.
    void warm_start(const solve::StepConstants& step, solve::SolverBodies& bodies);
    /// Springs, stops and bars in the pass with bias; tyres in every pass.
    void solve(const solve::StepConstants& step, solve::SolverBodies& bodies, bool bias);
    /// What vehicles keep, and what they stood on.
    void store(Model& w, const solve::StepConstants& step, const solve::SolverBodies& bodies);
    /// In the tick that was stored last: vehicles sleep and wake with what they stand on.
    std::span<const Standing> standing() const { return stands; }
    /// Fills what cast() and prepare() make anew with a byte.
    void poison(std::byte with);

  private:
    bool stands_as_before(const Scene& scene, std::uint32_t vehicle_row) const;
    void find_convoys(const solve::SolverBodies& bodies);
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
    std::vector<std::array<WheelGround, vehicle_wheels_max>> grounds; ///< by row
};

struct Chassis;

// ---- parts -------------------------------------------------------------------------------------------------------

/// What all vehicles of a tick look at.
struct VehicleTick {
    const Model& w;
    const PlacedShapes& placed;
    const solve::StepConstants& step;
    const solve::SolverBodies& bodies;
    Real substep; ///< [s]
};
/// `axes`: of the chassis; `share`: of its mass.
void prepare_wheel(const VehicleTick& tick, const Rotation& axes, Vehicle& v, std::uint32_t wheel, Real share,
                   const WheelGround& ground);
/// Once the train is made: what of a rim stays as it is for the tick.
void prepare_rims(const solve::StepConstants& step, Vehicle& v);
void shift_gears(const VehicleTick& tick, const Rotation& axes, Vehicle& v);
void prepare_train(Vehicle& v);
void prepare_engine(const solve::StepConstants& step, Vehicle& v);
/// Torques of clutch, differentials and steering for this substep; leaves the impulses of tyres as they are.
void solve_train(const Chassis& chassis, const solve::SolverBodies& bodies, Vehicle& v);

/// Fractions of the chassis' mass on each wheel, so that equal frequencies sag level; `center` is that of mass.
void find_shares(const VehicleDef& def, Vec3 center, WeightShares& known);
/// Of each wheel to the left [rad].
void find_steer_angles(const VehicleDef& def, Real steer, VehicleMemory& out);

} // namespace lockstone::sim
