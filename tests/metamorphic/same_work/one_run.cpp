// Passes of contacts that are one run, and islands that run all passes of a tick in a row, give the bits of single
// passes.
#include "lockstone/testing.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <string_view>

using namespace lockstone;
using namespace lockstone::test;
using namespace lockstone::test::scene;

namespace {

struct Phases final : PhaseObserver {
    bool any_relaxing = false; ///< the passes are single phases
    void on_phase(const char* phase) override { any_relaxing |= std::string_view(phase) == "relax_contacts"; }
};

} // namespace

TEST_CASE(
    "islands that run all passes of a tick in sequence end like islands that each run a pass at a time") {
    constexpr int count = 4000;
    const auto pool = make_worker_pool(2);
    ShuffledTasks shuffled(5, 2);
    for (Tasks* tasks : {static_cast<Tasks*>(nullptr), pool.get(), static_cast<Tasks*>(&shuffled)}) {
        Islands islands = towers(count), passes = towers(count), moved = towers(count);
        add_pendulum(passes.world), add_pendulum(moved.world);
        islands.world.set_tasks(tasks);
        CHECK(first_difference(islands, passes, 10) == ""); // the first ticks have no contacts
        for (int t = 0; t < 10; ++t) moved.world.tick();
        Phases of_islands, of_passes;
        islands.world.observe_phases(&of_islands), passes.world.observe_phases(&of_passes);
        CHECK(first_difference(islands, passes, 10) == "");
        CHECK_FALSE(of_islands.any_relaxing);
        CHECK(of_passes.any_relaxing);
        const Transform pose =
            moved.world.pose(moved.bodies[100]); // negative control: a crate moves by a step of the format
        done(moved.world.set_pose(moved.bodies[100],
                                  {pose.position + Vec3{Real::from_raw(64), Real{}, Real{}}, pose.rotation}));
        for (int t = 0; t < 10; ++t) moved.world.tick();
        CHECK(first_difference(islands, moved, 3) != "");
    }
}

TEST_CASE(
    "a deep pile with all passes in one run on several workers ends like one with a run for each pass") {
    const auto game = make_scene("pyramid").value();
    World alone = game->start().value(), shared = alone.clone();
    const auto pool = make_worker_pool(2);
    shared.set_tasks(pool.get());
    Phases of_alone, of_shared;
    alone.observe_phases(&of_alone);
    for (int t = 0; t < 60; ++t) {
        alone.tick();
        if (t == 40) shared.observe_phases(&of_shared);
        shared.tick();
        REQUIRE(alone.hash() == shared.hash());
    }
    CHECK(of_alone.any_relaxing);
    CHECK_FALSE(of_shared.any_relaxing);
}

// A lift without contacts is in no strand. It once stayed in place where all passes were one run, and where islands ran
// all of their passes.
TEST_CASE("a lift without contacts moves and turns if passes run one by one or in one run or by island") {
    const auto lifted = [](World world, Tasks* tasks, const char* path) {
        const BodyId lift = add(world,
                                {.kind = BodyKind::kinematic,
                                 .pose = at(-300, 50, 0),
                                 .linear_velocity = vec(0, 2, 0),
                                 .angular_velocity = vec(0, 1, 0)},
                                {.geometry = box(1_r, 1_r, 1_r)});
        world.set_tasks(tasks);
        bool took = false;
        const auto names = testing::path_names();
        for (int t = 0; t < 60; ++t) {
            world.tick();
            const testing::PathSet paths = testing::paths_taken(world);
            for (std::size_t p = 0; p < names.size(); ++p) took |= names[p] == path && paths[p];
        }
        CHECK_MESSAGE(took, path);
        CHECK(std::abs(position(world, lift)[1] - 52) < 0.001);
        CHECK(std::abs(to_double(world.pose(lift).rotation.y) - std::sin(0.5)) < 0.001);
    };
    ShuffledTasks shuffled(5, 2);
    lifted(towers(10).world, nullptr, "passes_one_by_one");
    lifted(make_scene("pyramid").value()->start().value(), &shuffled, "passes_in_one_run");
    lifted(towers(4000).world, nullptr, "passes_by_island");
    lifted(towers(4000).world, &shuffled, "passes_by_island");
}
