// Worlds that reserved memory and worlds that grew on demand have equal states.
#include "lockstone/tasks.h"
#include "metamorphic/stories.h"
#include "support/rigs/moving_state.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

WorldRows limits_of(const WorldDef& d) {
    return {d.bodies_max,       d.shapes_max, d.contacts_max,   d.fields_max,
            d.pair_filters_max, d.joints_max, d.characters_max, d.vehicles_max};
}

} // namespace

TEST_CASE("worlds with different reservations agree at every tick") {
    World grows = start_heap(), has_all = start_heap(), between = start_heap();
    done(has_all.reserve(limits_of(has_all.def())));
    for (int t = 0; t < 50; ++t) {
        INFO(t);
        if (t % 7 == 3) done(between.reserve({.bodies = static_cast<std::uint32_t>(8 * t), .joints = 64}));
        step_heap(grows), step_heap(has_all), step_heap(between);
        REQUIRE(grows.hash() == has_all.hash());
        REQUIRE(between.hash() == has_all.hash());
    }
    CHECK(grows.save_portable() == has_all.save_portable());
    CHECK(State::diff(grows.state(), has_all.state(), 4).empty());
    CHECK(differing_pages(grows.state().hash_tree(), has_all.state().hash_tree()).empty());
    const WorldRows taken = grows.capacity();
    CHECK(taken.bodies < 2 * grows.body_count());
    CHECK(taken.joints > 8);
    CHECK(taken.fields > 8);
    CHECK(taken.characters > 0);
    CHECK(taken.pair_filters > 8);
    CHECK(taken.contacts > 100);
    CHECK(has_all.capacity().bodies == 2000);
    CHECK(has_all.capacity().contacts == 16000);
}

TEST_CASE("a world whose state moves at every chance plays like a world whose state stays") {
    CHECK(test::moving_state_differs(120) == "");
}

TEST_CASE("unused limits cost no memory: a world of the largest definition takes a few kilobytes") {
    WorldDef def;
    def.bodies_max = def.shapes_max = def.contacts_max = def.pair_filters_max = def.joints_max = 1u << 20;
    def.characters_max = def.vehicles_max = 65536, def.fields_max = 1024;
    const World w = made(World::create(def, script_schema()));
    CHECK(w.state().layout().size_bytes() < 8192);
    CHECK(w.capacity().bodies == 0);
    Image image;
    w.save(image);
    CHECK(w.clone().hash() == w.hash());
}

TEST_CASE("a world rejects reservations above the definition's limits and does not change") {
    World w = start_heap();
    for (int t = 0; t < 10; ++t) step_heap(w);
    const std::uint64_t hash = w.hash();
    const WorldRows before = w.capacity();
    const std::pair<WorldRows, const char*> cases[] = {
        {{.bodies = 2001}, "reserve: 2001 rows, but bodies_max is 2000"},
        {{.bodies = 1000, .shapes = 2001}, "shapes_max is 2000"},
        {{.contacts = 16001}, "contacts_max is 16000"},
        {{.fields = 257}, "fields_max is 256"},
        {{.pair_filters = 8193}, "pair_filters_max is 8192"},
        {{.joints = 1u << 31}, "joints_max is 8192"},
        {{.characters = 257}, "characters_max is 256"},
        {{.vehicles = 257}, "vehicles_max is 256"}};
    for (const auto& [rows, words] : cases) {
        const Status status = w.reserve(rows);
        REQUIRE(!status.ok());
        CHECK(status.error().message.find(words) != std::string::npos);
    }
    CHECK(w.hash() == hash);
    CHECK(w.capacity().bodies == before.bodies);
    CHECK(w.capacity().contacts == before.contacts);
}

TEST_CASE("a world reports dropped contacts as an event of every tick that drops some") {
    WorldDef def = small_def();
    def.contacts_max = 5;
    World w = made(World::create(def));
    add_floor(w);
    const auto told = [&] {
        return std::ranges::count_if(w.events(),
                                     [](const Event& e) { return e.kind == EventKind::contacts_dropped; });
    };
    for (int i = 0; i < 5; ++i) add_ball(w, at(2 * i, 0.5, 0));
    w.tick();
    CHECK(told() == 0);
    for (int i = 5; i < 9; ++i) add_ball(w, at(2 * i, 0.5, 0));
    for (int t = 0; t < 3; ++t) {
        w.tick();
        CHECK(told() == 1);
        CHECK(w.events().back().kind == EventKind::contacts_dropped);
        CHECK(w.events().back().tick + 1 == w.tick_count());
    }
    CHECK(w.faults().contacts_dropped == 12);
}

namespace {

WorldDef crowd_def() {
    WorldDef def = small_def();
    def.bodies_max = def.shapes_max = 2000;
    def.contacts_max = 300; // so the broad phase visits 1,624 pairs, and may list 12,992
    return def;
}

/// Balls at nearly one place: half of the square of their number are pairs.
World crowd_of(int balls) {
    World w = made(World::create(crowd_def()));
    add_floor(w);
    for (int i = 0; i < balls; ++i) add_ball(w, at(i % 7 * 0.01, 0.5 + i % 11 * 0.01, i % 13 * 0.01));
    return w;
}

} // namespace

TEST_CASE("a crowd with unvisited pairs continues alike from an image and on other threads and reports "
          "dropped contacts") {
    for (const int balls :
         // 2,415 pairs are listed and cut; 14,365 (until some bodies part) and 79,800 are not listed
         {70, 170, 400}) {
        World w = crowd_of(balls), other = made(World::create(crowd_def()));
        const auto pool = make_worker_pool(3);
        Image image;
        for (int t = 0; t < 40; ++t) {
            if (t % 5 == 0) {
                w.save(image);
                if (t % 10 == 0) other = made(World::create(crowd_def()));
                other.restore(image);
                other.set_tasks(t % 15 == 0 ? pool.get() : nullptr);
            }
            w.tick(), other.tick();
            REQUIRE(w.hash() == other.hash());
            if (t == 0)
                CHECK(std::ranges::any_of(
                    w.events(), [](const Event& e) { return e.kind == EventKind::contacts_dropped; }));
        }
        CHECK(w.faults().contacts_dropped > 0);
    }
}
