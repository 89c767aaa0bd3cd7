// Recordings of the built-in games for the attack, and the games that play them, made once.
#pragma once

#include "scenes/scenes.h"
#include "support/small_recording.h"

#include <memory>
#include <vector>

namespace attack {

using namespace lockstone;
using test::Bytes;

/// A game that makes its start once, because baking terrain would take most of the time.
class Started final : public Game {
  public:
    explicit Started(std::unique_ptr<Game> rules);
    std::string name() const override { return game->name(); }
    std::uint64_t content_id() const override { return game->content_id(); }
    std::uint32_t player_count() const override { return game->player_count(); }
    std::uint32_t input_size() const override { return game->input_size(); }
    Result<World> start() const override { return first.clone(); }
    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        return game->advance(world, inputs);
    }
    Status check(const World& world) const override { return game->check(world); }

    const Game& rules() const { return *game; }

  private:
    std::unique_ptr<Game> game;
    World first;
};

struct SceneRecording {
    std::string name;
    std::unique_ptr<Started> game;
    Bytes file;
    std::vector<std::uint32_t> game_columns; ///< of the state
};

/// All scenes, small. Scenes with columns of their own are in the list several times, with recordings of their first
/// ticks and of later ones.
const std::vector<SceneRecording>& scene_recordings();

} // namespace attack
