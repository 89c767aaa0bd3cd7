// Lines and ratios: limits, motors, springs and friction of distances and pulleys. Gears and racks have none of their
// own and transmit those of their shafts.
#include "support/about.h"
#include "support/one_axis.h"
#include "support/rigs/joint_variants.h"

#include <doctest/doctest.h>

#include <string>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double start = 2;

/// A crate on a line of 2 m, or two crates on a pulley, without gravity. The load pulls all crates.
struct Line {
    World world = bare_world();
    BodyId a{}, b;
    JointId joint;
    bool is_pulley;

    Line(JointKind kind, const JointAxis& what) : is_pulley(kind == JointKind::pulley) {
        b = add_crate(world, at(0, -start, 0));
        JointDef def = distance_joint(real(start));
        if (is_pulley) {
            a = add_crate(world, at(4, -start, 0));
            def = pulley_joint(vec(4, 0, 0), {}, real(2 * start));
        }
        def.axis[along_x] = what;
        def.body_a = a, def.body_b = b;
        joint = made(world.create_joint(def));
    }
    /// The inertia against a change of the length [kg].
    double inertia() const { return is_pulley ? crate_mass / 2 : crate_mass; }
    /// `load`: the acceleration of the length that the load alone would cause [m/s^2].
    void run(int ticks, double load = 0) {
        const Vec3 p = vec(0, -load * inertia(), 0);
        for (int t = 0; t < ticks; ++t) {
            done(world.add_force(b, p));
            if (is_pulley) done(world.add_force(a, p));
            world.tick();
        }
    }
    double position() const {
        return to_double(world.joint_state(joint).position[along_x]) - (is_pulley ? 2 : 1) * start;
    }
    double speed() const { return -velocity(world, b)[1] - (is_pulley ? velocity(world, a)[1] : 0); }
};

/// A length relative to the initial one.
Real beyond(JointKind kind, double way) { return real((kind == JointKind::pulley ? 2 : 1) * start + way); }

std::string limit_fault(JointKind kind, double lower, double upper) {
    const auto make = [&] {
        return Line(kind,
                    {.mode = AxisMode::limited, .lower = beyond(kind, lower), .upper = beyond(kind, upper)});
    };
    return stop_fault(make, 1);
}

double inertia_of(JointKind kind) { return kind == JointKind::pulley ? crate_mass / 2 : crate_mass; }

/// Tests a winch.
std::string motor_fault(JointKind kind, double strength) {
    return test::scene::motor_fault([&](const JointAxis& axis) { return Line(kind, axis); },
                                    strength * inertia_of(kind), -1);
}

std::string friction_fault(JointKind kind, double strength) {
    return test::scene::friction_fault([&](const JointAxis& axis) { return Line(kind, axis); },
                                       strength * inertia_of(kind));
}

std::string spring_fault(JointKind kind, double frequency, double told_frequency, double damping,
                         double told_damping) {
    Line line(kind, {.mode = AxisMode::free,
                     .spring = 1,
                     .frequency = real(frequency),
                     .damping_ratio = real(damping),
                     .target = beyond(kind, 0)});
    line.run(1, 60 * 0.8 * frequency);
    return swing_fault(line, told_frequency, told_damping);
}

} // namespace

TEST_CASE("a distance joint and a pulley limit the length of their line below and above") {
    for (JointKind kind : {JointKind::distance, JointKind::pulley}) CHECK(limit_fault(kind, -0.3, 0.5) == "");
}

TEST_CASE("a motor winds the line of a distance joint and the rope of a pulley") {
    for (JointKind kind : {JointKind::distance, JointKind::pulley}) CHECK(motor_fault(kind, 2) == "");
}

TEST_CASE("friction works on the line of a distance joint and on the rope of a pulley") {
    for (JointKind kind : {JointKind::distance, JointKind::pulley}) CHECK(friction_fault(kind, 2) == "");
}

TEST_CASE(
    "springs on the lines of distance joints and pulleys swing with their frequency and their damping") {
    for (JointKind kind : {JointKind::distance, JointKind::pulley}) {
        CHECK(spring_fault(kind, 1.5, 1.5, 0, 0) == "");
        CHECK(spring_fault(kind, 1.5, 1.5, 0.2, 0.2) == "");
    }
}

