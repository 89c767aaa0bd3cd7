// Definitions of vehicles: what they may say, and two to begin with.
#include "base/text.h"
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"
#include "lockstone/play/vehicle.h"

#include <algorithm>

namespace lockstone {

using base::join;

namespace {

/// Keeps the first complaint.
struct Check {
    std::string error;

    void range(const char* of, std::uint32_t index, const char* what, Real value, Real low, Real high) {
        if (!error.empty() || (value >= low && value <= high)) return;
        const std::string place = index == none ? join(of, what) : join(of, "[", index, "].", what);
        error = join(place, " is ", to_string(value), ", must be ", to_string(low), " to ", to_string(high));
    }
    void range(const char* what, Real value, Real low, Real high) { range("", none, what, value, low, high); }
    void count(const char* what, std::uint32_t value, std::uint32_t low, std::uint32_t high) {
        if (error.empty() && (value < low || value > high))
            error = join(what, " is ", value, ", must be ", low, " to ", high);
    }
    template <std::size_t N>
    void curve(const char* what, const std::array<CurvePoint, N>& points, Real high) {
        for (std::size_t i = 0; i < N && error.empty(); ++i) {
            const CurvePoint& p = points[i];
            if (p.x < Real{} || p.x > Real(1000) || p.y < Real{} || p.y > high)
                error = join(what, " point ", i, " is out of range: x 0 to 1000, y 0 to ", to_string(high));
            else if (i > 0 && p.x < points[i - 1].x)
                error = join(what, " point ", i, " is left of the one before it");
        }
    }
    void that(bool holds, const char* sentence) {
        if (error.empty() && !holds) error = sentence;
    }

