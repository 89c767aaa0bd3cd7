// The names of execution paths: size, workers and lanes of a world choose its paths, and all paths give equal bits.
#include "lockstone/testing.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <string>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// True if the last tick of a world took a path.
bool took(const World& world, std::string_view name) {
    const auto names = testing::path_names();
    const auto at = std::ranges::find(names, name);
    REQUIRE(at != names.end());
    return testing::paths_taken(world)[static_cast<std::size_t>(at - names.begin())];
}

/// Ticks two clones of a world and compares their hashes. The second clone may have tasks.
void tick_both(World& alone, World& shared, int ticks) {
    for (int t = 0; t < ticks; ++t) {
        alone.tick(), shared.tick();
        REQUIRE(alone.hash() == shared.hash());
    }
}

} // namespace

TEST_CASE("each path has a unique name and no path is taken before the first tick") {
    const auto names = testing::path_names();
    CHECK(std::set(names.begin(), names.end()).size() == names.size());
    CHECK(names.size() <= testing::PathSet{}.size());
    World world = towers(4).world;
    CHECK(testing::paths_taken(world).none());
    world.tick();
    CHECK(testing::paths_taken(world).any());
    CHECK(testing::paths_taken(world.clone()).none());
}

TEST_CASE("a deep pile takes one strand on one thread and many strands on workers and keeps earlier packs") {
    const auto game = make_scene("pyramid").value();
    World alone = game->start().value(), shared = alone.clone();
    const auto pool = make_worker_pool(2);
    shared.set_tasks(pool.get());
    tick_both(alone, shared, 1);
    CHECK(took(alone, "packs_made"));
    tick_both(alone, shared, 59);
    for (const char* name : {"one_worker", "contacts_one_strand", "passes_one_by_one", "bounds_by_one"}) {
        CHECK_MESSAGE(took(alone, name), name);
        CHECK_FALSE_MESSAGE(took(shared, name), name);
    }
    for (const char* name : {"many_workers", "contacts_many_strands", "strands_by_order", "passes_in_one_run",
                             "bounds_by_workers"}) {
        CHECK_MESSAGE(took(shared, name), name);
        CHECK_FALSE_MESSAGE(took(alone, name), name);
    }
    CHECK(took(alone, "packs_kept") == took(shared, "packs_kept"));
    CHECK(took(alone, "manifold_kept"));
}

TEST_CASE("towers run their passes by island and one by one if a joint also moves bodies") {
    Islands islands = towers(4000), passes = towers(4000);
    add_pendulum(passes.world);
    for (int t = 0; t < 12; ++t) islands.world.tick(), passes.world.tick();
    CHECK(took(islands.world, "passes_by_island"));
    CHECK(took(islands.world, "strands_by_island"));
    CHECK(took(passes.world, "passes_one_by_one"));
    CHECK_FALSE(took(passes.world, "passes_by_island"));
}

TEST_CASE("lanes and workers choose the paths of a net of joints") {
    World wide = net(12), scalar = wide.clone();
    REQUIRE(scalar.set_simd(Simd::scalar));
    const auto pool = make_worker_pool(3);
    World shared = wide.clone();
    shared.set_tasks(pool.get());
    tick_both(wide, scalar, 3);
    for (int t = 0; t < 3; ++t) shared.tick();
    CHECK(shared.hash() == wide.hash());
    CHECK(took(scalar, "lanes_scalar"));
    CHECK(took(wide, best_simd() == Simd::scalar ? "lanes_scalar" : "lanes_wide"));
    CHECK(took(wide, "joint_plan_kept"));
    CHECK(took(wide, "joint_in_pack"));
    CHECK(took(wide, "joints_one_strand"));
    CHECK(took(shared, "held_by_workers"));
    CHECK_FALSE(took(wide, "held_by_workers"));
}

TEST_CASE("planted fault: the set of paths of the previous tick differs from the set of this tick") {
    World world = towers(40).world;
    world.tick();
    CHECK(took(world, "step_new"));
    CHECK_FALSE(took(world, "step_kept"));
    const testing::PathSet first = testing::paths_taken(world);
    world.tick();
    CHECK_FALSE(took(world, "step_new"));
    CHECK(took(world, "step_kept"));
    CHECK(testing::paths_taken(world) != first);
}
