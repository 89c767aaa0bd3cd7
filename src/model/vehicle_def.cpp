// Definitions of vehicles: their checks, and two example definitions.
#include "lockstone/play/vehicle.h"
#include "model/fields.h"

#include <algorithm>

namespace lockstone {

using base::join;

namespace {

std::string check_ascending(const char* curve, std::span<const CurvePoint> points) {
    for (std::size_t i = 1; i < points.size(); ++i)
        if (points[i].x < points[i - 1].x) return join(curve, "[", i, "] is left of the point before it");
    return {};
}

/// Checks the wheels as a whole, and the relations between the fields of each wheel.
std::string check_wheels(const VehicleDef& d) {
    std::uint32_t tracks = 0;
    Real share{};
    for (std::uint32_t i = 0; i < d.wheel_count; ++i) {
        const WheelDef& w = d.wheel[i];
        if (w.direction.y >= Unit{}) return join("wheel[", i, "].direction does not point down");
        if (w.length_max < w.length_min)
            return join("wheel[", i, "].length_max is ", to_string(w.length_max), ", less than length_min, ",
                        to_string(w.length_min));
        share += w.drive_share;
        tracks |= 1u << w.track;
    }
    if (share != Real{} && abs(share - Real(1)) >= 0.001_r)
        return "the drive shares of the wheels add up to neither 1 nor 0";
    if (d.tracks.enabled == 1 && tracks != 3) return "a tracked vehicle needs wheels in both tracks";
    return {};
}

/// Checks the wheels that differentials and anti-roll bars connect.
std::string check_couplings(const VehicleDef& d) {
    for (std::uint32_t i = 0; i < vehicle_couplings_max; ++i) {
        const Differential& diff = d.differential[i];
        if (((diff.wheels_a | diff.wheels_b) >> d.wheel_count) != 0)
            return join("differential[", i, "] names a wheel that is not there");
        if ((diff.wheels_a & diff.wheels_b) != 0)
            return join("differential[", i, "] has a wheel on both sides");
        if (std::max(d.anti_roll[i].wheel_a, d.anti_roll[i].wheel_b) >= d.wheel_count)
            return join("anti_roll[", i, "] names a wheel that is not there");
    }
    return {};
}

std::string check_curves(const VehicleDef& d) {
    for (const Tyre& tyre : d.tyre) {
        if (std::string e = check_ascending("tyre.along", tyre.along); !e.empty()) return e;
        if (std::string e = check_ascending("tyre.across", tyre.across); !e.empty()) return e;
    }
    return check_ascending("engine.torque", d.engine.torque);
}

} // namespace

std::string validate(const VehicleDef& d) {
    if (std::string e = sim::check_ranges(d); !e.empty()) return e;
    if (std::string e = check_wheels(d); !e.empty()) return e;
    if (std::string e = check_couplings(d); !e.empty()) return e;
    if (std::string e = check_curves(d); !e.empty()) return e;
    if (d.engine.rpm_idle > d.engine.rpm_max)
        return join("engine.rpm_idle is ", to_string(d.engine.rpm_idle), ", more than rpm_max, ",
                    to_string(d.engine.rpm_max));
    if (d.gearbox.rpm_down > d.gearbox.rpm_up)
        return join("gearbox.rpm_down is ", to_string(d.gearbox.rpm_down), ", more than rpm_up, ",
                    to_string(d.gearbox.rpm_up));
    return {};
}

std::string validate(const VehicleInput& in) { return sim::check_ranges(in); }

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
