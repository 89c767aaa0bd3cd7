// Delta images: applied to its base, a delta gives the other state for any two states. Deltas of few changes are small.
#include "support/state_sample.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <cstdlib>

namespace lockstone::test {
namespace {

using Bytes = std::vector<std::byte>;

const bool is_long = std::getenv("LOCKSTONE_LONG") != nullptr;

std::string hex(std::span<const std::byte> bytes) {
    std::string out;
    for (const std::byte b : bytes) {
        out += "0123456789abcdef"[std::to_integer<unsigned>(b) >> 4];
        out += "0123456789abcdef"[std::to_integer<unsigned>(b) & 15u];
    }
    return out;
}

/// Applies `to` as a delta to `from`. Returns an error sentence or an empty string.
std::string lost_between(const State& from, const State& to) {
    State state = from;
    const Status status = state.apply_delta(to.save_delta(from));
    if (!status) return status.error().message;
    if (state.save_portable() != to.save_portable()) return "other bytes";
    return state.hash() == to.hash() ? "" : "another hash";
}

/// The states of a game at every tick.
std::vector<State> states_of(const Game& game, int ticks) {
    ScriptedInputs inputs(game);
    World world = game.start().value();
    std::vector<State> states{world.state()};
    for (int t = 0; t < ticks; ++t) {
        REQUIRE(game.advance(world, inputs.at(world.tick_count())).ok());
        states.push_back(world.state());
    }
    return states;
}

/// One row for each key; the other columns move with the keys.
State with_contacts(const Sample& s, std::span<const std::uint64_t> keys) {
    State state(s.layout);
    state.resize(s.contact, static_cast<std::uint32_t>(keys.size()));
    for (std::uint32_t row = 0; row < keys.size(); ++row)
        state.edit_row(s.manifold, row) = {keys[row], {{{Speed{}, static_cast<std::uint32_t>(keys[row])}}}};
    return state;
}

} // namespace

TEST_CASE("a delta applied to its base gives the other state for random states of all sizes") {
    const Sample s = make_sample();
    for (std::uint64_t seed = 1; seed <= 60; ++seed)
        REQUIRE(lost_between(random_state(s, seed), random_state(s, seed + 1000)) == "");
    const State empty(s.layout), full = random_state(s, 8, 400, 100, 1);
    CHECK(lost_between(empty, full) == "");
    CHECK(lost_between(full, empty) == "");
    CHECK(lost_between(empty, empty) == "");
}

TEST_CASE("a delta is exact for the difference between the smallest and the largest value of every field") {
    const Sample s = make_sample();
    for (const unsigned from : {0x00u, 0x7fu, 0x80u, 0xffu})
        for (const unsigned to : {0x00u, 0x7fu, 0x80u, 0xffu}) {
            State a(s.layout), b(s.layout);
            for (State* state : {&a, &b}) {
                state->resize(s.body, 3);
                for (std::uint32_t c = 0; c < s.layout->columns().size(); ++c)
                    for (std::byte& byte : state->edit_bytes(c))
                        byte = static_cast<std::byte>(state == &a ? from : to);
            }
            CHECK(lost_between(a, b) == "");
        }
}

TEST_CASE("a delta applies to states of other capacities and returns an error if rows do not fit") {
    const Sample s = make_sample(), larger = make_sample(50, 1000), tight = make_sample(8, 5);
    const State from = random_state(s, 5, 4, 42, 9), to = random_state(s, 7, 180, 3, 10);
    State in_larger(larger.layout), in_tight(tight.layout);
    REQUIRE(in_larger.restore_portable(from.save_portable()).ok());
    REQUIRE(in_tight.restore_portable(from.save_portable()).ok());
    const Bytes delta = to.save_delta(from);
    CHECK(to.save_delta(in_larger) == delta);
    REQUIRE(in_larger.apply_delta(delta).ok());
    CHECK(in_larger.save_portable() == to.save_portable());
    const Status refused = in_tight.apply_delta(delta);
    REQUIRE(!refused.ok());
    CHECK(refused.error().message.find("table 'contact' has 180 rows in the delta, but capacity for 5") !=
          std::string::npos);
    CHECK(in_tight.hash() == from.hash());
}

TEST_CASE("a delta matches rows by key so that moved rows add few bytes") {
    const Sample s = make_sample();
    std::vector<std::uint64_t> keys;
    for (std::uint64_t i = 0; i < 200; ++i) keys.push_back(0x9e3779b97f4a7c15u * (i + 1));
    const State from = with_contacts(s, keys);
    keys.insert(keys.begin() + 3, 17);
    keys.erase(keys.begin() + 100);
    std::swap(keys[20], keys[150]);
    const State to = with_contacts(s, keys);
    CHECK(lost_between(from, to) == "");
    CHECK(to.save_delta(from).size() < 130);
    CHECK(to.save_portable().size() > 200 * sizeof(Manifold));
}

TEST_CASE("a small delta has the bytes that the format's README gives") {
    StateLayout layout;
    const TableId t = layout.add_table("t", 4);
    const auto key = layout.add_column<std::uint16_t>(t, "t.key", Group::game);
    const auto speed = layout.add_column<Speed>(t, "t.speed", Group::motion);
    State from(std::move(layout).finished());
    from.resize(t, 2);
    from.edit_row(key, 0) = 5, from.edit_row(key, 1) = 9;
    from.edit_row(speed, 1) = Speed::from_raw(1000);
    State to(from.layout_shared());
    to.resize(t, 3);
    to.edit_row(key, 0) = 9, to.edit_row(key, 1) = 0x1234, to.edit_row(key, 2) = 5;
    to.edit_row(speed, 0) = Speed::from_raw(997);
    const Bytes delta = to.save_delta(from);
    REQUIRE(delta.size() > 44 + 8);
    CHECK(hex(std::span(delta).first(20)) == "4c5344454c54410a010000004c00000000000000");
    // Computed by hand from the format's README.
    CHECK(hex(std::span(delta).subspan(44, delta.size() - 52)) ==
          "03" // rows of t
          "01"
          "02" // a row from row 1 of the base
          "01"
          "02" // one row with a new key: from row 1 too, its own place
          "01"
          "01" // one from row 0
          "01"
          "01"
          "01" // t.key: one row unchanged, one changed, one unchanged
          "00"
          "02"
          "5624" // 0x1234 - 9 = 0x122b, folded 0x2456
          "00"
          "02"
          "01" // t.speed: two rows changed, one unchanged
          "00"
          "04"
          "05cf0007" // -3 and -1000, folded 5 and 0x7cf: the low bytes of both, the next ones,
          "04");     // and four zeros
    CHECK(lost_between(from, to) == "");
}

TEST_CASE("in every scene a delta rebuilds the state of any tick from the state of any other tick") {
    SplitMix random(5);
    const int ticks = is_long ? 40 : 12, pairs = is_long ? 200 : 6;
    for (const SceneInfo& info : scenes()) {
        INFO(info.name);
        const std::vector<State> states = states_of(*small_scene(info), ticks);
        for (int i = 0; i < pairs; ++i) {
            const std::uint32_t from = random.below(static_cast<std::uint32_t>(states.size())),
                                to = random.below(static_cast<std::uint32_t>(states.size()));
            INFO("from ", from, " to ", to);
            REQUIRE(lost_between(states[from], states[to]) == "");
        }
    }
}

TEST_CASE("a world continues from a delta as from a run of its own and rejects a delta of another tick") {
    const auto game = make_scene("rollback-arena").value();
    ScriptedInputs inputs(*game);
    World here = game->start().value(), there = here.clone();
    Image base, later;
    there.save(base);
    for (int t = 0; t < 30; ++t) REQUIRE(game->advance(here, inputs.at(here.tick_count())).ok());
    here.save(later);
    REQUIRE(game->advance(there, inputs.at(0)).ok()); // changes that the delta must undo
    REQUIRE(there.restore_delta(base, here.save_delta(base)).ok());
    for (int t = 0; t < 20; ++t) {
        REQUIRE(there.hash() == here.hash());
        for (World* w : {&here, &there}) REQUIRE(game->advance(*w, inputs.at(w->tick_count())).ok());
    }
    const std::uint64_t hash = there.hash();
    const Status refused = there.restore_delta(base, here.save_delta(later));
    REQUIRE(!refused.ok());
    CHECK(refused.error().message.starts_with("state delta: hash of the base is 0x"));
    CHECK(there.hash() == hash);
}

TEST_CASE("the delta of a sleeping pyramid holds the tick number and format overhead in at most 120 bytes") {
    World world = scene::made(World::create(scene::drowsy_def()));
    scene::add_floor(world);
    scene::add_pyramid(world, 8);
    for (int t = 0; t < 2000 && world.awake_count() != 0; ++t) world.tick();
    REQUIRE(world.awake_count() == 0);
    Image base;
    world.save(base);
    for (int t = 0; t < 60; ++t) world.tick();
    const std::size_t size = world.save_delta(base).size(), whole = world.save_portable().size();
    INFO(size, " of ", whole, " bytes");
    CHECK(size <= 120); // measured: 100
    CHECK(whole > 15000);
}

// The bound of 7,240 bytes is an eighth of the state's size when every body had traits of its own (57,921 bytes).
TEST_CASE(
    "a game's delta over one tick is below 7240 bytes and over thirty ticks below a twentieth of the state") {
    const std::vector<State> states = states_of(*make_scene("rollback-arena").value(), 90);
    std::size_t largest = 0, whole = 0;
    for (std::size_t t = 1; t < states.size(); ++t) {
        largest = std::max(largest, states[t].save_delta(states[t - 1]).size());
        whole = states[t].save_portable().size();
    }
    INFO("at most ", largest, " of ", whole, " bytes");
    CHECK(largest < 7240);
    CHECK(states[90].save_delta(states[60]).size() * 20 < whole);
}

} // namespace lockstone::test
