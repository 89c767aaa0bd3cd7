// What bodies, shapes and contacts share or have by the way: a state in which it does not fit together is refused, with a
// sentence that says what does not.
#include "lockstone/state.h"
#include "lockstone/world.h"
#include "model/manifest.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>

using namespace lockstone;

namespace {

/// Two boxes alike and a ball on a plane, touching; a third box is gone, so that rows are free.
World sample() {
    World w = World::create({}).value();
    const BodyId ground = w.create_body({.kind = BodyKind::static_}).value();
    w.create_shape(ground, {.geometry = plane()}).value();
    const auto add = [&](Real x, const Geometry& geometry, Real rolling) {
        const BodyId body = w.create_body({.pose = {.position = {x, 0.5_r, 0_r}}}).value();
        w.create_shape(body, {.geometry = geometry, .rolling_resistance = rolling}).value();
        return body;
    };
    add(0_r, box(0.5_r, 0.5_r, 0.5_r), 0_r), add(3_r, box(0.5_r, 0.5_r, 0.5_r), 0_r);
    const BodyId ball = add(6_r, sphere(0.5_r), 0.1_r);
    w.destroy(add(9_r, box(0.5_r, 0.25_r, 0.5_r), 0_r)).value();
    w.set_velocity(ball, {1_r, 0_r, 0_r}, {0_r, 0_r, -2_r}).value();
    for (int i = 0; i < 20; ++i) w.tick();
    w.add_force(ball, {1_r, 0_r, 0_r}).value();
    return w;
}

/// What the world says of its own state after a change; empty when it takes it.
std::string said_of(World& w, const std::function<void(State&, const sim::Manifest&)>& change) {
    State state = w.state();
    change(state, sim::make_manifest(w.def(), {}));
    const Status status = w.restore_portable(state.save_portable());
    return status ? "" : status.error().message;
}

bool holds(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

/// Row of the table of what bodies are like that nobody uses.
std::uint32_t free_row(const State& s, const sim::Manifest& m) {
    return s.rows(m.header)[0].body_traits_free - 1;
}

} // namespace

TEST_CASE("shared rows: a state as it is, is taken") {
    World w = sample();
    CHECK(said_of(w, [](State&, const sim::Manifest&) {}) == "");
    const sim::Manifest m = sim::make_manifest(w.def(), {});
    REQUIRE(w.state().rows(m.header)[0].body_traits_free != 0);
    REQUIRE(w.state().rows(m.header)[0].shape_traits_free != 0);
    REQUIRE(w.state().count(m.contacts.more) == 1);
    REQUIRE(w.state().count(m.contacts.points) == 9);
    REQUIRE(w.state().count(m.forces) == 1);
}

TEST_CASE("shared rows: an index to no row, to a free one, or not as often as is counted, is refused") {
    World w = sample();
    CHECK(
        holds(said_of(w, [](State& s, const sim::Manifest& m) { s.edit_row(m.body_info, 1).traits = 1000; }),
              "does not exist"));
    CHECK(holds(
        said_of(w, [](State& s, const sim::Manifest& m) { s.edit_row(m.shape, 1).traits = 0xffffffffu; }),
        "does not exist"));
    CHECK(
        holds(said_of(w, [](State& s,
                            const sim::Manifest& m) { s.edit_row(m.body_info, 1).traits = free_row(s, m); }),
              "not what it says"));
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            ++s.edit_row(m.body_traits.uses, s.rows(m.body_info)[1].traits).count;
                        }),
                "is used 2 times, which is not what it says"));
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            s.edit_row(m.shape_traits.uses, s.rows(m.shape)[1].traits).count = 0;
                        }),
                "not what it says"));
}

TEST_CASE("shared rows: a broken free list, and free rows that hold something, are refused") {
    World w = sample();
    CHECK(holds(
        said_of(w, [](State& s, const sim::Manifest& m) { s.edit_row(m.header, 0).body_traits_free = 0; }),
        "the free list misses rows"));
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            s.edit_row(m.header, 0).body_traits_free = s.rows(m.body_info)[1].traits + 1;
                        }),
                "the free list is broken"));
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            const std::uint32_t row = free_row(s, m);
                            s.edit_row(m.body_traits.uses, row).count = sim::SharedUses::is_free | (row + 1);
                        }),
                "the free list is broken"));
    CHECK(holds(
        said_of(w, [](State& s,
                      const sim::Manifest& m) { s.edit_row(m.body_traits.row, free_row(s, m)).locks = 1; }),
        "is free, but not zero"));
}

TEST_CASE("shared rows: two rows that are the same, and rows out of range, are refused") {
    World w = sample();
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            s.edit_row(m.shape_traits.row, s.rows(m.shape)[3].traits) =
                                sim::ShapeTraits(s.rows(m.shape_traits.row)[s.rows(m.shape)[1].traits]);
                        }),
                "is the same as another"));
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            s.edit_row(m.body_traits.row, s.rows(m.body_info)[1].traits).locks = 64;
                        }),
                "locks is 64"));
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            s.edit_row(m.body_traits.row, s.rows(m.body_info)[1].traits).mass.gyration.x =
                                Real(-1);
                        }),
                "gyration"));
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            s.edit_row(m.shape_traits.row, s.rows(m.shape)[1].traits).friction = Real(-1);
                        }),
                "friction"));
}

TEST_CASE("contact rows: points and the rest that are not as many as the contacts say are refused") {
    World w = sample();
    CHECK(holds(
        said_of(w, [](State& s, const sim::Manifest& m) { s.edit_row(m.contacts.memory, 0).count = 3; }),
        "the contacts have 8 points"));
    CHECK(holds(
        said_of(w, [](State& s, const sim::Manifest& m) { s.edit_row(m.contacts.memory, 0).count = 0; }),
        "not one to 4 points"));
    CHECK(holds(said_of(w, [](State& s, const sim::Manifest& m) { s.resize(m.contacts.points, 10); }),
                "the contacts have 9 points"));
    CHECK(holds(said_of(w,
                        [](State& s, const sim::Manifest& m) {
                            s.edit_row(m.contacts.memory, 0).flags |= solve::contact_has_more;
                        }),
                "2 contacts have a row here"));
    CHECK(holds(said_of(w, [](State& s, const sim::Manifest& m) { s.edit_row(m.contacts.beyond, 0) = {}; }),
                "has nothing in it"));
}

TEST_CASE("forces: one on no body, and a body pushed by none that is there, are refused") {
    World w = sample();
    CHECK(holds(said_of(w, [](State& s, const sim::Manifest& m) { s.edit_row(m.pushed, 0) = 1000; }),
                "a force on no body"));
    CHECK(holds(
        said_of(w, [](State& s, const sim::Manifest& m) { *std::ranges::find(s.edit(m.body_push), 0u) = 2; }),
        "a force that is not there"));
}
