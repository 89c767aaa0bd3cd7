// The effects of joints on bodies: free and locked axes, momentum, limits, motors, springs, and the edges of the
// ranges.
#include "support/about.h"
#include "support/rigs/joint_rig.h"

#include <doctest/doctest.h>

#include <cstring>

using namespace lockstone;
using namespace lockstone::test::rig;

namespace {

const D3 brick{0.3, 0.25, 0.2};

/// A joint whose free axes have no limits, and the axes that it locks.
struct Kind {
    const char* name;
    JointDef def;
    std::array<bool, 6> taken;
    double stray = 2e-3; ///< how far a locked axis may drift under the impulses of the test
};

std::vector<Kind> kinds() {
    JointDef universal = six_dof_joint();
    for (std::uint32_t i : {0u, 1u, 2u, 3u}) universal.axis[i].mode = AxisMode::locked;
    JointDef planar = six_dof_joint();
    planar.axis[along_z].mode = planar.axis[about_x].mode = planar.axis[about_y].mode = AxisMode::locked;
    JointDef wheel = wheel_joint(real(4), real(0.7));
    return {{"six_dof", six_dof_joint(), {}},
            {"ball", ball_joint(), {true, true, true, false, false, false}},
            {"hinge", hinge_joint(), {true, true, true, false, true, true}},
            {"slider", slider_joint(), {false, true, true, true, true, true}},
            {"weld", weld_joint(), {true, true, true, true, true, true}},
            {"wheel", wheel, {true, false, true, false, true, true}},
            {"universal", universal, {true, true, true, true, false, false}},
            {"planar", planar, {false, false, true, true, true, false}}};
}

/// Two moving bodies, joined at a place that is the centre of neither.
Rig thrown(const JointDef& def, std::uint32_t& joint, double kg_b = 2) {
    Rig rig;
    rig.gravity = {};
    const std::uint32_t a = rig.add(1, brick, {0, 0, 0}, turn({1, 2, 3}, 0.4));
    const std::uint32_t b = rig.add(kg_b, {0.2, 0.3, 0.25}, {0.8, 0.1, -0.2}, turn({3, -1, 1}, 1.1));
    joint = rig.join(def, a, b, {0.4, 0.1, 0}, turn({1, 1, -2}, 0.7));
    rig.velocity[a] = {to<Speed>(vec(1, -0.5, 0.3)), to<Speed>(vec(0.5, 1, -2))};
    rig.velocity[b] = {to<Speed>(vec(0.4, 0.2, -0.6)), to<Speed>(vec(-1, 0.7, 1.2))};
    return rig;
}

double stray(Rig& rig, std::uint32_t joint, const std::array<bool, 6>& taken, bool of_taken, int ticks) {
    double worst = 0;
    for (int t = 0; t < ticks; ++t) {
        rig.tick();
        for (std::uint32_t i = 0; i < 6; ++i)
            if (taken[i] == of_taken) worst = std::max(worst, std::abs(rig.coordinate(joint, i)));
    }
    return worst;
}

} // namespace

TEST_CASE("each kind of joint locks its axes and leaves the others free") {
    for (const Kind& kind : kinds()) {
        CAPTURE(std::string(kind.name));
        std::uint32_t joint = 0;
        Rig rig = thrown(kind.def, joint);
        CHECK(stray(rig, joint, kind.taken, true, 30) < kind.stray);
        for (std::uint32_t i = 0; i < 6; ++i) {
            CAPTURE(i);
            if (!kind.taken[i]) CHECK(std::abs(rig.coordinate(joint, i)) > 2e-3);
        }
    }
}

TEST_CASE("planted fault: bodies without the joint stray on the axes that it should lock") {
    for (const Kind& kind : kinds()) {
        if (kind.name == std::string("six_dof")) continue;
        CAPTURE(std::string(kind.name));
        std::uint32_t joint = 0;
        Rig rig = thrown(six_dof_joint(), joint);
        CHECK(stray(rig, joint, kind.taken, true, 30) > 10 * kind.stray);
    }
}

namespace {

/// The relative gain of momentum and of angular momentum of two moving bodies in a second.
double momentum_gain(const JointDef& def, double kg_b, bool push) {
    std::uint32_t joint = 0;
    Rig rig = thrown(def, joint, kg_b);
    const D3 before = rig.momentum(), spin = rig.angular_momentum();
    for (int t = 0; t < 60; ++t) {
        if (push) rig.force[0].force = vec(0.1, 0, 0);
        rig.tick();
    }
    const double scale = 1 + kg_b;
    return std::max(length(rig.momentum() - before), length(rig.angular_momentum() - spin)) / scale;
}

std::vector<JointDef> free_standing() {
    JointDef drive = hinge_joint();
    drive.axis[about_x].motor_speed = real(5), drive.axis[about_x].motor_force = real(3);
    JointDef limited = hinge_joint();
    limited.axis[about_x] = {.mode = AxisMode::limited, .lower = real(-0.1), .upper = real(0.1)};
    JointDef cone = ball_joint();
    cone.swing = real(0.2);
    std::vector<JointDef> defs{drive,
                               limited,
                               cone,
                               distance_joint(real(0.7)),
                               rope_joint(real(0.2)),
                               spring_joint(real(0.5), real(3), real(0.3)),
                               motor_joint(real(3), real(50), real(20)),
                               weld_joint(real(4), real(0.5)),
                               mouse_joint(real(5), real(30)),
                               gear_joint(real(-2))};
    for (const Kind& kind : kinds()) defs.push_back(kind.def);
    return defs;
}

} // namespace

