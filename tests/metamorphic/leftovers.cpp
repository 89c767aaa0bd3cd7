// The test changes the data that ticks leave outside of the state before every tick: memory, the shapes of trees, the
// known pairs and the order in which they are found. No result may change.
#include "lockstone/testing.h"
#include "prove/disturb.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

using namespace lockstone;
using namespace lockstone::test;

namespace {

const bool is_long = std::getenv("LOCKSTONE_LONG") != nullptr;
const int tick_count = is_long ? 300 : 8;
constexpr testing::Leftover leftovers[] = {testing::Leftover::scratch, testing::Leftover::trees,
                                           testing::Leftover::pairs};

/// Compares rays and boxes through the middle of two worlds, which the trees answer. Empty when both results are equal.
std::string answers_differ(const World& left, const World& right) {
    const Ray ray{scene::vec(-9, 6, 0.3), scene::vec(20, -8, 0)};
    std::vector<QueryHit> hits[2];
    std::vector<ShapeId> shapes[2];
    for (int i = 0; i < 2; ++i) {
        const World& world = i == 0 ? left : right;
        world.cast_ray_all(ray, {}, hits[i]);
        world.overlap(box(Real(4), Real(2), Real(4)), scene::at(0, 1, 0), {}, shapes[i]);
    }
    if (shapes[0] != shapes[1]) return "overlap differs";
    const auto same = [](const QueryHit& a, const QueryHit& b) {
        return a.shape == b.shape && a.point == b.point && a.normal == b.normal && a.distance == b.distance;
    };
    return std::ranges::equal(hits[0], hits[1], same) ? "" : "cast_ray_all differs";
}

/// Runs a game twice, once with `disturb(world, t)` before every tick and every query. Returns the first difference.
template <class Disturb> std::string departs(const Game& game, int ticks, Disturb&& disturb) {
    ScriptedInputs inputs(game);
    World usual = game.start().value(), other = usual.clone();
    for (int t = 0; t < ticks; ++t) {
        disturb(other, t);
        for (World* w : {&usual, &other}) REQUIRE(game.advance(*w, inputs.at(w->tick_count())).ok());
        std::string found = scene::difference(usual, other);
        if (found.empty()) found = output_difference(usual, other);
        disturb(other, t + 1);
        if (found.empty()) found = answers_differ(usual, other);
        if (!found.empty()) return found;
    }
    return {};
}

/// A pile on a box, without the public interface; parts of it sleep.
sim::Data sleepy_pile() {
    WorldDef def = scene::drowsy_def();
    sim::Data w(def, {}, std::make_shared<const AssetLibrary>());
    const auto put = [&](BodyKind kind, const Transform& pose, const Geometry& geometry) {
        const BodyId body = scene::made(sim::apply(w, CreateBody{{.kind = kind, .pose = pose}})).body;
        scene::made(sim::apply(w, CreateShape{body, {.geometry = geometry}}));
    };
    put(BodyKind::static_, scene::at(0, -1, 0), box(Real(20), Real(1), Real(20)));
    for (int i = 0; i < 24; ++i)
        put(BodyKind::dynamic, scene::at(i % 5 * 0.9, 0.6 + i / 5 * 1.1, i % 3 * 0.8), sphere(0.5_r));
    return w;
}

/// Returns whether `meddle`, called before each tick, changes the states of a pile.
template <class Meddle> bool inside_departs(Meddle&& meddle) {
    sim::Data usual = sleepy_pile(), other = sleepy_pile();
    for (int t = 0; t < 60; ++t) {
        meddle(other, t);
        sim::tick(usual), sim::tick(other);
        if (usual.state.hash() != other.state.hash()) return true;
    }
    return false;
}

void poison(sim::Data& w, int t) { sim::poison_scratch(w, static_cast<std::byte>(37 * t)); }

} // namespace

TEST_CASE("every scene: poisoned scratch and other trees and dropped pairs before every tick change no bit") {
    for (const SceneInfo& info : scenes())
        for (const testing::Leftover what : leftovers) {
            INFO(info.name, ", leftover ", static_cast<int>(what));
            CHECK(departs(*small_scene(info), tick_count, [what](World& w, int t) {
                      testing::disturb(w, what, 1000 + static_cast<std::uint64_t>(t));
                  }) == "");
        }
}

