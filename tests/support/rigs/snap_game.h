// Two joints that break in one tick of a session.
#pragma once

#include "lockstone/session.h"
#include "support/sim_scenes.h"

#include <algorithm>
#include <array>
#include <vector>

namespace lockstone::test {

/// Two weights on joints that cannot carry them. The first joint belongs to the later bodies.
struct SnapGame : Game {
    std::string name() const override { return "snap"; }
    std::uint64_t content_id() const override { return 1; }
    std::uint32_t player_count() const override { return 1; }
    std::uint32_t input_size() const override { return 1; }
    Result<World> start() const override {
        World world = World::create({}).value();
        std::vector<BodyId> posts, weights;
        for (int i = 0; i < 2; ++i) {
            posts.push_back(
                scene::made(world.create_body({.kind = BodyKind::static_, .pose = scene::at(5 * i, 0, 0)})));
            weights.push_back(scene::add_ball(world, scene::at(5 * i, -1, 0), 0.25));
        }
        JointDef weak = ball_joint();
        weak.break_force = 1_r;
        for (const std::size_t i : {1u, 0u})
            scene::made(world.create_joint(weak, posts[i], weights[i], world.pose(posts[i])));
        return world;
    }
    Status advance(World& world, std::span<const PlayerInput>) const override {
        world.tick();
        return {};
    }
};

struct Snapped {
    std::vector<JointId> joints; ///< before the first tick, ascending
    std::vector<JointId> told;   ///< broken joints, in the order of a session's events
};
inline Snapped run_snap_game() {
    const SnapGame game;
    World world = game.start().value();
    Snapped snapped;
    for (const BodyId body : world.bodies())
        if (world.kind(body) == BodyKind::static_) snapped.joints.push_back(world.joints(body).at(0));
    std::ranges::sort(snapped.joints);
    SimulatedNetwork network(1, {}, 1);
    const auto session = make_rollback_session(session_def(game, 0, {0}), network.endpoint(0)).value();
    WorldSimulation simulation(world, game);
    SessionRunner runner(*session, simulation);
    for (std::uint64_t frame = 0; frame < 10; ++frame) {
        session->add_local_input(0, std::array{std::byte{}});
        runner.frame(frame * 16);
        for (const SessionEvent& e : runner.events())
            if (e.event.kind == EventKind::joint_break) snapped.told.push_back(e.event.joint);
    }
    return snapped;
}

} // namespace lockstone::test
