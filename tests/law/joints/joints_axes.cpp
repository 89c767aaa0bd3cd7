// Limits, motors, springs and friction of every kind of joint on each axis that it leaves free. joints_lines.cpp has
// those of lines.
#include "support/about.h"
#include "support/one_axis.h"
#include "support/rigs/joint_variants.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double full_turn = 6.283185307179586;

struct FreeAxis {
    const char* name;
    JointDef def;
    JointAxisIndex axis;
};

JointDef steered_wheel() {
    JointDef def = wheel_joint(Real(2), Real(1));
    def.axis[about_y].mode = AxisMode::free;
    return def;
}
/// The free axes of each kind, without the springs that some kinds have.
std::vector<FreeAxis> free_axes_of_kinds() {
    std::vector<FreeAxis> all{{"hinge", hinge_joint(), about_x},
                              {"slider", slider_joint(), along_x},
                              {"ball, twist", ball_joint(), about_x},
                              {"ball, about y", ball_joint(), about_y},
                              {"ball, about z", ball_joint(), about_z},
                              {"wheel, suspension", steered_wheel(), along_y},
                              {"wheel, steering", steered_wheel(), about_y},
                              {"wheel, spin", steered_wheel(), about_x}};
    for (std::uint32_t i = 0; i < joint_axis_count; ++i) {
        JointDef one = six_dof_joint(), motor = motor_joint(Real(1), {}, {});
        for (std::uint32_t k = 0; k < joint_axis_count; ++k)
            if (k != i) one.axis[k].mode = AxisMode::locked;
        const auto axis = static_cast<JointAxisIndex>(i);
        all.push_back({"six_dof", one, axis});
        all.push_back({"motor", motor, axis});
        if (i < about_x) all.push_back({"mouse", mouse_joint(Real(1), {}), axis});
    }
    return all;
}

double inertia_of(JointAxisIndex axis) { return axis < about_x ? crate_mass : crate_inertia; }

/// Loads are given as the acceleration that they alone would cause [m/s^2] or [rad/s^2].
struct Axis : OneAxis {
    Axis(const FreeAxis& which, const JointAxis& what) : OneAxis(which.def, which.axis, what) {}
    void run(int ticks, double load = 0) { OneAxis::run(ticks, load * inertia()); }
};

std::string limit_fault(const FreeAxis& which, double lower, double upper) {
    return stop_fault(
        [&] { return Axis(which, {.mode = AxisMode::limited, .lower = real(lower), .upper = real(upper)}); },
        2);
}

std::string motor_fault(const FreeAxis& which, double strength) {
    return test::scene::motor_fault([&](const JointAxis& axis) { return Axis(which, axis); },
                                    strength * inertia_of(which.axis), 1);
}

std::string friction_fault(const FreeAxis& which, double strength) {
    return test::scene::friction_fault([&](const JointAxis& axis) { return Axis(which, axis); },
                                       strength * inertia_of(which.axis));
}

std::string spring_fault(const FreeAxis& which, double frequency, double told_frequency, double damping,
                         double told_damping) {
    JointAxis axis = which.def.axis[which.axis];
    axis.spring = 1, axis.frequency = real(frequency), axis.damping_ratio = real(damping);
    axis.spring_force = {};
    Axis one(which, axis);
    one.run(1, 60 * 0.4 * frequency);
    return swing_fault(one, told_frequency, told_damping);
}

/// The greatest change of a hinge's angle in a tick [rad], while B turns at `speed` from one of its wide limits to the
/// other.
double longest_step(double speed) {
    World w = bare_world();
    JointDef def = hinge_joint();
    def.axis[about_x].mode = AxisMode::limited;
    def.axis[about_x].lower = real(-0.2), def.axis[about_x].upper = real(4);
    const BodyId b = add_crate(w, at(0, 0, 0));
    const JointId joint = made(w.create_joint(def, {}, b, at(0, 0, 0)));
    done(w.set_velocity(b, {}, vec(speed, 0, 0)));
    double last = 0, most = 0;
    for (int t = 0; t < 150; ++t) {
        w.tick();
        const double now = to_double(w.joint_state(joint).position[about_x]);
        most = std::max(most, std::abs(now - last));
        last = now;
    }
    return most;
}

} // namespace

TEST_CASE("limits work on every axis that a kind of joint leaves free") {
    for (const FreeAxis& which : free_axes_of_kinds()) {
        INFO(std::string(which.name), ", axis ", which.axis);
        CHECK(limit_fault(which, -0.3, 0.5) == "");
    }
}

TEST_CASE("motors work on every axis that a kind of joint leaves free") {
    for (const FreeAxis& which : free_axes_of_kinds()) {
        INFO(std::string(which.name), ", axis ", which.axis);
        CHECK(motor_fault(which, 2) == "");
    }
}

