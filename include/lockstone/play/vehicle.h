// Vehicles: wheels or tracks under a dynamic body, with suspension, engine, clutch, gearbox and
// differentials.
//
//   VehicleDef car = four_wheels(chassis, {0.8_r, -0.3_r, 1.4_r});   half track, hub height, half wheelbase
//   VehicleId id = world.create_vehicle(car).value();
//   world.set_vehicle_input(id, {.throttle = 1_r, .steer = 0.2_r});  until the next input
//   world.tick();
//
// A wheel is not a body. Each tick casts it from its attachment along its suspension; its forces act on the
// chassis and on the ground that it hits, if that is dynamic. All memory of wheels is part of the world's
// state.
//
// Axes are those of the chassis body: y up, z forward, x to the left.
#pragma once

#include "lockstone/ids.h"
#include "lockstone/row.h"

#include <array>
#include <cstdint>
#include <string>

namespace lockstone {

inline constexpr std::uint32_t vehicle_wheels_max = 8, ///< wheels of a vehicle
    vehicle_tyres_max = 2,                             ///< tyres of a vehicle
    vehicle_couplings_max = 4,                         ///< anti-roll bars, and differentials, of a vehicle
    vehicle_gears_max = 8;                             ///< forward gears

/// A point of a piecewise linear curve. Points must ascend by x; the curve is constant beyond both ends.
struct CurvePoint {
    Real x, ///< 0..1000
        y;  ///< 0..10
};

/// A tyre: curves of grip (force / load) over slip. Below the peak it sticks, beyond the peak it slides.
/// Combined slip distributes the grip along the direction of sliding.
struct Tyre {
    /// Grip over longitudinal slip, |rim speed - ground speed| / ground speed.
    std::array<CurvePoint, 4> along{{{Real(0), Real(0)}, {0.08_r, 1.1_r}, {0.3_r, 0.95_r}, {Real(1), 0.9_r}}};
    /// Grip over lateral slip, the tangent of the slip angle.
    std::array<CurvePoint, 4> across{
        {{Real(0), Real(0)}, {0.12_r, Real(1)}, {0.4_r, 0.9_r}, {Real(2), 0.85_r}}};
    /// Friction of the ground for which the curves are valid, 0.01..4. The grip is proportional to the
    /// friction of the ground's shape.
    Real ground_friction = 0.6_r;
    Real rolling_resistance = 0.01_r; ///< force / load, 0..1
};

/// Cast that finds the ground of a wheel.
enum class WheelCast : std::uint32_t {
    ray,      ///< along the suspension
    sphere,   ///< of the wheel's radius: rolls over edges
    cylinder, ///< of the wheel's radius and width; on level ground the contact is at its middle
};

/// Definition of a wheel.
struct WheelDef {
    /// Position of the hub at suspension length 0, from the body's origin [m], within 64 on each axis.
    Vec3 attachment{};
    UnitVec3 direction{Unit{}, -unit_one, Unit{}}; ///< direction of the suspension, of unit length, y below 0
    std::uint32_t tyre = 0;                        ///< index in VehicleDef::tyre, 0..1
    Real length_min = 0.1_r;                       ///< suspension length at the stop [m], 0..4
    Real length_max = 0.5_r;                       ///< suspension length in the air [m], length_min..4
    Real preload{};                                ///< compression of the spring at length_max [m], 0..4
    /// Frequency of the spring with the mass that rests on the wheel [Hz], 0.1..50. At rest its compression
    /// is g / (2 pi frequency)^2.
    Real frequency = 1.5_r;
    Real damping_compression = 0.4_r; ///< damping ratio in compression, 0..10
    Real damping_rebound = 0.6_r;     ///< damping ratio in rebound, 0..10
    Real radius = 0.35_r;             ///< [m], 0.01..10
    Real width = 0.25_r;              ///< [m], 0.01..10
    Real inertia = 0.9_r;             ///< about the axle [kg m^2], 0.001..1e6; wheels of a track add up
    /// Angle at full steering [rad], within 1.3; negative: opposite direction.
    Real steer_max{};
    Real drive_share{};         ///< part of the engine torque, 0..1; the sum over all wheels is 1 or 0
    Real brake_torque{};        ///< at full brake [N m], 0..1e8
    Real hand_brake_torque{};   ///< at full hand brake [N m], 0..1e8
    std::uint32_t track = 0;    ///< tracked vehicles: 0 left, 1 right
    std::uint32_t reserved = 0; ///< 0
};

/// A spring between two wheels towards equal suspension lengths.
struct AntiRollBar {
    std::uint32_t wheel_a = 0, ///< one wheel
        wheel_b = 0;           ///< the other wheel; equal to wheel_a: no bar
    Real stiffness{};          ///< [N/m], 0..1e9
};

/// Coupling of the two speeds of a differential.
enum class DifferentialKind : std::uint32_t {
    open,    ///< speeds are independent
    limited, ///< friction of preload + bias * (input torque) between the speeds
    locked,  ///< speeds are equal
};
/// A differential between two groups of wheels: the two wheels of an axle, or two axles.
/// WheelDef::drive_share divides the torque.
struct Differential {
    DifferentialKind kind = DifferentialKind::open; ///< open, limited or locked
    std::uint32_t wheels_a = 0,                     ///< bit i: wheel i; 0: no differential
        wheels_b = 0;                               ///< the other group; no common wheel
    std::uint32_t reserved = 0;                     ///< 0
    Real preload{};                                 ///< limited: constant friction [N m], 0..1e8
    Real bias{};                                    ///< limited: friction / input torque, 0..10
};

/// Definition of an engine.
struct EngineDef {
    Real torque_max = Real(400); ///< [N m], 0..1e7
    /// Torque at full throttle as a part of torque_max, over rpm / rpm_max.
    std::array<CurvePoint, 8> torque{{{Real(0), 0.8_r},
                                      {0.2_r, 0.85_r},
                                      {0.4_r, 0.95_r},
                                      {0.65_r, Real(1)},
                                      {0.85_r, 0.95_r},
                                      {Real(1), 0.8_r},
                                      {1.1_r, 0.7_r},
                                      {1.2_r, 0.6_r}}};
    Real inertia = 0.3_r;         ///< of crankshaft and flywheel [kg m^2], 0.001..1e5
    Real rpm_idle = Real(900);    ///< minimum speed [1/min], 1..rpm_max; the engine never stalls
    Real rpm_max = Real(6500);    ///< the limiter removes the torque at this speed [1/min], 10..1e5
    Real brake_torque = Real(60); ///< at rpm_max without throttle, proportional to rpm [N m], 0..1e7
};

/// Selection of gears.
enum class GearboxMode : std::uint32_t {
    automatic, ///< VehicleInput::gear: -1 reverse, 0 neutral, 1..8 forward with automatic gears
    manual,    ///< VehicleInput::gear is the gear
};
/// Definition of gearbox and clutch.
struct GearboxDef {
    GearboxMode mode = GearboxMode::automatic; ///< automatic or manual
    std::uint32_t forward_count = 5;           ///< number of forward gears, 1..8
    /// [forward_count] ratios engine speed / output speed, 0.001..1000.
    std::array<Real, vehicle_gears_max> forward{3.6_r, 2.1_r,   1.4_r,   Real(1),
                                                0.8_r, Real(0), Real(0), Real(0)};
    Real reverse = 3.2_r;      ///< ratio of the reverse gear, 0.001..1000
    Real final_drive = 3.7_r;  ///< ratio gearbox output / wheel, 0.001..1000
    Real shift_time = 0.3_r;   ///< duration of a shift; the clutch is open [s], 0..10
    Real shift_pause = 0.5_r;  ///< automatic: minimum time between shifts [s], 0..10
    Real rpm_up = Real(5500),  ///< automatic: shifts up above it [1/min], 1..1e5
        rpm_down = Real(2200); ///< automatic: shifts down below it [1/min], 0..rpm_up
    /// Maximum torque of the clutch [N m], 0..1e8. It closes between rpm_idle and 1.5 rpm_idle.
    Real clutch_torque = Real(900);
};

/// Definition of two tracks; all wheels of a track have one speed. The gearbox drives the mean speed of the
/// tracks, and steering drives their difference from the engine (Merritt-Brown), so the vehicle can turn on
/// the spot in neutral.
struct TrackDef {
    std::uint32_t enabled = 0;        ///< 1: tracked; wheels do not steer
    std::uint32_t reserved = 0;       ///< 0
    Real steer_ratio = Real(20);      ///< engine speed / speed difference at full steering, 0.001..1e4
    Real steer_torque = Real(100000); ///< maximum torque between the tracks [N m], 0..1e8
};

/// Definition of a vehicle. World::create_vehicle() and validate() check it.
struct VehicleDef {
    BodyId chassis{};                                           ///< a dynamic body without another vehicle
    std::uint32_t wheel_count = 0;                              ///< 1..8
    WheelCast cast = WheelCast::sphere;                         ///< cast of all wheels
    std::uint32_t category = 0xffffffffu,                       ///< QueryFilter::category of the casts
        mask = 0xffffffffu;                                     ///< QueryFilter::mask of the casts
    std::array<WheelDef, vehicle_wheels_max> wheel{};           ///< [wheel_count]
    std::array<Tyre, vehicle_tyres_max> tyre{};                 ///< [2] tyres that wheels refer to
    std::array<AntiRollBar, vehicle_couplings_max> anti_roll{}; ///< [4]
    EngineDef engine{};                                         ///< engine
    GearboxDef gearbox{};                                       ///< gearbox and clutch
    std::array<Differential, vehicle_couplings_max> differential{}; ///< [4]
    TrackDef tracks{};                                              ///< tracks
    Real ackermann = Real(1);   ///< steering geometry, 0..1; 1: all wheels roll about one point, 0: parallel
    Real steer_speed{};         ///< speed of VehicleInput::steer [1/s], 0..1000; 0: at once
    std::uint64_t user_key = 0; ///< value for the game; hashed, not used
};

/// Input of a vehicle. It applies until the next World::set_vehicle_input().
struct VehicleInput {
    Real throttle{};            ///< 0..1
    Real brake{};               ///< 0..1
    Real steer{};               ///< -1 left .. 1 right
    Real hand_brake{};          ///< 0..1
    Real clutch{};              ///< clutch pedal, 0..1; 1: open
    std::int32_t gear = 1;      ///< see GearboxMode, -1..8; at most forward_count applies
    std::uint32_t reserved = 0; ///< 0

