// Pointed bodies, shot at a plate, that turn with their tip in it: none passes through, and none sticks in it.
#include "support/random.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

struct Shots {
    int through = 0, stuck = 0;
};

/// Cones that fall on a plate of 100 m at 30 to 120 m/s, in any orientation. Through: the middle of the body is below
/// the plate after two seconds, far from its rim. Stuck: the body has a speed above 10 m/s and does not move.
Shots shoot(const Geometry& cone, double half_thickness, std::uint32_t continuous) {
    RandomPoint random{7};
    Shots found;
    for (int i = 0; i < 40; ++i) {
        WorldDef def = WorldDef{};
        def.sleeping = 0, def.continuous = continuous;
        World w = made(World::create(def));
        add(w, {.kind = BodyKind::static_}, {.geometry = box(50_r, real(half_thickness), 50_r)});
        const double speed = random(30, 120), spin = i % 2 == 0 ? 0.0 : random(0, 20);
        const Quat q = normalized(turned(axis_x, random(0, 360)) * turned(axis_z, random(0, 360)));
        const BodyId body = add(w,
                                {.pose = at(0, random(2, 5), 0, q),
                                 .linear_velocity = vec(random(-0.2, 0.2) * speed, -0.9 * speed, 0),
                                 .angular_velocity = vec(spin, random(-1, 1) * spin, random(-1, 1) * spin)},
                                {.geometry = cone});
        Vec3 last{};
        for (int t = 0; t < 120; ++t) last = w.pose(body).position, w.tick();
        const Vec3 now = w.pose(body).position;
        if (abs(now.x) > 49_r || abs(now.z) > 49_r) continue;
        found.through += now.y < Real{};
        const bool stays =
            length(now - last)<0.001_r, is_fast = length(to<Real>(w.linear_velocity(body)))> 10_r;
        found.stuck += stays && is_fast;
    }
    return found;
}

} // namespace

TEST_CASE("a cone that is shot at a plate never turns through it or stays in it") {
    for (const double half_thickness : {0.0025, 0.025, 0.1}) {
        CAPTURE(half_thickness);
        for (const Geometry& shape : {cone(real(0.1), real(0.3)), cone(real(0.25), real(0.25))}) {
            const Shots found = shoot(shape, half_thickness, 1);
            CHECK(found.through == 0);
            CHECK(found.stuck == 0);
        }
    }
}

TEST_CASE("planted: cones pass through a plate without continuous collision") {
    CHECK(shoot(cone(real(0.1), real(0.3)), 0.0025, 0).through > 0);
}