    static constexpr std::uint32_t none = 0xffffffffu;
};

constexpr Real torque_limit = Real(100000000);

void check_wheel(Check& c, const VehicleDef& d, std::uint32_t i) {
    const WheelDef& w = d.wheel[i];
    const auto range = [&](const char* what, Real value, Real low, Real high) {
        c.range("wheel", i, what, value, low, high);
    };
    range("attachment.x", w.attachment.x, Real(-64), Real(64));
    range("attachment.y", w.attachment.y, Real(-64), Real(64));
    range("attachment.z", w.attachment.z, Real(-64), Real(64));
    const std::int64_t square = dot<Real>(w.direction, w.direction).raw;
    c.that(square > (std::int64_t{1} << 32) - (std::int64_t{1} << 22) &&
               square < (std::int64_t{1} << 32) + (std::int64_t{1} << 22),
           "a wheel's direction is not of length 1");
    c.that(w.direction.y < Unit{}, "a wheel's direction does not point down");
    c.count("a wheel's tyre", w.tyre, 0, vehicle_tyres_max - 1);
    range("length_min", w.length_min, Real{}, Real(4));
    range("length_max", w.length_max, w.length_min, Real(4));
    range("preload", w.preload, Real{}, Real(4));
    range("frequency", w.frequency, 0.1_r, Real(50));
    range("damping_compression", w.damping_compression, Real{}, Real(10));
    range("damping_rebound", w.damping_rebound, Real{}, Real(10));
    range("radius", w.radius, 0.01_r, Real(10));
    range("width", w.width, 0.01_r, Real(10));
    range("inertia", w.inertia, 0.001_r, Real(1000000));
    range("steer_max", w.steer_max, -1.3_r, 1.3_r);
    range("drive_share", w.drive_share, Real{}, Real(1));
    range("brake_torque", w.brake_torque, Real{}, torque_limit);
    range("hand_brake_torque", w.hand_brake_torque, Real{}, torque_limit);
    c.count("a wheel's track", w.track, 0, 1);
    c.that(w.reserved == 0, "a wheel's reserved is not 0");
}

void check_train(Check& c, const VehicleDef& d) {
    const EngineDef& e = d.engine;
    c.range("engine.torque_max", e.torque_max, Real{}, Real(10000000));
    c.curve("engine.torque", e.torque, Real(10));
    c.range("engine.inertia", e.inertia, 0.001_r, Real(100000));
    c.range("engine.rpm_max", e.rpm_max, Real(10), Real(100000));
    c.range("engine.rpm_idle", e.rpm_idle, Real(1), e.rpm_max);
    c.range("engine.brake_torque", e.brake_torque, Real{}, Real(10000000));
    const GearboxDef& g = d.gearbox;
    c.that(g.mode <= GearboxMode::manual, "gearbox.mode must be 0 or 1");
    c.count("gearbox.forward_count", g.forward_count, 1, vehicle_gears_max);
    for (std::uint32_t i = 0; i < std::min(g.forward_count, vehicle_gears_max); ++i)
        c.range("gearbox.forward", i, "ratio", g.forward[i], 0.001_r, Real(1000));
    c.range("gearbox.reverse", g.reverse, 0.001_r, Real(1000));
    c.range("gearbox.final_drive", g.final_drive, 0.001_r, Real(1000));
    c.range("gearbox.shift_time", g.shift_time, Real{}, Real(10));
    c.range("gearbox.shift_pause", g.shift_pause, Real{}, Real(10));
    c.range("gearbox.rpm_up", g.rpm_up, Real(1), Real(100000));
    c.range("gearbox.rpm_down", g.rpm_down, Real{}, g.rpm_up);
    c.range("gearbox.clutch_torque", g.clutch_torque, Real{}, torque_limit);
    for (std::uint32_t i = 0; i < vehicle_couplings_max; ++i) {
        const Differential& diff = d.differential[i];
        c.that(diff.kind <= DifferentialKind::locked, "a differential's kind must be 0 to 2");
        c.that(((diff.wheels_a | diff.wheels_b) >> std::min(d.wheel_count, vehicle_wheels_max)) == 0,
               "a differential names a wheel that is not there");
        c.that((diff.wheels_a & diff.wheels_b) == 0, "a differential has a wheel on both sides");
        c.that(diff.reserved == 0, "a differential's reserved is not 0");
        c.range("differential", i, "preload", diff.preload, Real{}, torque_limit);
        c.range("differential", i, "bias", diff.bias, Real{}, Real(10));
        const AntiRollBar& bar = d.anti_roll[i];
        c.that(bar.wheel_a < d.wheel_count && bar.wheel_b < d.wheel_count,
               "an anti-roll bar names a wheel that is not there");
        c.range("anti_roll", i, "stiffness", bar.stiffness, Real{}, Real(1000000000));
    }
    c.count("tracks.enabled", d.tracks.enabled, 0, 1);
    c.that(d.tracks.reserved == 0, "tracks.reserved is not 0");
    c.range("tracks.steer_ratio", d.tracks.steer_ratio, 0.001_r, Real(10000));
    c.range("tracks.steer_torque", d.tracks.steer_torque, Real{}, torque_limit);
}

} // namespace

std::string validate(const VehicleDef& d) {
    Check c;
    c.count("wheel_count", d.wheel_count, 1, vehicle_wheels_max);
    c.that(d.cast <= WheelCast::cylinder, "cast must be 0 to 2");
    std::uint32_t tracks = 0;
    Real share{};
    for (std::uint32_t i = 0; i < std::min(d.wheel_count, vehicle_wheels_max); ++i) {
        check_wheel(c, d, i);
        share += d.wheel[i].drive_share;
        tracks |= 1u << (d.wheel[i].track & 1u);
    }
    c.that(share == Real{} || abs(share - Real(1)) < 0.001_r,
           "the drive shares of the wheels add up to neither 1 nor 0");
    c.that(d.tracks.enabled == 0 || tracks == 3, "a tracked vehicle needs wheels in both tracks");
    for (const Tyre& t : d.tyre) {
        c.curve("tyre.along", t.along, Real(10));
        c.curve("tyre.across", t.across, Real(10));
        c.range("tyre.ground_friction", t.ground_friction, 0.01_r, Real(4));
        c.range("tyre.rolling_resistance", t.rolling_resistance, Real{}, Real(1));
    }
    check_train(c, d);
    c.range("ackermann", d.ackermann, Real{}, Real(1));
    c.range("steer_speed", d.steer_speed, Real{}, Real(1000));
    return c.error;
}

std::string validate(const VehicleInput& in) {
    Check c;
    c.range("throttle", in.throttle, Real{}, Real(1));
    c.range("brake", in.brake, Real{}, Real(1));
    c.range("steer", in.steer, Real(-1), Real(1));
    c.range("hand_brake", in.hand_brake, Real{}, Real(1));
    c.range("clutch", in.clutch, Real{}, Real(1));
    c.that(in.gear >= -1 && in.gear <= static_cast<std::int32_t>(vehicle_gears_max), "gear must be -1 to 8");
    c.that(in.reserved == 0, "reserved is not 0");
    return c.error;
}

VehicleDef four_wheels(BodyId chassis, Vec3 hub) {
    VehicleDef d;
    d.chassis = chassis;
    d.wheel_count = 4;
    for (std::uint32_t i = 0; i < 4; ++i) {
        WheelDef& w = d.wheel[i];
        const bool front = i < 2;
        w.attachment = {i % 2 == 0 ? hub.x : -hub.x, hub.y + half(w.length_min + w.length_max),
                        front ? hub.z : -hub.z};
        w.steer_max = front ? 0.6_r : Real{};
        w.drive_share = front ? Real{} : half(Real(1));
        w.brake_torque = front ? Real(1500) : Real(600);
        w.hand_brake_torque = front ? Real{} : Real(4000);
    }
    return d;
}

VehicleDef two_tracks(BodyId chassis, Vec3 hub, std::uint32_t wheels) {
    VehicleDef d;
    d.chassis = chassis;
    wheels = std::clamp(wheels, 1u, vehicle_wheels_max / 2);
    d.wheel_count = 2 * wheels;
    d.tracks.enabled = 1;
    for (std::uint32_t i = 0; i < d.wheel_count; ++i) {
        WheelDef& w = d.wheel[i];
        w.track = i % 2;
        const Real along = wheels > 1 ? Real(i / 2) / Real(wheels - 1) : half(Real(1));
        w.attachment = {w.track == 0 ? hub.x : -hub.x, hub.y + half(w.length_min + w.length_max),
                        hub.z - hub.z * 2 * along};
        w.inertia = Real(10);
        w.brake_torque = Real(15000);
        w.hand_brake_torque = Real(15000);
    }
    for (Tyre& t : d.tyre) {
        t.rolling_resistance = 0.03_r;
        t.across = {{{Real(0), Real(0)}, {0.3_r, 0.6_r}, {Real(1), 0.6_r}, {Real(2), 0.6_r}}};
    }
    d.engine.torque_max = Real(2000);
    d.engine.inertia = Real(3);
    d.engine.rpm_idle = Real(500);
    d.engine.rpm_max = Real(3000);
    d.engine.brake_torque = Real(300);
    d.gearbox.rpm_up = Real(2500);
    d.gearbox.rpm_down = Real(1000);
    d.gearbox.clutch_torque = Real(5000);
    d.gearbox.final_drive = Real(8);
    return d;
}

} // namespace lockstone
