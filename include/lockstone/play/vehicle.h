// Vehicles: wheels or tracks under a dynamic body, with suspension, engine, clutch, gearbox and differentials.
//
//   VehicleDef car = four_wheels(chassis, {0.8_r, -0.3_r, 1.4_r});   half track, height of the hubs, half wheelbase
//   VehicleId id = world.create_vehicle(car).value();
//   world.set_vehicle_input(id, {.throttle = 1_r, .steer = 0.2_r});  holds until the next one
//   world.tick();
//
// A wheel is no body: it is cast from its attachment along its suspension, and pushes between the chassis and the ground that it
// finds, which moves too if it can. All that a wheel remembers from tick to tick is state.
//
// Axes are those of the chassis body: y up, z forward, x to the left.
#pragma once

#include "lockstone/ids.h"
#include "lockstone/row.h"

#include <array>
#include <cstdint>
#include <string>

namespace lockstone {

inline constexpr std::uint32_t vehicle_wheels_max = 8, vehicle_tyres_max = 2, vehicle_couplings_max = 4,
                               vehicle_gears_max = 8;

/// A corner of a piecewise linear curve. Curves have their corners in ascending x; beyond the ends they are level.
struct CurvePoint {
    Real x, y;
};

/// Grip, force over load, by slip. On the way up a tyre clings, past its peak it slides.
/// Slip along: |rim speed - ground speed| / ground speed; across: tangent of the slip angle.
/// A tyre that slides both ways shares its grip out along the direction in which it slides.
struct Tyre {
    std::array<CurvePoint, 4> along{
        {{Real(0), Real(0)}, {0.08_r, 1.1_r}, {0.3_r, 0.95_r}, {Real(1), 0.9_r}}}; ///< y 0..10
    std::array<CurvePoint, 4> across{
        {{Real(0), Real(0)}, {0.12_r, Real(1)}, {0.4_r, 0.9_r}, {Real(2), 0.85_r}}};
    Real ground_friction = 0.6_r;     ///< of the ground on which the curves hold, 0.01..4: the grip grows
                                      ///< in proportion to that of the ground's shape
    Real rolling_resistance = 0.01_r; ///< force over load, 0..1
};

enum class WheelCast : std::uint32_t {
    ray,      ///< from the attachment along the suspension
    sphere,   ///< of the wheel's radius: rolls over edges
    cylinder, ///< of the wheel's radius and width; bears in its middle where it stands level
};

struct WheelDef {
    /// Where the hub is at a suspension length of 0, from the body's origin [m], within 64
    Vec3 attachment{};
    UnitVec3 direction{Unit{}, -unit_one, Unit{}}; ///< in which the suspension extends, downwards
    std::uint32_t tyre = 0;                        ///< index of VehicleDef::tyre
    Real length_min = 0.1_r;                       ///< of the suspension when it meets its stop [m], 0..4
    Real length_max = 0.5_r;                       ///< when it hangs
    Real preload{};         ///< how much longer than length_max its spring is [m], 0..4
    Real frequency = 1.5_r; ///< [Hz], 0.1..50: of the spring under the mass that rests on this wheel;
                            ///< it gives by g / (2 pi frequency)^2 at rest
    Real damping_compression = 0.4_r; ///< damping ratio, 0..10
    Real damping_rebound = 0.6_r;
    Real radius = 0.35_r; ///< [m], 0.01..10
    Real width = 0.25_r;  ///< [m], 0.01..10
    Real inertia = 0.9_r; ///< [kg m^2], 0.001..1e6, of the turning wheel; in a track they add up
    Real steer_max{}; ///< angle at full steering [rad], within 1.3; negative for wheels that steer against it
    Real drive_share{};       ///< of the engine's torque, 0..1; all together 1, or 0 if nothing is driven
    Real brake_torque{};      ///< at full brake [N m], 0..1e8
    Real hand_brake_torque{}; ///< [N m]
    std::uint32_t track = 0;  ///< of a tracked vehicle: 0 left, 1 right
    std::uint32_t reserved = 0;
};

/// Pushes the wheels of a pair to the same suspension length.
struct AntiRollBar {
    std::uint32_t wheel_a = 0, wheel_b = 0; ///< the same twice: no bar
    Real stiffness{};                       ///< [N/m], 0..1e9
};

enum class DifferentialKind : std::uint32_t {
    open,    ///< leaves the speeds alone
    limited, ///< brakes their difference with preload + bias * (torque that comes in)
    locked,  ///< keeps them equal
};
/// Between two groups of wheels: the two of an axle, or two axles. Torque is shared out by the wheels' drive_share.
struct Differential {
    DifferentialKind kind = DifferentialKind::open;
    std::uint32_t wheels_a = 0, wheels_b = 0; ///< bit i: wheel i; one of them 0: no differential
    std::uint32_t reserved = 0;
    Real preload{}; ///< [N m], 0..1e8
    Real bias{};    ///< 0..10
};

struct EngineDef {
    Real torque_max = Real(400); ///< [N m], 0..1e7
    /// Share of torque_max at full throttle over rpm / rpm_max.
    std::array<CurvePoint, 8> torque{{{Real(0), 0.8_r},
                                      {0.2_r, 0.85_r},
                                      {0.4_r, 0.95_r},
                                      {0.65_r, Real(1)},
                                      {0.85_r, 0.95_r},
                                      {Real(1), 0.8_r},
                                      {1.1_r, 0.7_r},
                                      {1.2_r, 0.6_r}}};
    Real inertia = 0.3_r;         ///< of crankshaft and flywheel [kg m^2], 0.001..1e5
    Real rpm_idle = Real(900);    ///< 1..rpm_max; below it the engine does not fall: it never stalls
    Real rpm_max = Real(6500);    ///< the limiter cuts the fuel, 10..1e5
    Real brake_torque = Real(60); ///< without throttle at rpm_max, in proportion to rpm [N m], 0..1e7
};

enum class GearboxMode : std::uint32_t {
    automatic, ///< input.gear: -1 reverse, 0 neutral, 1 and above: forward, the box chooses
    manual,    ///< input.gear: the gear
};
struct GearboxDef {
    GearboxMode mode = GearboxMode::automatic;
    std::uint32_t forward_count = 5; ///< 1..8
    std::array<Real, vehicle_gears_max> forward{3.6_r, 2.1_r,   1.4_r,   Real(1),
                                                0.8_r, Real(0), Real(0), Real(0)}; ///< engine turns per turn
    Real reverse = 3.2_r;     ///< 0.001..1000, as all ratios
    Real final_drive = 3.7_r; ///< 0.001..1000
    Real shift_time = 0.3_r;  ///< the clutch is open while a gear changes [s], 0..10
    Real shift_pause = 0.5_r; ///< least time between changes of an automatic box [s], 0..10
    Real rpm_up = Real(5500), rpm_down = Real(2200); ///< where an automatic box changes, rpm_down <= rpm_up
    Real clutch_torque =
        Real(900); ///< most that the clutch carries [N m], 0..1e8; it closes from rpm_idle on, within
                   ///< the next half of it
};

/// A tracked vehicle has two tracks, each of which turns all its wheels alike. The gearbox drives their mean speed;
/// steering gears their difference to the engine (a Merritt-Brown drive), so it turns on the spot in neutral.
struct TrackDef {
    std::uint32_t enabled = 0; ///< 1: tracked; wheels do not steer
    std::uint32_t reserved = 0;
    Real steer_ratio = Real(20); ///< turns of the engine per turn of difference at full steering, 0.001..1e4
    Real steer_torque = Real(100000); ///< most between the tracks [N m], 0..1e8
};

struct VehicleDef {
    BodyId chassis{};              ///< a dynamic body; at most one vehicle
    std::uint32_t wheel_count = 0; ///< 1..8
    WheelCast cast = WheelCast::sphere;
    std::uint32_t category = 0xffffffffu,
                  mask = 0xffffffffu; ///< of what wheels roll on, as QueryFilter has it
    std::array<WheelDef, vehicle_wheels_max> wheel{};
    std::array<Tyre, vehicle_tyres_max> tyre{};
    std::array<AntiRollBar, vehicle_couplings_max> anti_roll{};
    EngineDef engine{};
    GearboxDef gearbox{};
    std::array<Differential, vehicle_couplings_max> differential{};
    TrackDef tracks{};
    Real ackermann = Real(1); ///< 1: steered wheels roll about one point, 0: they stay parallel
    Real steer_speed{};       ///< of the steering wheel [1/s]: from straight to full, 0..1000; 0: at once
    std::uint64_t user_key = 0;
};

/// Held until it is set again.
struct VehicleInput {
    Real throttle{};       ///< 0..1
    Real brake{};          ///< 0..1
    Real steer{};          ///< -1 left .. 1 right
    Real hand_brake{};     ///< 0..1
    Real clutch{};         ///< pedal, 1: open
    std::int32_t gear = 1; ///< see GearboxMode; -1..8
    std::uint32_t reserved = 0;