TEST_CASE("joints conserve momentum and angular momentum at any masses") {
    for (const JointDef& def : free_standing())
        for (double kg : {0.01, 2.0, 500.0}) {
            CAPTURE(std::string(name_of(def.kind)));
            CAPTURE(kg);
            const double gain = momentum_gain(def, kg, false);
            // A gear's shafts have no bearings here, so its torques do not cancel.
            if (def.kind != JointKind::gear) CHECK(gain < 2e-3);
        }
    CHECK(momentum_gain(ball_joint(), 2, true) > 2e-3); // planted fault: an external push
}

TEST_CASE("a pendulum at 10 rad/s keeps its energy within a thousandth for a second") {
    Rig rig;
    rig.gravity = {};
    const std::uint32_t b = rig.add(1, {0.3, 0.3, 0.3}, {0.5, 0, 0});
    const std::uint32_t j =
        rig.join(hinge_joint(), Rig::world, b, {0, 0, 0}, turn({0, 1, 0}, -1.57079632679));
    rig.velocity[b] = {to<Speed>(vec(0, 5, 0)), to<Speed>(vec(0, 0, 10))};
    const double before = rig.energy();
    rig.run(60);
    CHECK(rig.energy() / before == test::about(1, 1e-3)); // 6e-3 without the prediction along the arc
    CHECK(rig.gap(j) < 2e-4);
    CHECK(std::abs(rig.coordinate(j, about_x)) == test::about(10, 2e-3));
    const double force = length(d3(rig.memory[j].force)); // m w^2 r
    CHECK(force == test::about(50, 1e-2));
}

TEST_CASE("a wheel on a hinge through its centre keeps its spin") {
    Rig rig;
    const std::uint32_t b = rig.add(3, {0.3, 0.2, 0.2}, {0, 0, 0});
    const std::uint32_t j = rig.join(hinge_joint(), Rig::world, b, {0, 0, 0});
    rig.velocity[b].angular = to<Speed>(vec(40, 0, 0));
    rig.run(600);
    CHECK(rig.w(b)[0] == test::about(40, 1e-4));
    CHECK(rig.gap(j) < 1e-3);
    CHECK(to_double(rig.memory[j].force.y) == test::about(3 * 9.81, 1e-3));
    CHECK(rig.coordinate(j, about_x) == test::about(400, 1e-3)); // counts 64 turns
}

TEST_CASE("springs on the six axes come to rest at their targets") {
    JointDef def = six_dof_joint();
    const double at[6] = {0.3, -0.2, 0.1, 0.4, -0.3, 0.2};
    for (std::size_t i = 0; i < 6; ++i)
        def.axis[i] = {.mode = AxisMode::free, .spring = 1, .frequency = real(3), .target = real(at[i])};
    Rig rig;
    rig.gravity = {};
    const std::uint32_t b = rig.add(2, brick, {0, 0, 0});
    const std::uint32_t j = rig.join(def, Rig::world, b, {0.1, 0, 0});
    rig.run(300);
    for (std::uint32_t i = 0; i < 3; ++i) CHECK(rig.coordinate(j, i) == test::about(at[i], 1e-3));
    const Quat target = integrate_rotation(Quat::identity(), vec(at[3], at[4], at[5]));
    CHECK(length(d3(target_between(Quat::identity(), rig.frame_b(j).rotation, vec(at[3], at[4], at[5])))) <
          1e-3);
    CHECK(std::abs(to_double(target.w) - to_double(rig.frame_b(j).rotation.w)) < 1e-3);
}

TEST_CASE("a distance joint keeps its length and a rope does not stretch but may hang slack") {
    for (const bool rope : {false, true}) {
        Rig rig;
        const std::uint32_t b = rig.add(1, brick, {rope ? 0.5 : 1.0, 0, 0});
        JointDef def = rope ? rope_joint(real(1)) : distance_joint(real(1));
        const std::uint32_t j = rig.join_as_is(def, Rig::world, b);
        double longest = 0, shortest = 9;
        for (int t = 0; t < 120; ++t) {
            rig.tick();
            longest = std::max(longest, rig.coordinate(j, along_x));
            shortest = std::min(shortest, rig.coordinate(j, along_x));
        }
        CHECK(longest < 1.002);
        if (rope)
            CHECK(shortest < 0.6);
        else
            CHECK(shortest > 0.998);
    }
}

