// Restitution against its closed forms: the speeds at which bodies part, their energy, and the friction of the rebound.
#include "support/about.h"
#include "support/effort.h"
#include "support/rigs/elastic.h"

#include <doctest/doctest.h>

#include <cstdio>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double speed_step = 1.0 / (1 << 19);
/// A speed is rounded in each of two passes of up to 16 substeps, once for the stop and once for the rebound.
constexpr double rounding = 64 * speed_step;

WorldDef usual_def() {
    WorldDef def; // few substeps: a body moves far in one of them
    def.bodies_max = def.shapes_max = 8, def.contacts_max = 64;
    def.sleeping = 0;
    return def;
}
ShapeDef bouncing(Geometry geometry, double restitution, double friction = 0) {
    return {.geometry = geometry, .friction = real(friction), .restitution = real(restitution)};
}

/// Returns the largest error of the parting speed, which is e times the closing speed of two equal balls, over
/// different moments of the touch within a tick.
double worst_parting(double restitution, double speed, std::uint32_t substeps) {
    double worst = 0;
    for (int i = 0; i < 100; ++i) {
        WorldDef def = weightless(usual_def());
        def.substeps = substeps;
        World w = made(World::create(def));
        const double gap = 0.1 + i * 0.00137;
        const BodyId a = add(w, {.pose = at(-0.5 - gap, 0, 0), .linear_velocity = vec(speed, 0, 0)},
                             bouncing(sphere(0.5_r), restitution));
        const BodyId b = add(w, {.pose = at(0.5, 0, 0)}, bouncing(sphere(0.5_r), restitution));
        for (int t = 0; t < 20; ++t) w.tick();
        const double parting = velocity(w, b)[0] - velocity(w, a)[0];
        worst = std::max(worst, std::abs(parting - restitution * speed));
    }
    return worst;
}

/// The least and the greatest energy after one impact on a plane, relative to that before it, over `rounds` different
/// falls.
struct Span {
    double least = 1e9, most = 0;
};
Span energy_after(Geometry geometry, double restitution, int rounds) {
    Span span;
    for (int i = 0; i < rounds; ++i) {
        World w = made(World::create(weightless(usual_def())));
        add_floor(w, bouncing(plane(), restitution));
        const Quat turn = turned(axis_z, 37 * i) * turned(axis_x, 23 * i + 7);
        const BodyId b =
            add(w, {.pose = at(0, 1 + 0.013 * (i % 23), 0, turn), .linear_velocity = vec(0, -2 - i % 7, 0)},
                bouncing(geometry, restitution));
        const double before = to_double(w.kinetic_energy());
        bool touched = false;
        for (int t = 0; t < 60 && !touched; ++t) {
            w.tick();
            touched = length(velocity(w, b) - D3{0, -2.0 - i % 7, 0}) > 0.01;
        }
        REQUIRE(touched);
        const double ratio = to_double(w.kinetic_energy()) / before;
        span = {std::min(span.least, ratio), std::max(span.most, ratio)};
    }
    return span;
}
/// Both bodies have equal inertia about all axes, so a turn within a tick does not change their energy.
const Geometry cube = box(0.4_r, 0.4_r, 0.4_r),
               log_of_wood = cylinder(real(0.4), real(0.4 * 0.8660254037844386));

struct Slide {
    /// the ball's loss of speed along the floor, and the speed at which its lowest point then slides
    double lost, slip;
};
/// A ball arrives at 10 m/s along the floor and 5 m/s down.
Slide slide(double restitution, double friction) {
    World w = made(World::create(weightless(usual_def())));
    add_floor(w, bouncing(plane(), restitution, friction));
    const BodyId b = add(w, {.pose = at(0, 1.3, 0), .linear_velocity = vec(10, -5, 0)},
                         bouncing(sphere(0.5_r), restitution, friction));
    for (int t = 0; t < 60 && velocity(w, b)[1] < -4.99; ++t) w.tick();
    const double left = velocity(w, b)[0];
    return {10 - left, left + 0.5 * spin(w, b)[2]};
}

} // namespace

TEST_CASE("restitution: two balls part at the coefficient times their speed at any time of touch in a tick") {
    for (double e : {0.5, 1.0})
        for (double speed : {1.2, 1.5, 5.0})
            for (const std::uint32_t substeps : {1u, 4u}) {
                INFO("restitution ", e, ", ", speed, " m/s, substeps ", substeps);
                CHECK(worst_parting(e, speed, substeps) < rounding);
            }
}

TEST_CASE("restitution: a body that falls on several points gains no energy") {
    // An energy's relative error is twice that of a speed, and the least speed is 2 m/s.
    const double gain = 2 * rounding / 2;
    for (const Geometry& geometry : {cube, log_of_wood})
        for (double e : {0.5, 1.0}) {
            const Span span = energy_after(geometry, e, 200);
            std::printf("  restitution %.1f: from %.4f to %.6f of the energy after an impact\n", e,
                        span.least, span.most);
            CHECK(span.most < 1 + gain);
        }
}

