// The pairs of shapes that get contacts, and the pairs that leave rows in the state.
#include "model/manifest.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

std::uint32_t contact_rows(const World& w) {
    return w.state().count(sim::make_manifest(w.def(), {}).contacts.contacts);
}

/// Two crates 0.1 m apart, after a tick. They have these velocities along the gap (x) and across it (z), and the second
/// one turns about z with this spin.
World two_crates(double toward, double across_a, double across_b, double turning = 0) {
    World w = made(World::create(weightless()));
    add(w, {.pose = at(0, 0, 0), .linear_velocity = vec(toward, 0, across_a)},
        {.geometry = box(real(0.5), real(0.5), real(0.5))});
    add(w,
        {.pose = at(1.1, 0, 0),
         .linear_velocity = vec(0, 0, across_b),
         .angular_velocity = vec(0, 0, turning)},
        {.geometry = box(real(0.5), real(0.5), real(0.5))});
    w.tick();
    return w;
}
std::uint32_t rows_of_two(double toward, double across_a, double across_b) {
    return contact_rows(two_crates(toward, across_a, across_b));
}

} // namespace

TEST_CASE("the reach of contacts depends on the closing speed of two shapes and not on the speed of each") {
    CHECK(rows_of_two(0, 0, 0) == 0);
    CHECK(rows_of_two(0, 20, 20) == 0);  // side by side
    CHECK(rows_of_two(0, 20, -20) == 0); // past each other
    CHECK(rows_of_two(9, 0, 0) == 1);    // 0.15 m in the tick
    CHECK(rows_of_two(1, 0, 0) == 0);    // 0.017 m
}

TEST_CASE("only near points that close within the tick become contacts") {
    // They pass each other at 20 m/s. An edge of the second crate turns towards the first one by half a metre per
    // radian: 0.125 m in the tick, or 0.025 m.
    const World turns = two_crates(0, 0, 20, 15), turns_slowly = two_crates(0, 0, 20, 3),
                turns_back = two_crates(0, 0, 20, -15), comes = two_crates(9, 0, 20);
    CHECK(turns_slowly.contacts().empty());
    CHECK(comes.contacts().size() == 4);
    REQUIRE(turns.contacts().size() == 2);
    for (const World::ContactPoint& point : turns.contacts()) CHECK(point.point.y > Real{});
    REQUIRE(turns_back.contacts().size() == 2);
    for (const World::ContactPoint& point : turns_back.contacts()) CHECK(point.point.y < Real{});
}

TEST_CASE("a crate of up to 80 m/s lands on a wall and sinks in by less than 1 cm") {
    for (const double speed : {0.2, 1.0, 5.0, 20.0, 80.0}) {
        WorldDef def = weightless();
        World w = made(World::create(def));
        add_wall(w, at(0, 0, 0), vec(0.5, 2, 2));
        const BodyId crate = add(w, {.pose = at(-1.5, 0, 0), .linear_velocity = vec(speed, 0, 0)},
                                 {.geometry = box(real(0.5), real(0.5), real(0.5))});
        double deepest = 0;
        for (int t = 0; t < 400; ++t) {
            w.tick();
            deepest = std::max(deepest, position(w, crate)[0] + 1.0);
        }
        CAPTURE(speed);
        CHECK(deepest < 0.01);
    }
}

TEST_CASE("a near pair without a contact point stores nothing in the state") {
    World w = made(World::create(small_def()));
    add_floor(w);
    // Corners pass corners, with 13 cm between the faces: the bounds overlap.
    for (int i = 0; i < 8; ++i) add_crate(w, at(0.8 * i, 0.5, 0.8 * i, turned(axis_y, 45)));
    for (int t = 0; t < 30; ++t) w.tick();
    CHECK(contact_rows(w) == 8);
    const auto memories = w.state().rows(sim::make_manifest(w.def(), {}).contacts.memory);
    for (const solve::ContactRow& row : memories) CHECK(row.count > 0);
}

TEST_CASE("the contact of a pair that parts ends although the pair stays near") {
    World w = made(World::create(weightless()));
    add_wall(w, at(0, -0.5, 0), vec(3, 0.5, 3));
    const BodyId crate = add_crate(w, at(0, 0.5, 0));
    w.tick();
    done(w.set_velocity(crate, vec(0, 1.5, 0), {}));
    int ended = 0;
    for (int t = 0; t < 6; ++t) {
        w.tick();
        for (const Event& e : w.events()) ended += e.kind == EventKind::contact_end;
    }
    CHECK(ended == 1);
    CHECK(contact_rows(w) == 0);
}