    friend constexpr bool operator==(const VehicleInput&, const VehicleInput&) = default;
};

/// A wheel after the last tick.
struct WheelState {
    Transform pose;       ///< of the hub, world; x is the axle, y up
    Real rotation;        ///< [rad], 0..2 pi, forwards
    Real spin;            ///< [rad/s]
    Real length;          ///< of the suspension [m]
    Real steer;           ///< [rad], to the left
    Real load;            ///< [N], along the ground's normal, mean of the last substep
    Real along, across;   ///< force of the tyre on the vehicle [N], forwards and to the left
    Real slip, slip_side; ///< as in Tyre, signed
    ShapeId ground;       ///< null: in the air
};
struct VehicleState {
    Real rpm; ///< of the engine
    std::int32_t gear;
    std::uint32_t shifting; ///< 1: between gears
    Real clutch_torque;     ///< that the clutch carries [N m]
    std::uint32_t wheel_count;
    std::array<WheelState, vehicle_wheels_max> wheel;
};

/// Wheels 0 front left, 1 front right, 2 rear left, 3 rear right at (+-hub.x, hub.y, +-hub.z) when the suspension hangs
/// half out. The front steers by 0.6 rad, the rear is driven, and all of them brake.
VehicleDef four_wheels(BodyId chassis, Vec3 hub);
/// Two tracks of `wheels` (1..4; other numbers are clamped) each, at +-hub.x, from hub.z to the front to -hub.z.
VehicleDef two_tracks(BodyId chassis, Vec3 hub, std::uint32_t wheels);
/// Empty when good.
std::string validate(const VehicleDef& def);
std::string validate(const VehicleInput& input);

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

} // namespace lockstone
