// A vehicle in its own world, and its values as doubles.
#pragma once

#include "support/sim_scenes.h"

#include <cmath>

namespace lockstone::test::vehicle {

using namespace lockstone::test::scene;

inline constexpr double g = 9.81, pi_double = 3.14159265358979323846;

/// Relative error.
inline double off(double value, double expected) { return std::abs(value / expected - 1); }

struct Rig {
    World w;
    BodyId chassis;
    VehicleId id;

    void drive(const VehicleInput& input) { done(w.set_vehicle_input(id, input)); }
    void run(int ticks) {
        for (int i = 0; i < ticks; ++i) w.tick();
    }
    VehicleState state() const { return w.vehicle_state(id); }
    D3 at() const { return position(w, chassis); }
    double speed() const { return dot(velocity(w, chassis), ahead()); }
    D3 ahead() const {
        const UnitVec3 z = to_rotation(w.pose(chassis).rotation).z;
        return {to_double(z.x), to_double(z.y), to_double(z.z)};
    }
    /// About the vehicle's long axis [rad].
    double roll() const { return std::asin(to_double(to_rotation(w.pose(chassis).rotation).x.y)); }
};

struct Setting {
    double mass = 1200;
    Transform pose = scene::at(0, 0.8, 0);
    Vec3 half{0.8_r, 0.3_r, 2_r};
    WorldDef world = small_def();
};

/// A car on a plane, or on the ground that `ground` adds.
template <class Change> Rig make_car(const Setting& s, Change&& change) {
    World w = made(World::create(s.world));
    add_floor(w);
    const BodyId body = add(w, {.pose = s.pose, .mass = real(s.mass)}, {.geometry = box(s.half)});
    VehicleDef def = four_wheels(body, vec(0.75, -0.3, 1.4));
    change(def);
    const VehicleId id = made(w.create_vehicle(def));
    return {std::move(w), body, id};
}
inline Rig make_car(const Setting& s = {}) {
    return make_car(s, [](VehicleDef&) {});
}

inline void set_frequency(VehicleDef& def, double hertz) {
    for (WheelDef& wheel : def.wheel) wheel.frequency = real(hertz);
}
/// A tyre that grips by `peak` in all directions, from a slip of 0.05 on.
inline void set_grip(VehicleDef& def, double peak) {
    for (Tyre& t : def.tyre) {
        t.along = {{{0_r, 0_r}, {0.05_r, real(peak)}, {1_r, real(peak)}, {2_r, real(peak)}}};
        t.across = t.along;
        t.rolling_resistance = {};
    }
}
/// An engine with equal torque at every speed and no drag.
inline void set_engine(VehicleDef& def, double torque) {
    def.engine.torque_max = real(torque);
    for (CurvePoint& p : def.engine.torque) p.y = 1_r;
    def.engine.brake_torque = {};
    def.gearbox.mode = GearboxMode::manual;
}

} // namespace lockstone::test::vehicle
