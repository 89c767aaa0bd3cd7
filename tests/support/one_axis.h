// One free axis of a joint, and checks of its limits, motors, friction and springs.
#pragma once

#include "support/rigs/joint_scenes.h"

#include <cmath>
#include <string>

namespace lockstone::test::scene {

/// a box of 1 m with the density of water
inline constexpr double crate_mass = 1000, crate_inertia = 1000.0 / 6;

/// A crate on a joint to the world, at its middle, loaded along or about one axis.
struct OneAxis {
    World world = bare_world();
    BodyId body;
    JointId joint;
    JointAxisIndex axis;

    OneAxis(JointDef def, JointAxisIndex index, const JointAxis& what) : axis(index) {
        def.axis[index] = what;
        body = add_crate(world, at(0, 0, 0));
        joint = made(world.create_joint(def, {}, body, at(0, 0, 0)));
    }
    /// `load` [N] or [N m].
    void run(int ticks, double load = 0) {
        D3 push{};
        push[axis % 3] = load;
        const Vec3 p = vec(push[0], push[1], push[2]);
        for (int t = 0; t < ticks; ++t) {
            done(axis < about_x ? world.add_force(body, p) : world.add_force(body, {}, p));
            world.tick();
        }
    }
    double position() const { return to_double(world.joint_state(joint).position[axis]); }
    double speed() const { return (axis < about_x ? velocity(world, body) : spin(world, body))[axis % 3]; }
    double inertia() const { return axis < about_x ? crate_mass : crate_inertia; }
};

inline bool near(double value, double expected, double tolerance) {
    return std::abs(value - expected) <= tolerance;
}

/// Pushes the object that `make()` returns by `load` to both sides. It must come to rest at -0.3 and 0.5, and never be
/// beyond.
template <class Make> std::string stop_fault(Make&& make, double load) {
    for (const double side : {-1.0, 1.0}) {
        auto one = make();
        double least = 0, most = 0;
        for (int t = 0; t < 120; ++t) {
            one.run(1, side * load);
            least = std::min(least, one.position()), most = std::max(most, one.position());
        }
        if (!near(one.position(), side < 0 ? -0.3 : 0.5, 0.004))
            return "pushed to the side of " + std::to_string(side) + " it rests at " +
                   std::to_string(one.position());
        if (least < -0.305 || most > 0.505) return "it was beyond its limits";
    }
    return {};
}

/// A motor must drive the axis that `make(axis)` returns to 0.5 per second, at 2 per second squared and no faster,
/// against a load of three quarters of its force. A greater load meets the whole force. The unit of a load is the
/// acceleration that it alone would cause. `way`: 1 or -1.
template <class Make> std::string motor_fault(Make&& make, double force, double way) {
    auto one =
        make(JointAxis{.mode = AxisMode::free, .motor_speed = real(0.5 * way), .motor_force = real(force)});
    const auto speed_is = [&](double speed, double tolerance) {
        return near(way * one.speed(), speed, tolerance);
    };
    const auto told = [&] { return std::to_string(way * one.speed()); };
    one.run(6);
    if (!speed_is(0.2, 0.002)) return "after 0.1 s its speed is " + told();
    one.run(30);
    if (!speed_is(0.5, 0.0005)) return "it gets to a speed of " + told();
    one.run(12, -1.5 * way);
    if (!speed_is(0.5, 0.001)) return "a load that it bears slows it to " + told();
    one.run(12, -3 * way);
    if (!speed_is(0.5 - 0.2, 0.004)) return "overloaded it slows to " + told();
    return {};
}

/// The axis has a friction that balances a load of 2. A load of 1.8 must not move it; a load of 3 must accelerate it by
/// the remainder.
template <class Make> std::string friction_fault(Make&& make, double friction) {
    auto one = make(JointAxis{.mode = AxisMode::free, .friction = real(friction)});
    one.run(60, 1.8);
    if (!near(one.position(), 0, 1e-4)) return "it slid by " + std::to_string(one.position());
    one.run(12, 3);
    if (!near(one.speed(), 0.2, 0.002)) return "its speed is " + std::to_string(one.speed());
    one.run(30);
    if (!near(one.speed(), 0, 1e-4)) return "it still moves";
    return {};
}

/// An oscillator after a hit: it must pass zero every half period, and its extremes must shrink by exp(-zeta w t).
template <class One> std::string swing_fault(One& one, double frequency, double damping) {
    constexpr double half_turn = 3.141592653589793;
    double before = one.position(), first = -1, last = -1, highest = 0, lowest = 0;
    int zeros = 0;
    for (int t = 1; t <= 240 && zeros < 3; ++t) {
        one.run(1);
        const double now = one.position();
        if (zeros == 0) highest = std::max(highest, now);
        if (zeros == 1) lowest = std::min(lowest, now);
        if ((before < 0) != (now < 0)) {
            last = t - now / (now - before), ++zeros;
            if (first < 0) first = last;
        }
        before = now;
    }
    if (zeros < 3) return "it does not swing";
    const double root = std::sqrt(1 - damping * damping);
    const double found = 60 / (last - first) / root, ratio = -lowest / highest;
    if (!near(found, frequency, 0.03 * frequency)) return "it swings at " + std::to_string(found) + " Hz";
    if (!near(ratio, std::exp(-half_turn * damping / root), 0.05))
        return "a half swing leaves " + std::to_string(ratio) + " of the last";
    return {};
}

} // namespace lockstone::test::scene
