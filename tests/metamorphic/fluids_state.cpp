// Water, wind and explosions from a saved state at any tick, from a portable image, with workers: the same run.
#include "scenes/scenes.h"
#include "support/sim_scenes.h"

#include "lockstone/tasks.h"
#include "lockstone/testing.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

struct Story {
    std::unique_ptr<Game> game;
    std::vector<Image> images; ///< before each tick
    std::vector<std::uint64_t> hashes;
};

Story story_of(const char* name, std::uint32_t size, int ticks) {
    Story s{make_scene(name, {.size = size}).value(), {}, {}};
    World w = s.game->start().value();
    for (int t = 0; t <= ticks; ++t) {
        w.save(s.images.emplace_back());
        s.hashes.push_back(w.hash());
        if (t < ticks) REQUIRE(s.game->advance(w, {}).ok());
    }
    return s;
}

/// Small enough to run many times.
std::uint32_t size_of(std::string_view scene) { return scene == "water" ? 8 : 2; }

/// Where a world that stands at `tick` parts from the story within `ticks`, -1: nowhere.
int parts_at(const Story& s, World& w, std::size_t tick, std::size_t ticks) {
    for (std::size_t t = tick; t < s.hashes.size() && t <= tick + ticks; ++t) {
        if (w.hash() != s.hashes[t]) return static_cast<int>(t);
        REQUIRE(s.game->advance(w, {}).ok());
    }
    return -1;
}

} // namespace

TEST_CASE("water and blasts go on alike from every tick they are rolled back to") {
    for (const char* name : {"water", "blast"}) {
        const Story s = story_of(name, size_of(name), 260);
        World w = s.game->start().value();
        for (std::size_t t = 0; t < s.images.size(); ++t) {
            w.restore(s.images[t]);
            INFO(name, ", tick ", t);
            REQUIRE(parts_at(s, w, t, t % 16 == 0 ? 12 : 1) == -1);
        }
    }
}

TEST_CASE("a portable image of them, in a fresh world, too") {
    for (const char* name : {"water", "blast"}) {
        const Story s = story_of(name, size_of(name), 240);
        World w = s.game->start().value();
        for (std::size_t t = 0; t < s.images.size(); t += 30) {
            w.restore(s.images[t]);
            World fresh = s.game->start().value();
            done(fresh.restore_portable(w.save_portable()));
            CHECK(parts_at(s, fresh, t, 30) == -1);
        }
    }
}

TEST_CASE("planted fault: water of another density, wind of another speed and a blast left out are found") {
    const Story s = story_of("water", 8, 20);
    World w = s.game->start().value();
    for (std::uint32_t row = 0; row < w.field_count(); ++row) {
        w.restore(s.images[10]);
        FieldDef def = w.field(w.field_at(row));
        def.density += 1_r, def.velocity.x += 0.01_r;
        done(w.set_field(w.field_at(row), def));
        World straight = s.game->start().value();
        straight.restore(s.images[10]);
        REQUIRE(same_motion(w, straight));
        REQUIRE((s.game->advance(w, {}).ok() && s.game->advance(straight, {}).ok()));
        CHECK_FALSE(same_motion(w, straight));
    }
    const Story blast = story_of("blast", 2, 70);
    World other = blast.game->start().value();
    other.restore(blast.images[60]);
    other.tick(); // the blast of tick 60 is the game's
    World straight = blast.game->start().value();
    straight.restore(blast.images[61]);
    CHECK_FALSE(same_motion(other, straight));
}

TEST_CASE("workers see the same water") {
    const Story s = story_of("water", 40, 120);
    for (std::uint32_t workers : {2u, 3u}) {
        const std::unique_ptr<Tasks> tasks = make_worker_pool(workers);
        World w = s.game->start().value();
        w.set_tasks(tasks.get());
        CHECK(parts_at(s, w, 0, 120) == -1);
        w.set_tasks(nullptr);
    }
}

TEST_CASE("a field from outside that cannot be is refused") {
    World w = make_scene("water", {.size = 2}).value()->start().value();
    World broken = w.clone();
    const Image before = [&] {
        Image i;
        w.save(i);
        return i;
    }();
    const auto columns = testing::state_of(broken).layout().columns();
    for (std::uint32_t c = 0; c < columns.size(); ++c)
        if (columns[c].name == "field.row")
            testing::state_of(broken).edit_bytes(c, 0, 1)[8] = std::byte{99}; // its kind
    const Status status = w.restore_portable(broken.save_portable());
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().message.find("field.row row 0: kind is 99") != std::string::npos);
}
