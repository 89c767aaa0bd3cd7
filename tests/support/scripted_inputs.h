// Inputs of all players of a game at a tick, from its script.
#pragma once

#include "scenes/scenes.h"

#include <span>
#include <vector>

namespace lockstone::test {

class ScriptedInputs {
  public:
    explicit ScriptedInputs(const Game& from, std::uint64_t seed_of_script = 1)
        : game(from), seed(seed_of_script),
          bytes(game.player_count(), std::vector<std::byte>(game.input_size())), inputs(game.player_count()) {
    }
    /// Valid until the next call.
    std::span<const PlayerInput> at(std::uint64_t tick) {
        for (std::uint32_t p = 0; p < inputs.size(); ++p) {
            scripted_input(game, seed, tick, p, bytes[p]);
            inputs[p] = {bytes[p]};
        }
        return inputs;
    }

  private:
    const Game& game;
    std::uint64_t seed;
    std::vector<std::vector<std::byte>> bytes;
    std::vector<PlayerInput> inputs;
};

} // namespace lockstone::test
