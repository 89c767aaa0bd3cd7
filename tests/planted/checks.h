// The checks that must catch planted faults, by subject.
#pragma once

#include "lockstone/game.h"
#include "support/sim_replay.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace planted {

using namespace lockstone;
using namespace lockstone::test;

/// A name and a function that returns an error sentence, or an empty string.
using Check = std::function<std::string()>;
using Checks = std::vector<std::pair<std::string, Check>>;

Checks world_checks();     ///< proofs, the golden table, a world and its state
Checks shape_checks();     ///< shapes and their manifolds
Checks motion_checks();    ///< fast bodies, bodies far out, the order of contacts, torn joints
Checks thread_checks();    ///< work that workers share, and lanes
Checks session_checks();   ///< peers, relays, late joins
Checks replay_checks();    ///< recordings
Checks interface_checks(); ///< wrong arguments, files and games

/// The scripted pile of the tests: bodies are created and destroyed, commands of all kinds, game columns, counted
/// events.
class ScriptGame final : public Game {
  public:
    std::string name() const override { return "script"; }
    std::uint64_t content_id() const override { return 1; }
    std::uint32_t player_count() const override { return 0; }
    std::uint32_t input_size() const override { return 0; }
    Result<World> start() const override {
        World world = scene::start_script(scene::Scenery::pile);
        for (int i = 0; i < 30; ++i) scene::step_script(world);
        return world;
    }
    Status advance(World& world, std::span<const PlayerInput>) const override {
        scene::step_script(world);
        return {};
    }
};

} // namespace planted
