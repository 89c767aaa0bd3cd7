// Limits and motors about axes that are far from their load: a limit stops a weight on an arm and does not throw it
// back, and a motor turns it at the motor's speed. The solver treats the point and the axis of a hinge together
// (solve/joints/axis_with_point.h).
#include "support/rigs/joint_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double pull = 10; // [m/s^2], downwards along z

World pulled() {
    WorldDef def = bare_def();
    def.gravity = vec(0, 0, -pull);
    return made(World::create(def));
}

/// A box of 0.2 x 2 half x 0.2 m on a hinge about x; the hinge is `arm` away from the box's middle, along -y. The arm
/// starts horizontal.
struct Arm {
    World world = pulled();
    BodyId weight;
    double half, arm;
    Arm(double half_length, double arm_length, JointAxis about) : half(half_length), arm(arm_length) {
        weight = add(world, {.pose = at(0, arm, 0)}, {.geometry = box(vec(0.1, half, 0.1))});
        JointDef hinge = hinge_joint();
        hinge.body_b = weight, hinge.frame_b.position = vec(0, -arm, 0);
        hinge.axis[about_x] = about;
        made(world.create_joint(hinge));
    }
    double angle() const {
        const auto q = to_double(world.pose(weight).rotation);
        return 2 * std::atan2(q[0], q[3]);
    }
    double rate() const { return to_double(world.angular_velocity(weight))[0]; }
};

JointAxis limited(double most) {
    return {.mode = AxisMode::limited, .lower = real(-most), .upper = real(most)};
}
JointAxis driven(double speed) {
    return {.mode = AxisMode::free, .motor_speed = real(speed), .motor_force = real(100000)};
}

struct Stop {
    double beyond; ///< [rad] beyond its limit
    double back;   ///< [rad] back from there
};
/// An arm falls onto a limit of a radian.
Stop stop_of(Arm&& a) {
    double least = 0, back = 0;
    for (int tick = 0; tick < 240; ++tick) {
        a.world.tick();
        least = std::min(least, a.angle());
        if (least < -0.99) back = std::max(back, a.angle() - least);
    }
    REQUIRE(least < -0.99);
    return {-1 - least, back};
}

/// A box of 2 `size` m on a ball joint, 0.3 m beyond the middle of an arm of 1 m.
struct Flail : Arm {
    BodyId ball;
    double size;
    Flail(double half_length, double ball_size) : Arm(half_length, 1, limited(1)), size(ball_size) {
        ball = add(world, {.pose = at(0, 1.3, 0)}, {.geometry = box(vec(size, size, size))});
        JointDef joint = ball_joint();
        joint.body_a = weight, joint.body_b = ball, joint.frame_a.position = vec(0, 0.3, 0);
        made(world.create_joint(joint));
    }
    /// The energy about x and in height of a box of `mass` with these half sizes along y and z [J].
    double energy(BodyId body, double mass, double y, double z) const {
        const auto v = to_double(world.linear_velocity(body)), w = to_double(world.angular_velocity(body));
        const double moved = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        return mass * (moved / 2 + (y * y + z * z) / 6 * w[0] * w[0] + pull * position(world, body)[2]);
    }
    /// [J]; zero at the start.
    double energy() const {
        const double mass = 8000 * 0.1 * half * 0.1, heavy = 8000 * size * size * size;
        return energy(weight, mass, half, 0.1) + energy(ball, heavy, size, size);
    }
};

} // namespace

// In Bullet 3.24, whose limits do not bounce either, the first arm passes its limit by 0.064 rad and comes back by
// 0.08.
TEST_CASE("a limit stops an arm that falls onto it and does not throw it back") {
    const Stop even = stop_of(Arm(0.5, 1, limited(1)));
    CHECK(even.beyond < 0.005);
    CHECK(even.back < 0.005);
    const Stop short_arm = stop_of(Arm(0.5, 0.5, limited(1)));
    CHECK(short_arm.beyond < 0.005);
    CHECK(short_arm.back < 0.005);
}

// Without the point's share the arms pass the limit by 0.13 to 0.2 rad, and come back by 0.8 to 1.1.
TEST_CASE("a limit stops a small weight on a long arm within eight substeps and does not throw it back") {
    for (const auto& weight : {std::pair{0.1, 1.0}, {0.02, 1.0}, {0.2, 3.0}}) {
        const double half = weight.first, arm = weight.second;
        const double speed = std::sqrt(2 * pull * std::sin(1.0) / arm); // of a point mass
        const Stop stop = stop_of(Arm(half, arm, limited(1)));
        CAPTURE(half);
        CHECK(stop.beyond < 8 * speed / 240);
        CHECK(stop.back < 8 * speed / 240 + 0.01);
    }
}

TEST_CASE(
    "a motor turns an arm at its speed from the first tick and a small weight on a long arm after 1/3 s") {
    Arm even(0.5, 1, driven(2));
    for (int tick = 0; tick < 120; ++tick) {
        even.world.tick();
        CHECK(std::abs(even.rate() - 2) < 0.01);
    }
    for (const double half : {0.1, 0.02}) {
        Arm small(half, 1, driven(2));
        for (int tick = 0; tick < 120; ++tick) {
            small.world.tick();
            if (tick >= 20) CHECK(std::abs(small.rate() - 2) < 0.02);
        }
    }
}

// Flails whose ball is a few times as heavy as the arm are trees (0.1, 0.3; 0.1, 0.2; 0.5, 0.25). Without the point's
// share in limits these gained 25, 218 and 1.7 times the energy of their fall.
TEST_CASE("a flail that falls onto a limit gains no energy with any arm and any ball") {
    constexpr std::pair<double, double> all[] = {{0.3, 0.2}, {0.1, 0.3},  {0.1, 0.2}, {0.5, 0.1},
                                                 {0.1, 0.1}, {0.1, 0.05}, {0.3, 0.1}, {0.5, 0.25},
                                                 {0.2, 0.1}, {0.05, 0.05}};
    for (const auto& one : all) {
        const double half = one.first, size = one.second;
        Flail flail(half, size);
        double most = 0, least_angle = 0;
        for (int tick = 0; tick < 240; ++tick) {
            flail.world.tick();
            most = std::max(most, flail.energy());
            least_angle = std::min(least_angle, flail.angle());
        }
        CAPTURE(half);
        CAPTURE(size);
        const double fall =
            pull * (8000 * 0.1 * half * 0.1 + 1.3 * 8000 * size * size * size) * std::sin(1.0);
        CHECK(most < 0.005 * fall);
        CHECK(least_angle > -1.15);
    }
}
