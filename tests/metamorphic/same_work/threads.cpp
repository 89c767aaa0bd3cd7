// The state of a world does not depend on the number of workers that ran its ticks, on their identity, or on their
// order.
#include "support/allocation_counter.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test;

namespace {

const bool is_long = std::getenv("LOCKSTONE_LONG") != nullptr;
/// Ticks of runs on one thread, and on several: pools larger than the machine are slow.
const int tick_count = is_long ? 600 : 40, pool_ticks = is_long ? 200 : 3;

} // namespace

TEST_CASE("every scene has the same hashes on 1 and 2 and 3 and 8 and 16 workers as on none") {
    std::vector<std::unique_ptr<Tasks>> pools;
    std::vector<Tasks*> tasks;
    for (const std::uint32_t workers : {1u, 2u, 3u, 8u, 16u}) {
        pools.push_back(make_worker_pool(workers));
        REQUIRE(pools.back()->worker_count() == workers);
        tasks.push_back(pools.back().get());
    }
    for (const SceneInfo& info : scenes()) {
        INFO(info.name);
        CHECK(first_departure(*small_scene(info), tasks, 30, pool_ticks) == "");
    }
}

TEST_CASE("every scene has the same hashes with tasks in random order and the scenes run such tasks") {
    std::uint64_t runs = 0, items = 0;
    for (const SceneInfo& info : scenes()) {
        INFO(info.name);
        ShuffledTasks one(1), many(2, 64);
        CHECK(first_departure(*small_scene(info), std::array<Tasks*, 2>{&one, &many}, 25,
                              is_long ? 300 : 8) == "");
        runs += one.runs, items += one.items_run;
    }
    CHECK(runs > 1000);
    CHECK(items > 2 * runs);
}

TEST_CASE("every scene has the same hashes with workers that are interrupted at random") {
    UnsteadyTasks three(3, 7), eight(8, 8);
    for (const SceneInfo& info : scenes()) {
        INFO(info.name);
        CHECK(first_departure(*small_scene(info), std::array<Tasks*, 2>{&three, &eight}, 40, pool_ticks) ==
              "");
    }
}

// Workers share passes from some hundred contacts or joints on. Ragdolls in a heap come apart, and the solver closes
// their joints.
TEST_CASE("heaps and walls and ragdolls and nets that workers share have the same hashes") {
    const auto two = make_worker_pool(2), eight = make_worker_pool(8);
    ShuffledTasks shuffled(11, 2), many(12, 7);
    const std::array<Tasks*, 4> tasks{two.get(), eight.get(), &shuffled, &many};
    for (const char* name : {"pile", "pyramid", "ragdolls", "convex-pile"}) {
        INFO(name);
        const auto game = make_scene(name).value();
        CHECK(first_departure(*game, tasks, 50, is_long ? 200 : 25) == "");
    }
    const World start = net(40);
    CHECK(first_departure(start, tasks, is_long ? 60 : 8, [](World& w, Tasks*) { w.tick(); }) == "");
}

// A host that runs one strand after the previous one has ended: a joint that does not wait for another strand's joint
// is solved too early. This test once found packs with strands that held other joints than packs without.
TEST_CASE("a host that runs strands in sequence solves many joints in order") {
    ShuffledTasks pairs(3, 2), eights(4, 8);
    const World start = net(40);
    CHECK(first_departure(start, std::array<Tasks*, 2>{&pairs, &eights}, is_long ? 100 : 20,
                          [](World& w, Tasks*) { w.tick(); }) == "");
}

TEST_CASE("workers drop the same contacts beyond the capacity as one thread") {
    WorldDef def = scene::small_def();
    def.bodies_max = def.shapes_max = 300;
    def.contacts_max = 130;
    World world = scene::made(World::create(def));
    scene::add_floor(world);
    for (int i = 0; i < 200; ++i)
        scene::add_crate(world, scene::at(i % 7 * 0.98, 0.5 + i / 49 * 0.98, i / 7 % 7 * 0.98));
    const auto pool = make_worker_pool(4);
    ShuffledTasks shuffled(9);
    CHECK(first_departure(world, std::array<Tasks*, 2>{pool.get(), &shuffled}, 20,
                          [](World& w, Tasks*) { w.tick(); }) == "");
    world.tick();
    CHECK(world.faults().contacts_dropped > 0);
}

TEST_CASE("tasks are not part of a world: a clone has none and tasks can change between ticks") {
    const auto game = small_scene(*find_scene("pile"));
    World world = game->start().value();
    ShuffledTasks first(1), second(2);
    world.set_tasks(&first);
    for (int t = 0; t < 5; ++t) world.tick();
    CHECK(first.runs > 0);
    const std::uint64_t runs = first.runs;
    World copy = world.clone();
    world.set_tasks(&second);
    for (int t = 0; t < 5; ++t) world.tick(), copy.tick();
    CHECK(first.runs == runs);
    CHECK(second.runs > 0);
    world.set_tasks(nullptr);
    const std::uint64_t before = second.runs;
    world.tick(), copy.tick();
    CHECK(second.runs == before);
    CHECK(world.hash() == copy.hash());
}

TEST_CASE("the thread that ticks on a pool allocates no more than a thread that ticks alone") {
    const auto allocations = [](Tasks* tasks) {
        const auto game = make_scene("pyramid", {.size = 12}).value();
        World world = game->start().value();
        world.set_tasks(tasks);
        for (int t = 0; t < 20; ++t) world.tick();
        const AllocationCounter counter;
        for (int t = 0; t < 20; ++t) world.tick();
        return counter.count();
    };
    const auto pool = make_worker_pool(2);
    CHECK(allocations(nullptr) == 0);
    CHECK(allocations(pool.get()) == 0);
}
