// Motors, springs and friction of joints against what they are defined to do; reactions, torques, and breaking.
#include "support/about.h"
#include "support/one_axis.h"

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

JointAxis motor_axis(double speed, double force) {
    return {.mode = AxisMode::free, .motor_speed = real(speed), .motor_force = real(force)};
}
JointAxis spring_axis(double frequency, double damping_ratio) {
    return {.mode = AxisMode::free,
            .spring = 1,
            .frequency = real(frequency),
            .damping_ratio = real(damping_ratio)};
}

/// Up to speed with its force, no faster, then at its speed; against a load above its force it gives way.
std::string motor_fault(JointAxisIndex axis, double speed, double force, double expected_force,
                        JointKind kind) {
    OneAxis one = one_axis(axis, motor_axis(speed, force), kind);
    one.run(15);
    const double expected = std::copysign(expected_force / one.inertia() * 0.25, speed);
    if (std::abs(one.speed() - expected) > 0.01 * std::abs(expected))
        return "after 0.25 s the speed is " + std::to_string(one.speed()) + ", not " +
               std::to_string(expected);
    one.run(240);
    if (std::abs(one.speed() - speed) > 1e-3 * std::abs(speed))
        return "the speed is " + std::to_string(one.speed());
    one.run(60, -std::copysign(0.9 * expected_force, speed));
    if (std::abs(one.speed() - speed) > 2e-3 * std::abs(speed)) return "a load that it bears slows it";
    const double before = one.speed();
    one.run(30, -std::copysign(1.5 * expected_force, speed));
    const double lost = -std::copysign(0.5 * expected_force / one.inertia() * 0.5, speed);
    if (std::abs(one.speed() - before - lost) > 0.02 * std::abs(lost))
        return "overloaded it changes by " + std::to_string(one.speed() - before) + ", not " +
               std::to_string(lost);
    return {};
}

/// Half periods counted between zeros of an undamped swing, and the static deflection under a load.
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

TEST_CASE("a motor brings its force to bear until it has its speed, and no more than its force") {
    CHECK(motor_fault(about_x, 3, 400, 400, JointKind::hinge) == "");
    CHECK(motor_fault(about_x, -2, 300, 300, JointKind::hinge) == "");
    CHECK(motor_fault(along_x, 1.5, 1500, 1500, JointKind::slider) == "");
    CHECK(motor_fault(along_z, -2, 2500, 2500, JointKind::six_dof) == "");
    CHECK(motor_fault(about_y, 1, 100, 100, JointKind::six_dof) == "");
    CHECK(motor_fault(about_x, 6, 700, 700, JointKind::wheel) == "");
}

TEST_CASE("planted fault: a motor with a tenth more force than told is found out") {
    CHECK(motor_fault(about_x, 3, 440, 400, JointKind::hinge) != "");
    CHECK(motor_fault(along_x, 1.5, 1500, 1350, JointKind::slider) != "");
}

TEST_CASE(
    "a spring swings at its frequency, which is 1 / (2 pi) sqrt(k / m) of the stiffness it shows at rest") {
    for (JointAxisIndex axis : {along_x, along_y, about_x, about_z})
        for (double frequency : {0.5, 1.0, 3.0}) {
            INFO("axis ", axis, ", ", frequency, " Hz");
            const Swing s = swing_of(axis, frequency);
            const double inertia = axis < about_x ? crate_mass : crate_inertia;
            CHECK(s.frequency == test::about(frequency, 0.02));
            CHECK(std::sqrt(s.stiffness / inertia) / (2 * 3.14159265358979) == test::about(frequency, 0.02));
        }
}

TEST_CASE("planted fault: the measure of a swing tells 1 Hz from 1.1 Hz") {
    CHECK(swing_of(along_x, 1.1).frequency != test::about(1.0, 0.02));
    CHECK(std::sqrt(swing_of(along_x, 1.1).stiffness / crate_mass) != test::about(2 * 3.14159265, 0.02));
}

