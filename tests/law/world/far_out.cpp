// Motion beyond the range of the bounds, 2^(15 + bounds_shift) m from the origin, equals motion near it.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// [m]: contacts exist from this distance on, so a resting body may float by it
constexpr double contact_margin = 0.005;

WorldDef shifted(std::uint32_t bounds_shift) {
    WorldDef def = small_def();
    def.bounds_shift = bounds_shift;
    return def;
}

/// A plane whose body is at x, y, turned about z by degrees; a ball of 0.5 m starts 0.1 m above it. Returns the ball's
/// height after a second [m].
double height_over_plane(double x, double y, double degrees, std::uint32_t bounds_shift) {
    World w = made(World::create(shifted(bounds_shift)));
    const Transform pose = at(x, y, 0, turned(axis_z, degrees));
    add(w, {.kind = BodyKind::static_, .pose = pose}, {.geometry = plane()});
    const UnitVec3 up = to_rotation(pose.rotation).y;
    const BodyId ball =
        add(w, {.pose = {pose.position + lockstone::scale<Real>(up, 0.6_r), Quat::identity()}},
            {.geometry = sphere(0.5_r)});
    for (int t = 0; t < 60; ++t) w.tick();
    return to_double(lockstone::dot<Real>(up, w.pose(ball).position - pose.position));
}

/// A crate rides on a platform that moves along z at x. Returns how far the crate moved on the platform in a second
/// [m].
double strays_on_platform(double x, double speed, std::uint32_t bounds_shift) {
    World w = made(World::create(shifted(bounds_shift)));
    const Vec3 v = vec(0, 0, speed);
    const BodyId platform = add(w, {.kind = BodyKind::kinematic, .pose = at(x, 0, 0), .linear_velocity = v},
                                {.geometry = box(10_r, 1_r, 10_r)});
    const BodyId crate =
        add(w, {.pose = at(x, 1.5, 0), .linear_velocity = v}, {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
    for (int t = 0; t < 60; ++t) w.tick();
    return length(to_double(w.pose(crate).position - w.pose(platform).position - vec(0, 1.5, 0)));
}

} // namespace

TEST_CASE("a plane holds a ball that lies on it at any distance from the origin") {
    for (const std::uint32_t shift : {0u, 4u, 8u})
        for (const double y : {0.0, -33000.0, -40000.0, -1e6, -9e8, 33000.0, 1e6, 9e8}) {
            INFO("shift ", shift, ", y ", y);
            CHECK(std::abs(height_over_plane(0, y, 0, shift) - 0.5) < contact_margin);
        }
    for (const double degrees : {20.0, -20.0, 90.0, 200.0})
        for (const double x : {0.0, 1e5, -1e5})
            for (const double y : {0.0, 1e5, -1e5}) {
                INFO("degrees ", degrees, ", x ", x, ", y ", y);
                // The ball falls away from a plane that is a wall or a ceiling.
                const double height = height_over_plane(x, y, degrees, 0);
                CHECK(height > 0.5 - contact_margin);
                if (std::abs(degrees) < 45) CHECK(height < 0.5 + contact_margin);
            }
}

TEST_CASE("bodies that move together keep their contacts at any distance from the origin") {
    for (const std::uint32_t shift : {0u, 2u})
        for (const double x : {0.0, 30000.0, 40000.0, -40000.0, 200000.0, 9e8, -9e8})
            for (const double speed : {0.0, 2.0, 20.0, 100.0}) {
                INFO("shift ", shift, ", x ", x, ", speed ", speed);
                CHECK(strays_on_platform(x, speed, shift) < contact_margin);
            }
}
