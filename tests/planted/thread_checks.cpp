// Work that workers share, and lanes.
#include "checks.h"
#include "lanes/checked_lanes.h"
#include "lockstone/testing.h"
#include "metamorphic/worlds/draw.h"
#include "metamorphic/worlds/kept.h"
#include "solve/contacts/contact.h"
#include "solve/contacts/contact_order.h"
#include "solve/contacts/contact_packs.h"
#include "support/rigs/feature_pit.h"
#include "support/task_worlds.h"

namespace planted {

namespace {

/// Ticks two equal worlds, one of them on a host that runs one strand after the previous one, in random order.
template <class Advance>
std::string parts_with_strands(World world, std::uint32_t workers, int ticks, Advance&& advance) {
    ShuffledTasks tasks(workers, workers);
    World shared = world.clone();
    shared.set_tasks(&tasks);
    for (int t = 0; t < ticks; ++t) {
        advance(world), advance(shared);
        if (world.hash() != shared.hash()) return scene::difference(world, shared);
    }
    return {};
}

/// A net of joints in which hundreds wait for others; ragdolls whose points open while they fall, and are closed; a
/// heap of boxes; a pyramid, which is so deep that all passes of a tick are one run.
std::string strands_agree() {
    for (const std::uint32_t workers : {2u, 5u})
        if (std::string found = parts_with_strands(net(40), workers, 12, [](World& w) { w.tick(); });
            !found.empty())
            return "a net: " + found;
    for (const char* name : {"ragdolls", "pile", "pyramid"}) {
        const auto game = make_scene(name).value();
        ScriptedInputs inputs(*game);
        const auto advance = [&](World& w) { scene::done(game->advance(w, inputs.at(w.tick_count()))); };
        World world = game->start().value();
        for (int t = 0; t < 30; ++t) advance(world);
        if (std::string found = parts_with_strands(world.clone(), 2, 90, advance); !found.empty())
            return name + (": " + found);
    }
    return {};
}

/// Towers that run all passes of a tick tower by tower, and towers that run pass by pass.
std::string islands_agree() {
    Islands islands = towers(4000), passes = towers(4000);
    add_pendulum(passes.world);
    return first_difference(islands, passes, 16);
}

/// Planks that turn fast enough to be followed, with boxes on them.
std::string instruction_sets_agree() {
    const auto end_of = [](Simd level) {
        const auto game = make_scene("bridge", {.size = 40}).value();
        World world = game->start().value();
        if (!world.set_simd(level)) return std::uint64_t{0};
        for (int tick = 0; tick < 64; ++tick) scene::done(game->advance(world, {}));
        return world.hash();
    };
    const std::uint64_t plain = end_of(Simd::scalar);
    for (const Simd level : every_simd)
        if (const std::uint64_t hash = end_of(level); hash != 0 && hash != plain)
            return "a set of lanes gives other bits than plain integers";
    return {};
}

/// Rolling, bouncing and locked bodies, on several workers and instruction sets.
std::string heaps_agree() {
    for (const unsigned kind : {features::rolls, features::bounces, features::locks})
        if (std::string found = features::first_difference(200, kind, kind, 40); !found.empty())
            return "feature " + std::to_string(kind) + ": " + found;
    return {};
}

/// Small worlds that once differed.
std::string kept_worlds_agree() {
    for (const worlds::KeptStory& kept : worlds::kept_stories())
        if (std::string found = worlds::first_apart(kept.story); !found.empty())
            return std::string(kept.about) + ": " + found;
    return {};
}

/// Some of the random worlds, each in several modes.
std::string random_worlds_agree() {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const worlds::Story story =
            worlds::draw(seed, {.bodies_most = 300, .work = 1500, .has_large = false}).story;
        const worlds::Course expected = worlds::run(story, worlds::reference_mode());
        Random random = Random::seeded(seed, 98);
        for (int i = 0; i < 4; ++i) {
            const worlds::Mode mode = worlds::draw_mode(random);
            if (const auto found = worlds::departure(story, expected, mode))
                return "seed " + std::to_string(seed) + ", " + to_string(mode) + ", tick " +
                       std::to_string(found->tick) + ": " + found->about;
        }
    }
    return {};
}

/// One ContactPacks makes the packs of a column, then those of the reversed column.
std::string packs_follow_another_order() {
    constexpr std::uint32_t count = 100;
    solve::SolverBodies bodies;
    bodies.body.resize(count + 2), bodies.step.resize(count + 2);
    for (std::uint32_t b = 1; b <= count; ++b) bodies.step[b].movable = true;
    const std::vector<Transform> poses(count + 1);
    solve::ContactOrder order;
    solve::ContactPacks packs;
    for (const bool upside_down : {false, true}) {
        std::vector<solve::ContactHead> heads;
        for (std::uint32_t b = 1; b <= count; ++b)
            heads.push_back({upside_down ? (b + 1) % (count + 1) : b - 1, b, solve::ContactOrder::touches});
        order.find(heads, bodies);
        packs.make(order, {4, 1, false, 2000}, poses);
        if (std::string found = packs.order_fault(order); !found.empty()) return "a column: " + found;
    }
    return {};
}

/// Pairs of cars, each pair on one movable plate that both push.
World cars_on_plates(int pairs) {
    WorldDef def = scene::small_def();
    World world = scene::made(World::create(def));
    scene::add_floor(world);
    for (int i = 0; i < pairs; ++i) {
        scene::add(world, {.pose = scene::at(40 * i, 0.5, 0), .mass = 20000_r},
                   {.geometry = box(15_r, 0.5_r, 15_r)});
        for (int side : {-1, 1}) {
            const BodyId chassis =
                scene::add(world, {.pose = scene::at(40 * i + 5 * side, 1.8, 0), .mass = 1200_r},
                           {.geometry = box(0.8_r, 0.3_r, 2_r)});
            scene::made(world.create_vehicle(four_wheels(chassis, scene::vec(0.75, -0.3, 1.4))));
        }
    }
    return world;
}

/// Plans of contacts, joints and vehicles, alone and on workers, tick by tick: a net of joints, figures, a deep pile,
/// cars on plates, rolling and bouncing bodies, and towers that are islands.
std::string plans_keep_the_order() {
    const auto first_fault = [](World world, int ticks) {
        for (int t = 0; t < ticks; ++t) {
            world.tick();
            if (std::string found = testing::order_fault(world); !found.empty())
                return "tick " + std::to_string(t) + ": " + found;
        }
        return std::string();
    };
    World pyramid = make_scene("pyramid").value()->start().value();
    for (int t = 0; t < 30; ++t) pyramid.tick();
    const World starts[] = {net(30),
                            make_scene("ragdolls").value()->start().value(),
                            std::move(pyramid),
                            cars_on_plates(3),
                            features::pit(300, features::rolls, 1),
                            features::pit(300, features::bounces, 1)};
    for (const std::uint32_t workers : {1u, 2u, 5u}) {
        ShuffledTasks tasks(workers, workers);
        for (const World& start : starts) {
            World world = start.clone();
            if (workers > 1) world.set_tasks(&tasks);
            if (std::string found = first_fault(std::move(world), 40); !found.empty())
                return std::to_string(workers) + " workers, " + found;
        }
    }
    if (std::string found = packs_follow_another_order(); !found.empty()) return found;
    return first_fault(towers(2500, 3).world, 12);
}

/// The scalar kernels of this program record each read of unspecified bits of a lane.
std::string lanes_have_meaning() {
    for (const auto& [name, size] :
         {std::pair{"convex-pile", 20u}, std::pair{"ragdolls", 1u}, std::pair{"joint-grid", 0u}}) {
        const auto game = make_scene(name, {.size = size}).value();
        World world = game->start().value();
        if (!world.set_simd(Simd::scalar)) return "a world has no plain set";
        for (int tick = 0; tick < 64; ++tick) scene::done(game->advance(world, {}));
        if (LaneFaults::count != 0)
            return std::string(name) + ": bits without a meaning are read: " + LaneFaults::first.load();
    }
    return {};
}

} // namespace

Checks thread_checks() {
    return {{"strands agree", strands_agree},
            {"islands agree", islands_agree},
            {"plans keep the order", plans_keep_the_order},
            {"instruction sets agree", instruction_sets_agree},
            {"heaps agree", heaps_agree},
            {"kept worlds agree", kept_worlds_agree},
            {"random worlds agree", random_worlds_agree},
            {"lanes have a meaning", lanes_have_meaning}};
}

} // namespace planted