TEST_CASE("friction works on every axis that a kind of joint leaves free") {
    for (const FreeAxis& which : free_axes_of_kinds()) {
        INFO(std::string(which.name), ", axis ", which.axis);
        CHECK(friction_fault(which, 2) == "");
    }
}

TEST_CASE("springs on free axes and soft locks swing at their frequency and lose the energy that their "
          "damping takes") {
    std::vector<FreeAxis> all = free_axes_of_kinds();
    for (std::uint32_t i = 0; i < joint_axis_count; ++i)
        all.push_back({"weld, soft", weld_joint(Real(2)), static_cast<JointAxisIndex>(i)});
    for (const FreeAxis& which : all) {
        INFO(std::string(which.name), ", axis ", which.axis);
        CHECK(spring_fault(which, 1.5, 1.5, 0, 0) == "");
        CHECK(spring_fault(which, 1.5, 1.5, 0.2, 0.2) == "");
    }
}

TEST_CASE("a hinge reports its angle without jumps from one limit to the other even beyond a half turn") {
    CHECK(longest_step(2) < 0.05); // 2 / 60 a tick
}

TEST_CASE(
    "planted fault: the checks report limits and motors and friction and springs that are slightly wrong") {
    for (const FreeAxis& which : free_axes_of_kinds()) {
        INFO(std::string(which.name), ", axis ", which.axis);
        CHECK(limit_fault(which, -0.3, 0.51) != "");
        CHECK(motor_fault(which, 2.1) != "");
        CHECK(friction_fault(which, 1.7) != "");
        CHECK(spring_fault(which, 1.6, 1.5, 0.2, 0.2) != "");
        CHECK(spring_fault(which, 1.5, 1.5, 0.1, 0.2) != "");
    }
}

TEST_CASE("a motor joint drives a body to a pose relative to another body and holds it there") {
    const D3 way{0.4, -0.3, 0.2}, turn{0.5, 0.4, -0.6};
    JointDef def = motor_joint(Real(3), Real(100000), Real(50000));
    for (std::uint32_t i = 0; i < joint_axis_count; ++i)
        def.axis[i].target = real(i < 3 ? way[i] : turn[i - 3]);
    Jointed j = join_two(JointKind::motor, def, turned(axis_z, 40));
    done(j.world.set_velocity(j.a, vec(0.3, 0.1, 0), vec(0, 0.2, 0.1)));
    for (int t = 0; t < 240; ++t) j.world.tick();
    const Offset o = offset_of(j.world, j.joint);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(o.along[i] == test::about(way[i], 0.01));
        CHECK(o.about[i] == test::about(turn[i], 0.01));
    }
    JointDef idle = motor_joint(Real(3), Real(100000), Real(50000)); // planted fault: no target
    Jointed k = join_two(JointKind::motor, idle, turned(axis_z, 40));
    for (int t = 0; t < 60; ++t) k.world.tick();
    CHECK(length(offset_of(k.world, k.joint).along) < 0.01);
}

TEST_CASE("a motor joint applies at most its force and its torque") {
    JointDef def = motor_joint(Real(5), Real(500), Real(50));
    def.axis[along_y].target = Real(3), def.axis[about_z].target = Real(2);
    World w = bare_world();
    const BodyId b = add_crate(w, at(0, 0, 0));
    made(w.create_joint(def, {}, b, at(0, 0, 0)));
    for (int t = 0; t < 30; ++t) w.tick();
    CHECK(velocity(w, b)[1] == test::about(0.5 * 500 / crate_mass, 0.02));
    CHECK(spin(w, b)[2] == test::about(0.5 * 50 / crate_inertia, 0.02));
}

TEST_CASE("a mouse joint pulls a body to its target with at most its force and leaves its rotation free") {
    World w = bare_world();
    const BodyId b = add_crate(w, at(0, 0, 0));
    const JointId joint = made(w.create_joint(mouse_joint(Real(3), Real(2000)), {}, b, at(0, 0, 0)));
    done(w.set_joint_frames(joint, at(20, 0, -1), Transform::identity()));
    done(w.set_velocity(b, {}, vec(0.7, 0.7, 0)));
    for (int t = 0; t < 30; ++t) w.tick();
    CHECK(velocity(w, b)[0] == test::about(0.5 * 2000 / crate_mass, 0.01));
    done(w.set_joint_frames(joint, at(1, 0.5, -1), Transform::identity()));
    for (int t = 0; t < 240; ++t) w.tick();
    CHECK(length(offset_of(w, joint).along) < 0.005);
    CHECK(length(spin(w, b) - D3{0.7, 0.7, 0}) < 1e-3);
}