TEST_CASE("a pile in an arena ticks alike for every byte that can fill its scratch memory") {
    const auto game = make_scene("rollback-arena").value();
    CHECK(departs(*game, is_long ? 512 : 40, [](World& w, int t) {
              testing::disturb(w, testing::Leftover::scratch, static_cast<std::uint64_t>(t));
              testing::disturb(w, testing::Leftover::pairs, static_cast<std::uint64_t>(t));
          }) == "");
    CHECK_FALSE(inside_departs(poison));
    CHECK_FALSE(inside_departs([](sim::Data& w, int t) {
        for (const testing::Leftover what : leftovers) sim::disturb(w, what, static_cast<std::uint64_t>(t));
    }));
}

TEST_CASE(
    "trees with the same leaves in any order and shape find the same pairs after any order of insertion") {
    std::mt19937 chance(4);
    const auto coordinate = [&](int low, int high) {
        return Bound::from_raw(std::uniform_int_distribution<std::int32_t>(low, high)(chance));
    };
    for (int round = 0; round < (is_long ? 200 : 20); ++round) {
        std::vector<collide::Bounds> bounds(80);
        for (collide::Bounds& b : bounds)
            for (int axis = 0; axis < 3; ++axis)
                b.lower[axis] = coordinate(-900000, 900000),
                b.upper[axis] = b.lower[axis] + coordinate(0, 400000);
        std::vector<std::uint32_t> order(bounds.size());
        for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
        std::vector<collide::ProxyPair> expected, found;
        for (int again = 0; again < 4; ++again) {
            collide::BroadPhase broad_phase(80);
            lockstone::Random random = lockstone::Random::seeded(static_cast<std::uint64_t>(again));
            for (std::size_t i = 0; i < order.size(); ++i) {
                broad_phase.set(order[i], bounds[order[i]], order[i] % 4 == 0);
                if (again > 0 && i % 16 == 0)
                    broad_phase.find_pairs(found), broad_phase.rebuild_trees(random);
            }
            if (again > 1) broad_phase.forget_pairs(random);
            broad_phase.find_pairs(found);
            if (again == 0) expected = found;
            REQUIRE(found == expected);
            std::shuffle(order.begin(), order.end(), chance);
        }
        CHECK(expected.size() > 8);
    }
}

TEST_CASE("planted fault: a changed cache that ticks rely on is no leftover and changes the ticks") {
    CHECK_FALSE(inside_departs([](sim::Data&, int) {}));
    CHECK(inside_departs([](sim::Data& w, int t) {
        if (t > 0) w.placed.broad_phase.remove(0); // the ground
    }));
    CHECK(inside_departs([](sim::Data& w, int t) {
        if (t > 0) w.placed.shape[0].pose.position.y += 1_r; // of a body at rest
    }));
}

TEST_CASE(
    "planted fault: the check finds a flipped bit of the state and a tick that reads old scratch memory") {
    const auto game = make_scene("rollback-arena").value();
    bool flipped = false;
    const std::string found = departs(*game, 20, [&](World& w, int t) {
        if (t != 12 || flipped) return;
        flipped = true;
        const ColumnInfo* info = w.state().layout().find_column("body.velocity");
        const auto index = static_cast<std::uint32_t>(info - w.state().layout().columns().data());
        testing::state_of(w).edit_bytes(index, 3, 1)[1] ^= std::byte{1};
    });
    CHECK(found.starts_with("tick 13, column body."));
    const auto reads_contacts = [](sim::Data& w) { // of the last tick
        const std::vector<solve::Contact>& contacts = w.scratch.found.contacts;
        if (!contacts.empty() && contacts[0].count > 4) ++w.state.edit_row(w.m.faults, 0).speed_clamped;
    };
    CHECK_FALSE(inside_departs([&](sim::Data& w, int) { reads_contacts(w); }));
    CHECK(inside_departs([&](sim::Data& w, int t) { poison(w, t), reads_contacts(w); }));
}
