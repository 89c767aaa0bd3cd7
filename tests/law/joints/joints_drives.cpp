// Motors, springs and friction of joints against their definitions; reactions, torques, and breaking.
#include "support/about.h"
#include "support/one_axis.h"
#include "support/rigs/motor_at_limit.h"

#include <doctest/doctest.h>

#include <string>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// A joint with one axis that is not locked.
OneAxis one_axis(JointAxisIndex index, const JointAxis& what, JointKind kind = JointKind::six_dof) {
    JointDef def = plain_joint(kind);
    if (kind == JointKind::six_dof)
        for (JointAxis& a : def.axis) a = {};
    return OneAxis(def, index, what);
}

JointAxis spring_axis(double frequency, double damping_ratio) {
    return {.mode = AxisMode::free,
            .spring = 1,
            .frequency = real(frequency),
            .damping_ratio = real(damping_ratio)};
}

/// The frequency from the zeros of an undamped swing, and the stiffness from the static deflection under a load.
struct Swing {
    double frequency, stiffness;
};
Swing swing_of(JointAxisIndex axis, double frequency) {
    OneAxis one = one_axis(axis, spring_axis(frequency, 0));
    one.run(1, axis < about_x ? 20000 : 3000);
    const int ticks = static_cast<int>(60 * 10 / frequency);
    double before = one.position(), first = -1, last = -1;
    int zeros = 0;
    for (int t = 1; t <= ticks; ++t) {
        one.run(1);
        const double now = one.position();
        if ((before < 0) != (now < 0)) {
            last = t - now / (now - before), ++zeros;
            if (first < 0) first = last;
        }
        before = now;
    }
    OneAxis loaded = one_axis(axis, spring_axis(frequency, 1));
    const double load = axis < about_x ? 5000 : 500;
    loaded.run(static_cast<int>(60 * 6 / frequency), load);
    return {(zeros - 1) / 2.0 / ((last - first) / 60), load / loaded.position()};
}

} // namespace

TEST_CASE("a spring swings at its frequency which is 1 / (2 pi) sqrt(k / m) of its stiffness at rest") {
    for (JointAxisIndex axis : {along_x, along_y, about_x, about_z})
        for (double frequency : {0.5, 1.0, 3.0}) {
            INFO("axis ", axis, ", ", frequency, " Hz");
            const Swing s = swing_of(axis, frequency);
            const double inertia = axis < about_x ? crate_mass : crate_inertia;
            CHECK(s.frequency == test::about(frequency, 0.02));
            CHECK(std::sqrt(s.stiffness / inertia) / (2 * 3.14159265358979) == test::about(frequency, 0.02));
        }
}

TEST_CASE("planted fault: the measurement of a swing distinguishes 1 Hz from 1.1 Hz") {
    CHECK(swing_of(along_x, 1.1).frequency != test::about(1.0, 0.02));
    CHECK(std::sqrt(swing_of(along_x, 1.1).stiffness / crate_mass) != test::about(2 * 3.14159265, 0.02));
}

TEST_CASE("a critically damped spring reaches its target without overshoot and a bounded spring applies at "
          "most its force") {
    for (JointAxisIndex axis : {along_x, about_x, about_y}) {
        JointAxis spring = spring_axis(2, 1);
        spring.target = real(0.5);
        OneAxis one = one_axis(axis, spring);
        double most = 0;
        for (int t = 0; t < 180; ++t) one.run(1), most = std::max(most, one.position());
        CHECK(one.position() == test::about(0.5, 0.002));
        CHECK(most < 0.502);
        spring.spring_force = Real(100);
        OneAxis bounded = one_axis(axis, spring);
        bounded.run(30);
        CHECK(bounded.speed() == test::about(100 / bounded.inertia() * 0.5, 0.02));
    }
}

// ---- reactions ------------------------------------------------------------------------------------------------