TEST_CASE("a critically damped spring comes to its target without passing it; a bounded one stops where "
          "loads exceed it") {
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

TEST_CASE("friction holds a smaller load at rest and takes its own force from a larger one") {
    for (const auto& [kind, axis] : {std::pair(JointKind::slider, along_x),
                                     {JointKind::hinge, about_x},
                                     {JointKind::six_dof, along_y}}) {
        OneAxis one = one_axis(axis, {.mode = AxisMode::free, .friction = Real(500)}, kind);
        one.run(120, 450);
        CHECK(std::abs(one.position()) < 1e-4);
        one.run(60, 800);
        CHECK(one.speed() == test::about(300 / one.inertia(), 0.01));
        one.run(600);
        CHECK(std::abs(one.speed()) < 1e-4);
    }
    OneAxis slippery = one_axis(along_x, {.mode = AxisMode::free, .friction = Real(400)}, JointKind::slider);
    slippery.run(120, 450); // planted: a friction that is too small for the load
    CHECK(std::abs(slippery.position()) > 1e-4);
}

// ---- reactions ------------------------------------------------------------------------------------------------

TEST_CASE("what holds a weight pulls with m g") {
    struct Case {
        JointDef def;
        double hangs; ///< centre of mass below the joint [m]
    };
    JointDef held_motor = motor_joint(Real(4), Real(100000), Real(100000));
    for (const Case& c : {Case{ball_joint(), 1},
                          {hinge_joint(), 0.6},
                          {weld_joint(), 1},
                          {weld_joint(Real(5)), 0.5},
                          {slider_joint(), 0},
                          {held_motor, 0},
                          {mouse_joint(Real(4), Real(100000)), 0.5},
                          {wheel_joint(Real(3), Real(1)), 0}}) {
        World w = heavy_world();
        const BodyId b = add_crate(w, at(0, -c.hangs, 0));
        const JointId joint = made(w.create_joint(c.def, {}, b, at(0, 0, 0)));
        for (int t = 0; t < 300; ++t) w.tick();
        const JointState s = w.joint_state(joint);
        INFO(std::string(name_of(c.def.kind)), " hanging by ", c.hangs);
        CHECK(to_double(s.force.y) == test::about(crate_mass * 9.81, 0.005));
        CHECK(std::hypot(to_double(s.force.x), to_double(s.force.z)) < 0.005 * crate_mass * 9.81);
        CHECK(length(to_double(s.torque)) < 0.005 * crate_mass * 9.81);
    }
}

TEST_CASE("lines pull with m g, and a pulley's rope with the same force on both sides") {
    for (const JointDef& line :
         {distance_joint(Real(2)), rope_joint(Real(2)), spring_joint(Real(2), Real(3), Real(1))}) {
        World w = heavy_world();
        const BodyId b = add_crate(w, at(0, -2, 0));
        JointDef def = line;
        def.body_b = b;
        const JointId joint = made(w.create_joint(def));
        for (int t = 0; t < 300; ++t) w.tick();
        CHECK(to_double(w.joint_state(joint).force.y) == test::about(crate_mass * 9.81, 0.005));
        CHECK(length(velocity(w, b)) < 1e-3);
    }
    World w = heavy_world();
    const BodyId a = add_crate(w, at(-2, -2, 0)), b = add_crate(w, at(2, -2, 0));
    done(w.set_body_parameters({a, {}, {}, Real(2), 0, 1, 0})); // weighs twice as much
    JointDef rope = pulley_joint(vec(-2, 0, 0), vec(2, 0, 0), Real(4));
    rope.body_a = a, rope.body_b = b;
    const JointId joint = made(w.create_joint(rope));
    for (int t = 0; t < 30; ++t) w.tick();
    // Atwood's machine: a = g (2 - 1) / 2, T = m (g + a).
    CHECK(velocity(w, b)[1] == test::about(9.81 / 2 * 0.5, 0.01));
    CHECK(velocity(w, a)[1] == test::about(-9.81 / 2 * 0.5, 0.01));
    CHECK(to_double(w.joint_state(joint).force.y) == test::about(crate_mass * 1.5 * 9.81, 0.01));
}

TEST_CASE("a cantilever's weld bears m g l, a slider across gravity too, an axle nothing about itself") {
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

// ---- breaking -------------------------------------------------------------------------------------------------

namespace {

/// In how many ticks of 240 the joint broke, which is to say its events, and when first; -1 never.
struct Broken {
    int events = 0, first = -1;
};
Broken hang_until_broken(double break_force, double break_torque, double lever) {
    World w = heavy_world();
    const BodyId b = add_crate(w, lever == 0 ? at(0, -1, 0) : at(lever, 0, 0));
    JointDef def = weld_joint();
    def.break_force = real(break_force), def.break_torque = real(break_torque);
    const JointId joint = made(w.create_joint(def, {}, b, at(0, 0, 0)));
    Broken broken;
    for (int t = 0; t < 240; ++t) {
        w.tick();
        for (const Event& e : w.events()) {
            if (e.kind != EventKind::joint_break) continue;
            ++broken.events;
            if (broken.first < 0) broken.first = t;
            if (e.joint != joint || e.body_b != b || e.body_a || e.tick != static_cast<std::uint64_t>(t))
                return {-1, -1};
        }
        const bool gone = broken.events > 0;
        if (w.is_alive(joint) == gone || w.joint_count() != (gone ? 0u : 1u) || w.joints(b).empty() != gone)
            return {-2, t};
    }
    if (broken.events > 0 && (velocity(w, b)[1] > -5 || w.set_joint_axis(joint, about_x, {}).ok()))
        return {-3, -1};
    return broken;
}

} // namespace

TEST_CASE("a joint breaks once, when it bears more than it can, and is gone") {
    const double weight = crate_mass * 9.81;
    CHECK(hang_until_broken(1.1 * weight, 0, 0).events == 0);
    CHECK(hang_until_broken(0.9 * weight, 0, 0).events == 1);
    CHECK(hang_until_broken(0.9 * weight, 0, 0).first == 0);
    CHECK(hang_until_broken(0, 1.1 * weight, 1).events == 0);
    CHECK(hang_until_broken(0, 0.9 * weight, 1).events == 1);
    CHECK(hang_until_broken(0, 0, 2).events == 0);
}

TEST_CASE("several joints break in one tick in the order of their ids, each with an event") {
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
    const JointId again = made(w.create_joint(ball_joint(), {}, w.body_at(0), at(0, 0, 0)));
    CHECK((again.generation == 2 && !w.is_alive(joints[0])));
}
