// Fast bodies and one-way shapes: a sweep stops bodies that come from the side of +y, and no others.
#include "support/random.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double half_platform = 1.5, half_thickness = 0.005;

struct Setting {
    BodyKind kind = BodyKind::static_; ///< of the platform
    bool from_above = true;            ///< the body moves towards the platform's -y, in the platform's frame
    bool platform_flies = false;       ///< the platform moves and the body is at rest
    std::uint32_t one_way = 1, continuous = 1;
};

/// Returns whether the way between two places, in the platform's axes, passes through the platform.
bool crosses(D3 before, D3 after) {
    if ((before[1] > 0) == (after[1] > 0)) return false;
    const D3 at = before + before[1] / (before[1] - after[1]) * (after - before);
    return std::abs(at[0]) < half_platform && std::abs(at[2]) < half_platform;
}

struct Tally {
    int shots = 0, through = 0, slowed = 0; ///< slowed: lost a hundredth of its speed
};

/// Balls, capsules and cubes of 1 to 5 cm and a thin platform, in random orientations, that meet at 60 to 490 m/s.
Tally shoot(const Setting& setting, int count) {
    RandomPoint random(17);
    Tally tally;
    for (int i = 0; i < count; ++i) {
        WorldDef def = weightless();
        def.continuous = setting.continuous;
        World w = made(World::create(def));
        const Transform pose{vec3(random.point(5, -5, 5)), random.rotation()};
        const double side = setting.from_above ? 1 : -1, speed = random(60, 400);
        const Vec3 way = rotate(pose.rotation, vec(random(-0.5, 0.5), -side, random(-0.5, 0.5)));
        const Vec3 velocity = way * real(speed);
        const Vec3 start = vec(random(-0.3, 0.3), side * random(0.3, 1), random(-0.3, 0.3));
        const BodyId platform =
            add(w,
                {.kind = setting.kind,
                 .pose = pose,
                 .linear_velocity = setting.platform_flies ? -velocity : Vec3{}},
                {.geometry = box(real(half_platform), real(half_thickness), real(half_platform)),
                 .one_way = setting.one_way});
        const Real size = real(random(0.01, 0.05));
        const Geometry shapes[] = {sphere(size), capsule(size, size), box(size, size, size)};
        const BodyId shot = add(w,
                                {.pose = {pose.position + rotate(pose.rotation, start), random.rotation()},
                                 .linear_velocity = setting.platform_flies ? Vec3{} : velocity,
                                 .angular_velocity = vec3(random(0, 30) * random.direction())},
                                {.geometry = shapes[i % 3]});
        const auto seen = [&] { return to_double(inverse_mul(w.pose(platform), w.center_of_mass(shot))); };
        D3 before = seen();
        bool through = false;
        for (int t = 0; t < 10; ++t) {
            w.tick();
            const D3 after = seen();
            through |= crosses(before, after);
            before = after;
        }
        const D3 relative = to_double(w.linear_velocity(shot) - w.linear_velocity(platform));
        ++tally.shots;
        tally.through += through;
        tally.slowed +=
            dot(relative, to_double(velocity)) < 0.99 * dot(to_double(velocity), to_double(velocity));
    }
    return tally;
}

/// Returns a sentence unless the platform stopped every body from above, or let every body from below pass unslowed.
std::string complaint(const Setting& setting, int count) {
    const Tally t = shoot(setting, count);
    const bool right = setting.from_above ? t.through == 0 : t.through == t.shots && t.slowed == 0;
    if (right) return {};
    return std::to_string(t.through) + " of " + std::to_string(t.shots) + " went through, " +
           std::to_string(t.slowed) + " slower than before";
}

} // namespace

TEST_CASE("a one-way platform stops a shot from above and lets a shot from below pass at its full speed") {
    const int count = samples(60, 2000);
    CHECK(complaint({.from_above = true}, count) == "");
    CHECK(complaint({.from_above = false}, count) == "");
}

TEST_CASE("a moving one-way platform hits bodies above it and passes bodies below it") {
    const int count = samples(60, 2000);
    CHECK(complaint({.kind = BodyKind::kinematic, .from_above = true, .platform_flies = true}, count) == "");
    CHECK(complaint({.kind = BodyKind::kinematic, .from_above = false, .platform_flies = true}, count) == "");
}

TEST_CASE("planted: the test detects a platform that stops both sides and a platform without a sweep") {
    CHECK(complaint({.from_above = false, .one_way = 0}, 30) != "");
    CHECK(complaint({.from_above = true, .continuous = 0}, 30) != "");
}