TEST_CASE("gears and racks keep their ratio for a hundred turns") {
    Rig rig;
    rig.gravity = {};
    const std::uint32_t a = rig.add(1, brick, {0, 0, 0}), b = rig.add(2, brick, {1, 0, 0});
    const std::uint32_t c = rig.add(1, brick, {0, 1, 0});
    JointDef drive = hinge_joint();
    drive.axis[about_x].motor_speed = real(31.4), drive.axis[about_x].motor_force = real(50);
    const std::uint32_t ja = rig.join(drive, Rig::world, a, {0, 0, 0});
    const std::uint32_t jb = rig.join(hinge_joint(), Rig::world, b, {1, 0, 0});
    const std::uint32_t jc = rig.join(slider_joint(), Rig::world, c, {0, 1, 0});
    JointDef gear = gear_joint(real(2));
    rig.join(gear, a, b, {0, 0, 0});
    rig.join(rack_and_pinion_joint(real(8)), a, c, {0, 0, 0});
    rig.run(60 * 20);
    const double turned = rig.coordinate(ja, about_x);
    CHECK(turned > 600);
    CHECK(std::abs(turned + 2 * rig.coordinate(jb, about_x)) < 1e-2);
    CHECK(std::abs(turned - 8 * rig.coordinate(jc, along_x)) < 1e-2);
    rig.defs[3].ratio = real(2.001); // planted fault: a wrong ratio
    rig.run(60 * 20);
    CHECK(std::abs(rig.coordinate(ja, about_x) + 2 * rig.coordinate(jb, about_x)) > 0.1);
}

// ---- the edges of the ranges --------------------------------------------------------------------------------------

TEST_CASE("joints of bodies at the ends of all ranges keep speeds within range") {
    for (const JointDef& made : free_standing())
        for (const auto& [kg_a, kg_b, gyration, lever] : {std::array{1e-3, 1e9, 1e-3, 100.0},
                                                          {1e9, 1e-3, 1e4, 1e6},
                                                          {1.0, 1e4, 1.0, 1e5},
                                                          {1e-3, 1e-3, 1e-3, 0.0},
                                                          {0.0, 0.0, 1.0, 1.0},
                                                          {0.0, 1.0, 1e-3, 100.0}}) {
            CAPTURE(std::string(name_of(made.kind)));
            const double kg = kg_a; // clang 14: a lambda cannot capture a structured binding
            CAPTURE(kg);
            JointDef def = made;
            Rig rig;
            const std::uint32_t a = rig.add(kg_a, {gyration, gyration, 2 * gyration}, {1e9 - 1, 0, -1e9 + 1});
            const std::uint32_t b =
                rig.add(kg_b, {gyration, gyration, gyration}, {-1e9 + 1, 5, 0}, turn({0, 1, 0}, 3.14159265));
            def.frame_a.position = vec(lever, -lever, lever), def.frame_b.position = vec(0, lever, 0);
            def.axis[0].motor_force = def.axis[3].motor_force = real(2e9);
            def.axis[0].motor_speed = def.axis[3].motor_speed = real(-500);
            rig.join_as_is(def, a, b);
            rig.join_as_is(def, Rig::world, b);
            rig.traits[b].locks = 63;
            rig.run(3);
            rig.traits[b].locks = 21;
            rig.pose[b] = {rig.pose[a].position, turn({0, 1, 0}, 3.14159265)};
            rig.run(3);
            for (std::uint32_t body = 0; body < 2; ++body) CHECK(length(rig.v(body)) < 1775);
        }
}

TEST_CASE("joints recover from lines of zero length and from axes that are reversed") {
    Rig rig;
    rig.gravity = {};
    const std::uint32_t a = rig.add(1, brick, {0, 0, 0}), b = rig.add(1, brick, {0, 0, 0});
    const std::uint32_t line = rig.join_as_is(distance_joint(real(1)), a, b);
    rig.run(240);
    CHECK(rig.coordinate(line, along_x) == test::about(1, 1e-2));

    Rig round;
    round.gravity = {};
    const std::uint32_t c = round.add(1, brick, {0, 0, 0}, turn({0, 1, 0}, 3.14159265));
    const std::uint32_t hinge = round.join_as_is(hinge_joint(), Rig::world, c);
    round.run(240);
    CHECK(to_double(to_rotation(round.frame_b(hinge).rotation).x.x) > 0.9999);

    Rig upside;
    upside.gravity = {};
    const std::uint32_t d = upside.add(1, brick, {0, 0, 0}, turn({1, 1, 0}, 3.14159265));
    const std::uint32_t weld = upside.join_as_is(weld_joint(), Rig::world, d);
    upside.run(240);
    CHECK(std::abs(to_double(upside.frame_b(weld).rotation.w)) > 0.9999);
}
