// A vehicle's rows within a tick, and what turns with them. See vehicle.h for the symbols.
#pragma once

#include "solve/bodies/solver_body.h"
#include "solve/vehicles/vehicle_rows.h"

#include <array>

namespace lockstone::solve {

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
    Real pull[2], yield[2]; ///< h k / (1 + a kappa) and a / (1 + a kappa), for rebound and for compression
    Real gap, gap_rate;     ///< to the stop when the substep began [m]; what closes it within one [m/s]
    Real grip;              ///< factor of the tyre's curves on this ground
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
    VehicleMemory* memory; ///< of the DrivenVehicle
    std::uint32_t chassis; ///< row of the body columns
    std::uint32_t wheel_count;
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

/// How a vehicle's weight is shared out over its wheels, and the places that this was computed from: the same from tick to tick.
struct WeightShares {
    std::uint32_t wheel_count;
    std::array<Vec3, vehicle_wheels_max> at; ///< attachments from the centre of mass [m]
    std::array<Real, vehicle_wheels_max> share;
};

struct Chassis; ///< vehicle_lines.h

// ---- what turns (vehicle_train.cpp) ---

/// Spins, the clutch, differentials and the steering of tracks.
void prepare_train(Vehicle& v);
/// Once the train is made: what of the engine, of couplings and of rims stays as it is for the tick.
void prepare_engine(const StepConstants& step, Vehicle& v);
void prepare_rims(const StepConstants& step, Vehicle& v);
/// Torques of clutch, differentials and steering for this substep; leaves the impulses of tyres as they are.
void solve_train(const Chassis& chassis, const SolverBodies& bodies, Vehicle& v);

} // namespace lockstone::solve
