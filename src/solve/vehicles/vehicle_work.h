// A vehicle's rows within a tick, and the masses that turn with them. See vehicle.h for the symbols.
#pragma once

#include "solve/bodies/solver_body.h"
#include "solve/vehicles/vehicle_rows.h"

#include <array>

namespace lockstone::solve {

/// A component of K^-1 (r x d), the arm of a row: within 64.
using Arm = I8F24;

inline constexpr Real rpm_per_speed = decimal<Real>("9.54929658551372014613"); ///< 60 / (2 pi)

/// A constraint direction of a wheel.
struct WheelLine {
    UnitVec3 d;
    Vector3<Arm> xc, xg;
    Real belt; ///< speed of the ground's surface along d [m/s]
    Real kappa;
};

/// A tyre curve in the form of the solver: its corners, and the vectors from each corner to the next.
struct TyreCurve {
    std::array<Real, 4> x, y;
    std::array<Real, 3> run, rise;
    Real peak;      ///< the highest y
    bool from_zero; ///< it starts at (0, 0)
};

/// A wheel within a tick.
struct Wheel {
    bool touches;         ///< touches the ground, or may within the tick
    bool rides;           ///< its ground moves
    bool ordinary;        ///< the constant numbers of its tyre and its rim are far from the end of a Real
    bool small;           ///< ordinary, and so is its load
    bool small_ahead;     ///< small, and so are the speeds of its patch for the train
    std::uint32_t ground; ///< entry of SolverBodies
    std::uint32_t tyre, group;
    Real ratio; ///< m / mg, 0 for a ground that impulses do not move
    WheelLine normal, along, across;
    Real mixed;                    ///< change of the speed across by an impulse along
    Real length_begin, per_length; ///< at the start of the tick [m]; suspension length per separation
    Real length;                   ///< at present [m]
    Real compression;       ///< of the spring at the start of the substep [m], 0: hangs at its full length
    Real pull[2], yield[2]; ///< h k / (1 + a kappa) and a / (1 + a kappa), for rebound and for compression
    /// distance to the stop at the start of the substep [m]; the speed that closes it within the substep [m/s]
    Real gap, gap_rate;
    Real grip; ///< factor of the tyre's curves on this ground
    Real radius;
    Real arm;                      ///< change of its group's spin by an impulse [rad/m]
    Real stiff;                    ///< of its spin: mass radius^2 [kg m^2]
    Real kappa_rim;                ///< mobility along, including a rim that turns freely
    Real rolling;                  ///< brake torque of the rolling tyre per load [kg m]
    Real brake_torque;             ///< impulse of the brakes per substep [N m s]
    Real load;                     ///< on the tyre, grip included [m/s]
    Real most_along, most_across;  ///< load times the peaks of its curves
    Real arm_most;                 ///< largest change of the spin by the tyre [rad/s]
    Real spring, stop, bars;       ///< impulses along the normal; `bars` is the sum of the anti-roll bars
    Real along_p, across_p, try_p; ///< of the tyre; `try_p`: predicted while the train is solved
    /// speeds of the patch at that time [m/s]: along, across; along without the tyre's impulse
    Real ahead, aside, ahead_free;
    Real slip, slip_side;
};

/// Divides by `of`, as a product with 1 / of where that has 22 bits or more.
struct Divisor {
    static constexpr Real inverse_below = Real(1 << 10);
    Real of, inverse;
    bool large;