    /// Equal fields.
    friend constexpr bool operator==(const VehicleInput&, const VehicleInput&) = default;
};

/// State of a wheel after the last tick.
struct WheelState {
    Transform pose; ///< of the hub, world [m]; x is the axle, y up
    Real rotation;  ///< rotation about the axle [rad], 0..2 pi, forward
    Real spin;      ///< [rad/s], forward
    Real length;    ///< suspension length [m]
    Real steer;     ///< steering angle [rad], to the left
    Real load;      ///< force along the ground's normal in the last substep [N]
    Real along,     ///< tyre force on the vehicle, forward [N]
        across;     ///< tyre force on the vehicle, to the left [N]
    Real slip,      ///< longitudinal slip as in Tyre, signed
        slip_side;  ///< lateral slip as in Tyre, signed
    ShapeId ground; ///< null: in the air
};
/// State of a vehicle after the last tick.
struct VehicleState {
    Real rpm;                                         ///< engine speed [1/min]
    std::int32_t gear;                                ///< -1 reverse, 0 neutral, 1..8
    std::uint32_t shifting;                           ///< 1: a shift is in progress
    Real clutch_torque;                               ///< torque through the clutch [N m]
    std::uint32_t wheel_count;                        ///< 1..8
    std::array<WheelState, vehicle_wheels_max> wheel; ///< [wheel_count]
};

/// A car with wheels 0 front left, 1 front right, 2 rear left, 3 rear right, with hubs at (+-hub.x, hub.y,
/// +-hub.z) [m] when the suspension is half extended. The front wheels steer by 0.6 rad, the rear wheels
/// drive, all of them brake.
VehicleDef four_wheels(BodyId chassis, Vec3 hub);
/// A tracked vehicle with `wheels` wheels (clamped to 1..4) on each track, at x = +-hub.x, from z = hub.z to
/// -hub.z [m].
VehicleDef two_tracks(BodyId chassis, Vec3 hub, std::uint32_t wheels);
/// Empty if the definition is valid; else a sentence with the wrong field. Does not check the chassis.
std::string validate(const VehicleDef& def);
/// Empty if the input is valid; else a sentence with the wrong field.
std::string validate(const VehicleInput& input);

/// Field list with ranges; see lockstone/row.h.
///@{
template <class V> constexpr void describe(CurvePoint& p, V&& v) {
    field(v, "x", p.x, in(0_r, 1000_r));
    field(v, "y", p.y, in(0_r, 10_r));
}
template <class V> constexpr void describe(Tyre& t, V&& v) {
    v("along", t.along), v("across", t.across);
    field(v, "ground_friction", t.ground_friction, in(0.01_r, 4_r));
    field(v, "rolling_resistance", t.rolling_resistance, in(0_r, 1_r));
}
template <class V> constexpr void describe(WheelDef& w, V&& v) {
    field(v, "attachment", w.attachment, EachIn{Real(64), "m"});
    field(v, "direction", w.direction, UnitLong{});
    field(v, "tyre", w.tyre, in(0, vehicle_tyres_max - 1));
    field(v, "length_min", w.length_min, in(0_r, 4_r, " m"));
    field(v, "length_max", w.length_max, in(0_r, 4_r, " m"));
    field(v, "preload", w.preload, in(0_r, 4_r, " m"));
    field(v, "frequency", w.frequency, in(0.1_r, 50_r, " Hz"));
    field(v, "damping_compression", w.damping_compression, in(0_r, 10_r));
    field(v, "damping_rebound", w.damping_rebound, in(0_r, 10_r));
    field(v, "radius", w.radius, in(0.01_r, 10_r, " m"));
    field(v, "width", w.width, in(0.01_r, 10_r, " m"));
    field(v, "inertia", w.inertia, in(0.001_r, 1000000_r, " kg m^2"));
    field(v, "steer_max", w.steer_max, in(-1.3_r, 1.3_r, " rad"));
    field(v, "drive_share", w.drive_share, in(0_r, 1_r));
    field(v, "brake_torque", w.brake_torque, in(0_r, 100000000_r, " N m"));
    field(v, "hand_brake_torque", w.hand_brake_torque, in(0_r, 100000000_r, " N m"));
    field(v, "track", w.track, in(0, 1));
    field(v, "reserved", w.reserved, always_zero);
}
template <class V> constexpr void describe(AntiRollBar& a, V&& v) {
    v("wheel_a", a.wheel_a), v("wheel_b", a.wheel_b);
    field(v, "stiffness", a.stiffness, in(0_r, 1000000000_r, " N/m"));
}
template <class V> constexpr void describe(Differential& d, V&& v) {
    field(v, "kind", d.kind, in(0, 2));
    v("wheels_a", d.wheels_a), v("wheels_b", d.wheels_b);
    field(v, "reserved", d.reserved, always_zero);
    field(v, "preload", d.preload, in(0_r, 100000000_r, " N m"));
    field(v, "bias", d.bias, in(0_r, 10_r));
}
template <class V> constexpr void describe(EngineDef& e, V&& v) {
    field(v, "torque_max", e.torque_max, in(0_r, 10000000_r, " N m"));
    v("torque", e.torque);
    field(v, "inertia", e.inertia, in(0.001_r, 100000_r, " kg m^2"));
    field(v, "rpm_idle", e.rpm_idle, in(1_r, 100000_r));
    field(v, "rpm_max", e.rpm_max, in(10_r, 100000_r));
    field(v, "brake_torque", e.brake_torque, in(0_r, 10000000_r, " N m"));
}
template <class V> constexpr void describe(GearboxDef& g, V&& v) {
    constexpr In<Real> ratio = in(0.001_r, 1000_r);
    field(v, "mode", g.mode, in(0, 1));
    field(v, "forward_count", g.forward_count, in(1, vehicle_gears_max));
    field(v, "forward", g.forward, first(g.forward_count, ratio));
    field(v, "reverse", g.reverse, ratio);
    field(v, "final_drive", g.final_drive, ratio);
    field(v, "shift_time", g.shift_time, in(0_r, 10_r, " s"));
    field(v, "shift_pause", g.shift_pause, in(0_r, 10_r, " s"));
    field(v, "rpm_up", g.rpm_up, in(1_r, 100000_r));
    field(v, "rpm_down", g.rpm_down, in(0_r, 100000_r));
    field(v, "clutch_torque", g.clutch_torque, in(0_r, 100000000_r, " N m"));
}
template <class V> constexpr void describe(TrackDef& t, V&& v) {
    field(v, "enabled", t.enabled, no_or_yes);
    field(v, "reserved", t.reserved, always_zero);
    field(v, "steer_ratio", t.steer_ratio, in(0.001_r, 10000_r));
    field(v, "steer_torque", t.steer_torque, in(0_r, 100000000_r, " N m"));
}
template <class V> constexpr void describe(VehicleDef& d, V&& v) {
    v("chassis", d.chassis);
    field(v, "wheel_count", d.wheel_count, in(1, vehicle_wheels_max));
    field(v, "cast", d.cast, in(0, 2));
    v("category", d.category), v("mask", d.mask);
    field(v, "wheel", d.wheel, first(d.wheel_count));
    v("tyre", d.tyre), v("anti_roll", d.anti_roll), v("engine", d.engine), v("gearbox", d.gearbox);
    v("differential", d.differential), v("tracks", d.tracks);
    field(v, "ackermann", d.ackermann, in(0_r, 1_r));
    field(v, "steer_speed", d.steer_speed, in(0_r, 1000_r, " 1/s"));
    v("user_key", d.user_key);
}
template <class V> constexpr void describe(VehicleInput& i, V&& v) {
    field(v, "throttle", i.throttle, in(0_r, 1_r));
    field(v, "brake", i.brake, in(0_r, 1_r));
    field(v, "steer", i.steer, in(-1_r, 1_r));
    field(v, "hand_brake", i.hand_brake, in(0_r, 1_r));
    field(v, "clutch", i.clutch, in(0_r, 1_r));
    field(v, "gear", i.gear, in(-1, vehicle_gears_max));
    field(v, "reserved", i.reserved, always_zero);
}
///@}

} // namespace lockstone