TEST_CASE("a wheel joint turns about its own axle while it is steered and its suspension yields") {
    JointDef def = steered_wheel();
    def.axis[about_x].motor_speed = Real(5), def.axis[about_x].motor_force = Real(2000);
    def.axis[about_y] = {.mode = AxisMode::limited,
                         .spring = 1,
                         .lower = real(-0.6),
                         .upper = real(0.6),
                         .frequency = Real(3)};
    World w = heavy_world();
    const BodyId b = add_crate(w, at(0, 0, 0));
    const JointId joint = made(w.create_joint(def, {}, b, at(0, 0, 0)));
    for (const double angle : {0.4, -0.4, 0.9}) { // the last one is beyond the limit
        def.axis[about_y].target = real(angle);
        done(w.set_joint_axis(joint, about_y, def.axis[about_y]));
        for (int t = 0; t < 180; ++t) w.tick();
        const JointState s = w.joint_state(joint);
        const double expected = std::min(angle, 0.6);
        CHECK(to_double(s.position[about_y]) == test::about(expected, 0.03));
        const Place wheel = place_of(w, b, w.joint(joint).frame_b);
        const D3 axle{std::cos(expected), 0, -std::sin(expected)};
        CHECK(angle_between(wheel.axes[0], axle) < 0.02);
        CHECK(dot(spin(w, b), axle) == test::about(5, 0.02));
        CHECK(to_double(s.position[along_y]) == test::about(-9.81 / std::pow(full_turn * 2, 2), 0.03));
    }
}

TEST_CASE("planted fault: the check reports the angle steps of a hinge that turns ten times as fast") {
    CHECK(longest_step(20) > 0.05);
}

namespace {

/// A body of 5 cm that spins on a hinge about the world's x axis, without a load, for a second.
struct Spun {
    double told = 0;   ///< the joint's angle [rad]
    double turned = 0; ///< integral of the body's spin [rad]
    double most = 0;   ///< largest absolute angle of the joint after a tick
    double spin = 0;   ///< at the end [rad/s]
};
Spun spin_hinge(const JointDef& def, double speed, bool base_spins = false) {
    World w = made(World::create(weightless()));
    const auto add_wheel = [&](double x, double rate) {
        return add(w, {.pose = at(x, 0, 0), .angular_velocity = vec(rate, 0, 0)},
                   {.geometry = sphere(0.05_r)});
    };
    const BodyId a = base_spins ? add_wheel(-0.2, -speed / 2) : BodyId{};
    const BodyId b = add_wheel(0, base_spins ? speed / 2 : speed);
    if (base_spins) made(w.create_joint(hinge_joint(), {}, a, at(-0.2, 0, 0)));
    const JointId joint = made(w.create_joint(def, a, b, at(0, 0, 0)));
    Spun out;
    for (int t = 0; t < 60; ++t) {
        w.tick();
        out.spin = spin(w, b)[0] - (base_spins ? spin(w, a)[0] : 0);
        out.turned += out.spin / 60;
        out.told = to_double(w.joint_state(joint).position[about_x]);
        out.most = std::max(out.most, std::abs(out.told));
    }
    return out;
}

} // namespace

TEST_CASE("a hinge counts its turns however fast it spins") {
    JointDef wide = hinge_joint(), wheel = wheel_joint(Real(5), Real(1));
    wide.axis[about_x] = {.mode = AxisMode::limited, .lower = -1000000_r, .upper = 1000000_r};
    for (const JointDef& def : {hinge_joint(), wide, wheel})
        for (const double speed : {10.0, 150.0, 180.0, -200.0, 300.0, 377.0, 500.0, -800.0, 1500.0, 3000.0})
            for (const bool base_spins : {false, true}) {
                INFO(std::string(name_of(def.kind)), ", speed ", speed, ", base spins ", base_spins);
                const Spun s = spin_hinge(def, speed, base_spins);
                CHECK(s.spin == test::about(speed, 1e-3));
                CHECK(std::abs(s.told - s.turned) < 0.5); // a lost turn is 6.28 rad
            }
}

TEST_CASE("a hinge stops at its limits however fast it spins") {
    for (const double limit : {0.5, 1.5, 3.5, 20.0, 40.0})
        for (const double speed : {50.0, 150.0, 180.0, -200.0, 250.0, 300.0, 380.0, -500.0}) {
            INFO("limit ", limit, ", speed ", speed);
            JointDef def = hinge_joint();
            def.axis[about_x] = {.mode = AxisMode::limited, .lower = real(-limit), .upper = real(limit)};
            const Spun s = spin_hinge(def, speed);
            CHECK(std::abs(s.spin) < 1);
            CHECK(s.most < limit + std::abs(speed) / (60 * 8) + 0.05); // at most a substep's motion beyond
        }
}