    static Divisor make(Real of) { return {of, Real(1) / of, of >= inverse_below}; }
    friend Real operator/(Real x, const Divisor& d) { return d.large ? x / d.of : x * d.inverse; }
};

/// A group of wheels that turn together: one wheel, or the wheels of a track.
struct SpinGroup {
    /// [kg m^2], [rad/s]; spin_begin: at the start of the substep
    Real inertia, spin_begin, spin;
    Divisor by_inertia;
    Real torque;               ///< impulse of the train in this substep [N m s]
    Real brake;                ///< largest impulse of the brake
    Real brake_spin;           ///< brake / inertia: the largest change of a spin by the brake
    Real free;                 ///< spin_begin plus the change by the torque
    Real turned;               ///< sum of the spins of the tick's substeps
    std::uint32_t first, last; ///< range of wheels that includes all wheels of the group
    std::uint32_t on_ground;   ///< number of its wheels that touch
    Real answer;               ///< d spin / d torque
    Real answer_free;          ///< d spin / d torque while no tyre clings
    bool coupled;              ///< a coupling joins it to the train
    bool small;                ///< its spins are far from the end of a Real
};

struct Coupling {
    std::uint32_t source; ///< 0..3: differential; otherwise coupling_clutch or coupling_steering
    Real engine;          ///< ce
    std::array<Real, vehicle_wheels_max> group; ///< cg
    std::array<Real, vehicle_wheels_max> group_square;
    Real engine_answer;    ///< ce^2 / inertia of the engine
    DifferentialKind kind; ///< of a differential
    Real most; ///< limit of its torque impulse in a substep: with a closed clutch, without bias [N m s]
    Real cap;  ///< limit in this substep
    Real impulse;
};
inline constexpr std::uint32_t coupling_clutch = 4, coupling_steering = 5;

/// An anti-roll bar within a tick; a spring like those of wheels.
struct BarRow {
    bool holds;       ///< both wheels touch
    Real kappa;       ///< mobility of both wheels relative to each other
    Real pull, yield; ///< h k / (1 + a kappa) and a / (1 + a kappa)
};

/// The engine within a tick. It stays the same from tick to tick while its definition does.
struct EngineRow {
    std::int64_t known_rate = 0; ///< cache key: substeps per second; 0: nothing is computed
    EngineDef known;             ///< cache key: the definition
    Divisor inertia;
    /// change of the engine's speed per substep at the full torque and at the brake torque [rad/s]
    Real push, drag;
    Real per_speed;                  ///< rpm / rpm_max per speed [s]
    Real idle_speed, per_idle;       ///< [rad/s]; 2 / idle_speed
    std::array<Real, 8> run_inverse; ///< of the torque curve
};

/// A vehicle within a tick.
struct Vehicle {
    const VehicleDef* def; ///< in the state; no vehicle is created or destroyed within a tick
    VehicleInput input;
    VehicleMemory* memory; ///< in the DrivenVehicle
    std::uint32_t chassis; ///< row of the body columns
    std::uint32_t wheel_count;
    Real mass;
    /// [rad/s]; engine turns per turn of the wheels, 0: neutral, or between gears
    Real engine_speed, ratio;
    std::uint32_t group_count, coupling_count;
    bool any_in_air; ///< a group has no wheel on the ground
    std::array<TyreCurve, vehicle_tyres_max> along, across;
    EngineRow engine;
    /// Numbers of the engine, and of all rotating masses, are far from the end of a Real
    bool small_engine, small_train;
    std::array<BarRow, vehicle_couplings_max> bar;
    std::array<Wheel, vehicle_wheels_max> wheel;
    std::array<SpinGroup, vehicle_wheels_max> group;
    std::array<Coupling, vehicle_couplings_max + 2> coupling;
};

/// The shares of a vehicle's weight on its wheels, and the positions from which they were computed: a cache from tick
/// to tick.
struct WeightShares {
    std::uint32_t wheel_count;
    std::array<Vec3, vehicle_wheels_max> at; ///< attachments from the centre of mass [m]
    std::array<Real, vehicle_wheels_max> share;
};

struct Chassis; ///< vehicle_lines.h

// ---- rotating masses (vehicle_train.cpp) ---

/// Sets up spins, the clutch, differentials and the steering of tracks.
void prepare_train(Vehicle& v);
/// Call these after prepare_train(), in the order rims, engine: they compute the data of the engine, the couplings and
/// the rims that is constant in a tick.
void prepare_engine(const StepConstants& step, Vehicle& v);
void prepare_rims(const StepConstants& step, Vehicle& v);
/// Solves the torques of clutch, differentials and steering for this substep. Does not change the impulses of tyres.
void solve_train(const Chassis& chassis, const SolverBodies& bodies, Vehicle& v);

} // namespace lockstone::solve