TEST_CASE(
    "planted fault: the checks report slightly wrong limits and motors and friction and springs of lines") {
    for (JointKind kind : {JointKind::distance, JointKind::pulley}) {
        CHECK(limit_fault(kind, -0.3, 0.51) != "");
        CHECK(motor_fault(kind, 2.1) != "");
        CHECK(friction_fault(kind, 1.7) != "");
        CHECK(spring_fault(kind, 1.6, 1.5, 0.2, 0.2) != "");
        CHECK(spring_fault(kind, 1.5, 1.5, 0.1, 0.2) != "");
    }
}

TEST_CASE("a spring with limits swings between them and a slack rope pulls no body") {
    Line spring(JointKind::distance, {.mode = AxisMode::limited,
                                      .spring = 1,
                                      .lower = real(1.8),
                                      .upper = real(2.2),
                                      .frequency = real(0.5),
                                      .damping_ratio = real(0.1),
                                      .target = real(2)});
    spring.run(20, 6);
    CHECK(spring.position() == test::about(0.2, 0.02));
    spring.run(40, -6); // 22 of these ticks lead from one end to the other
    CHECK(spring.position() == test::about(-0.2, 0.02));
    spring.run(600);
    CHECK(std::abs(spring.position()) < 0.01);
    for (JointKind kind : {JointKind::distance, JointKind::pulley}) {
        Line slack(kind, {.mode = AxisMode::limited, .upper = beyond(kind, 1)});
        slack.run(12, 1);
        CHECK(slack.speed() == test::about(0.2, 0.001));
        CHECK(length(to_double(slack.world.joint_state(slack.joint).force)) == 0);
    }
}

// ---- ratios ---------------------------------------------------------------------------------------------------

namespace {

/// Applies a torque about B's shaft, or a force along B's rail. Returns the angle of A's shaft.
double shaft_after(const JointDef& joint, const JointAxis& shaft, double load, int ticks,
                   double* other = nullptr) {
    Jointed j = join_two(joint.kind, joint);
    done(j.world.set_joint_axis(j.axle_a, about_x, shaft));
    const bool gear = joint.kind == JointKind::gear;
    const Vec3 pull = vec(load, 0, 0);
    for (int t = 0; t < ticks; ++t) {
        done(gear ? j.world.add_force(j.b, {}, pull) : j.world.add_force(j.b, pull));
        j.world.tick();
    }
    const double way = to_double(j.world.joint_state(j.axle_b).position[gear ? about_x : along_x]);
    if (other != nullptr) *other = way;
    return to_double(j.world.joint_state(j.axle_a).position[about_x]);
}

} // namespace

TEST_CASE("gears and racks transmit the limits and motors and springs and friction of their shafts") {
    for (const JointDef& joint : {gear_joint(Real(2)), rack_and_pinion_joint(Real(2))}) {
        INFO(std::string(name_of(joint.kind)));
        const double sign = joint.kind == JointKind::gear ? -1 : 1;
        double way = 0;
        shaft_after(joint, {.mode = AxisMode::limited, .lower = Real(-1), .upper = Real(1)}, 400, 240, &way);
        CHECK(way == test::about(0.5, 0.01));
        shaft_after(joint, {.mode = AxisMode::free, .motor_speed = Real(1), .motor_force = Real(2000)}, -10,
                    240, &way);
        CHECK(way == test::about(sign * 4 / 2, 0.03));
        shaft_after(joint, {.mode = AxisMode::free, .friction = Real(230)}, 400, 240, &way);
        CHECK(std::abs(way) < 1e-3); // half of the load acts on the shaft
        shaft_after(joint, {.mode = AxisMode::free, .friction = Real(170)}, 400, 240, &way);
        CHECK(way > 0.1); // planted: too little friction
        const JointAxis spring{.mode = AxisMode::free, .spring = 1, .frequency = Real(1)};
        const double stiffness = 1000.0 / 6 * std::pow(2 * 3.14159265358979, 2);
        CHECK(shaft_after(joint, spring, 400, 600) == test::about(sign * 400 / 2 / stiffness, 0.02));
    }
}