TEST_CASE("restitution: a body that falls flat leaves at the coefficient times its speed") {
    for (double e : {0.5, 1.0})
        for (int i = 0; i < 60; ++i) {
            World w = made(World::create(weightless(usual_def())));
            add_floor(w, bouncing(plane(), e));
            const BodyId b = add(w, {.pose = at(0, 0.6 + i * 0.00137, 0), .linear_velocity = vec(0, -3, 0)},
                                 bouncing(cube, e));
            for (int t = 0; t < 12; ++t) w.tick();
            INFO("restitution ", e, ", way ", i);
            CHECK(std::abs(velocity(w, b)[1] - 3 * e) < rounding);
            CHECK(length(spin(w, b)) < 10 * rounding);
        }
}

TEST_CASE("restitution: the bounce impulse causes friction that at most ends the sliding") {
    for (double e : {0.0, 0.5, 1.0})
        for (double friction : {0.1, 0.2}) {
            const Slide out = slide(e, friction);
            INFO("restitution ", e, ", friction ", friction);
            // Coulomb: the friction impulse is friction times the normal impulse, (1 + e) 5 m/s. It reduces the sliding
            // by 3.5 times that, which is less than 10 m/s.
            CHECK(std::abs(out.lost - friction * (1 + e) * 5) < rounding);
            CHECK(out.slip > 0);
        }
    // This friction ends the sliding. Then the ball rolls, and no impulse drives it back.
    const Slide held = slide(1, 1);
    CHECK(held.slip > -rounding);
    CHECK(held.lost < 10 / 3.5 + rounding);
}

TEST_CASE("restitution: the last body of a row leaves at the striker's speed times ((1 + e) / 2)^(n - 1)") {
    // Each body of a row gives its whole speed to the next one of equal mass. The bound of 1 % covers rounding and
    // gaps.
    Random random = Random::seeded(3);
    for (int i = 0; i < test::tries(60); ++i) {
        test::RowDef def;
        def.count = 2 + static_cast<int>(random.below(9));
        def.restitution = random.below(2) == 0 ? 1 : 0.9;
        // Each impact is faster than restitution_speed_min, 1 m/s.
        const double part = std::pow((1 + def.restitution) / 2, def.count - 1);
        def.speed = (1.2 + 0.01 * random.below(1000)) / part;
        def.gap = random.below(2) == 0 ? 0 : 0.0001 * random.below(100);
        def.reversed = random.below(2) == 0;
        if (random.below(2) == 0) def.geometry = box(0.1_r, 0.1_r, 0.1_r);
        WorldDef world = weightless(usual_def());
        world.bodies_max = world.shapes_max = 16;
        world.substeps = 1 + random.below(8);
        World w = made(World::create(world));
        const test::ElasticRow row = test::strike_row(w, def);
        INFO(def.count, " bodies, restitution ", def.restitution, ", ", def.speed, " m/s, gap ", def.gap,
             ", substeps ", world.substeps);
        CHECK(row.last == test::about(def.speed * part, 0.01 * def.speed));
        CHECK(row.most_energy < 1.001);
    }
}

TEST_CASE("restitution: a ball is at the position that an impact in continuous time gives") {
    for (const double e : {0.55, 0.8, 1.0})
        for (const double speed : {2.0, 5.0}) {
            INFO("restitution ", e, ", ", speed, " m/s");
            CHECK(test::farthest_off_bounce(e, speed) < 0.001); // a body moves up to 20 mm within a substep
        }
}

TEST_CASE("restitution: contacts report the impulse of an impact") {
    for (const Geometry& geometry : {sphere(0.1_r), box(0.1_r, 0.1_r, 0.1_r)})
        for (const double e : {0.5, 1.0})
            for (int i = 0; i < 40; ++i) {
                const double speed = 1.2 + 0.1 * i;
                INFO("kind ", static_cast<int>(geometry.kind), ", restitution ", e, ", ", speed, " m/s");
                CHECK(test::reported_impulse(geometry, e, speed, 0.3 + 0.0137 * i) ==
                      test::about((1 + e) * speed, rounding));
            }
}

TEST_CASE("restitution: an elastic ball loses no height") { CHECK(test::height_lost(8) < 0.001); }

TEST_CASE("restitution: bodies in a closed room gain no energy") {
    for (const Geometry& geometry : {sphere(0.3_r), box(0.3_r, 0.2_r, 0.25_r), capsule(0.2_r, 0.25_r)})
        for (int i = 0; i < test::tries(4); ++i) {
            const int count = i % 2 == 0 ? 1 : 10;
            INFO("kind ", static_cast<int>(geometry.kind), ", ", count, " bodies, seed ", i);
            // A spin of 60 rad/s turns a body by a radian within a tick, in which the rows stay fixed: that changes the
            // energy by some hundredths.
            CHECK(test::energy_in_room(geometry, count, static_cast<std::uint64_t>(i), 1200) < 1.1);
        }
}