TEST_CASE("a pulley moves its bodies by its ratio and loads both sides of its rope in that ratio") {
    for (const double ratio : {1.0, 2.0}) {
        INFO("ratio ", ratio);
        World w = heavy_world();
        const BodyId a = add_crate(w, at(-2, -2, 0)), b = add_crate(w, at(2, -2, 0));
        done(w.set_body_parameters({a, {}, {}, Real(2), 0, 1, 0})); // doubles its weight
        const double length = 2 + 2 * ratio;
        JointDef rope = pulley_joint(vec(-2, 0, 0), vec(2, 0, 0), real(length), real(ratio));
        rope.body_a = a, rope.body_b = b;
        const JointId joint = made(w.create_joint(rope));
        for (int t = 0; t < 30; ++t) w.tick();
        // Atwood's machine: a rises by `ratio` times the descent of b, and the force on b is `ratio` times that on a.
        const double rise = 9.81 * (2 * ratio - 1) / (1 + ratio * ratio);
        CHECK(velocity(w, b)[1] == test::about(rise * 0.5, 0.01));
        CHECK(velocity(w, a)[1] == test::about(-ratio * velocity(w, b)[1], 1e-3));
        CHECK(to_double(w.joint_state(joint).force.y) == test::about(crate_mass * (9.81 + rise), 0.01));
        CHECK(to_double(w.joint_state(joint).position[along_x]) == test::about(length, 1e-4));
    }
}

TEST_CASE("a cantilever's weld and slider bear the torque m g l and a hinge bears no torque about its axis") {
    for (double lever : {0.5, 1.0, 3.0}) {
        for (const JointDef& def : {weld_joint(), slider_joint()}) {
            World w = heavy_world();
            const BodyId b = add_crate(w, at(lever, 0, 0));
            const JointId joint = made(w.create_joint(def, {}, b, at(0, 0, 0)));
            for (int t = 0; t < 120; ++t) w.tick();
            const D3 torque = to_double(w.joint_state(joint).torque);
            INFO(std::string(name_of(def.kind)), ", lever ", lever);
            CHECK(torque[2] == test::about(crate_mass * 9.81 * lever, 0.01));
            CHECK(std::hypot(torque[0], torque[1]) < 0.01 * crate_mass * 9.81 * lever);
        }
    }
    World w = heavy_world();
    const BodyId b = add_crate(w, at(1, 0, 0));
    const JointId joint = made(w.create_joint(hinge_joint(), {}, b, at(0, 0, 0, turned(axis_y, -90))));
    for (int t = 0; t < 20; ++t) {
        w.tick();
        CHECK(std::abs(to_double(w.joint_state(joint).torque.z)) < 1);
    }
}

TEST_CASE("joints that break in one tick break in the order of their ids with one event each") {
    World w = heavy_world();
    std::vector<JointId> joints;
    for (int i = 0; i < 4; ++i) {
        const BodyId b = add_crate(w, at(3 * i, -1, 0));
        JointDef def = ball_joint();
        def.break_force = i == 2 ? Real(20000) : Real(5000);
        joints.push_back(made(w.create_joint(def, {}, b, at(3 * i, 0, 0))));
    }
    w.tick();
    std::vector<JointId> broken;
    for (const Event& e : w.events())
        if (e.kind == EventKind::joint_break) broken.push_back(e.joint);
    CHECK((broken == std::vector<JointId>{joints[0], joints[1], joints[3]}));
    CHECK(w.is_alive(joints[2]));
    CHECK(w.joint_count() == 1);
    CHECK(w.joints(w.body_at(0)).empty());
    const JointId again = made(w.create_joint(ball_joint(), {}, w.body_at(0), at(0, 0, 0)));
    CHECK((again.generation == 2 && !w.is_alive(joints[0])));
}

TEST_CASE("a limit holds against a motor or a spring of any force") {
    CHECK(lockstone::test::limits_fault() == "");
}
