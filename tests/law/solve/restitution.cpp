// Restitution against its closed forms: the speeds at which bodies part, their energy, and the friction of what is given back.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double speed_step = 1.0 / (1 << 19);
/// A speed is rounded in each of two passes of up to 16 substeps, in what is stopped and in what is given back.
constexpr double rounding = 64 * speed_step;

WorldDef usual_def() {
    WorldDef def; // of a few substeps: a body moves far in one of them
    def.bodies_max = def.shapes_max = 8, def.contacts_max = 64;
    def.sleeping = 0;
    return def;
}
ShapeDef bouncing(Geometry geometry, double restitution, double friction = 0) {
    return {.geometry = geometry, .friction = real(friction), .restitution = real(restitution)};
}

/// The largest difference from e times the speed at which two equal balls come together, over places of their touch within a tick.
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

/// The least and the most of the energy after one impact on a plane, of that before, over `rounds` ways to fall.
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
    double lost, slip; ///< along the floor: what the ball lost, and how fast its lowest point slides then
};
/// A ball that comes in at 10 m/s along and 5 m/s down.
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

TEST_CASE("restitution: two balls part at its part of their speed, wherever in a tick they touch") {
    for (double e : {0.5, 1.0})
        for (double speed : {1.2, 1.5, 5.0})
            for (const std::uint32_t substeps : {1u, 4u}) {
                INFO("restitution ", e, ", ", speed, " m/s, substeps ", substeps);
                CHECK(worst_parting(e, speed, substeps) < rounding);
            }
}

TEST_CASE("restitution: a body that falls on several points gains no energy") {
    // Twice a rounded speed over the least one, 2 m/s, of the energy.
    const double gain = 2 * rounding / 2;
    for (const Geometry& geometry : {cube, log_of_wood})
        for (double e : {0.5, 1.0}) {
            const Span span = energy_after(geometry, e, 200);
            std::printf("  restitution %.1f: from %.4f to %.6f of the energy after an impact\n", e,
                        span.least, span.most);
            CHECK(span.most < 1 + gain);
        }
}

TEST_CASE("restitution: a body that falls flat parts at its part of its speed") {
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

TEST_CASE("restitution: what is given back has friction too, which ends sliding at most") {
    for (double e : {0.0, 0.5, 1.0})
        for (double friction : {0.1, 0.2}) {
            const Slide out = slide(e, friction);
            INFO("restitution ", e, ", friction ", friction);
            // Coulomb: friction times the normal impulse, (1 + e) 5 m/s; it takes 3.5 times that off the sliding, less than 10 m/s.
            CHECK(std::abs(out.lost - friction * (1 + e) * 5) < rounding);
            CHECK(out.slip > 0);
        }
    // Enough to end the sliding: then the ball rolls, and nothing drives it back.
    const Slide held = slide(1, 1);
    CHECK(held.slip > -rounding);
    CHECK(held.lost < 10 / 3.5 + rounding);
}
