// Where the players' inputs of a run come from: the scene's script, a text file, or a recording.
//
// The text file, one input a line; an input is held until the same player's next line, and zero before his first:
//
//   # tick  player  bytes in hex, or - for nothing pressed
//   0       0       7f0000
//   30      0       -
//   30      1       008102
//
// Blank lines and what follows # are left out. Ticks of a player must ascend.
#pragma once

#include "lockstone/game.h"
#include "replay/recording.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lockstone::cli {

/// One line of the text file.
struct HeldInput {
    std::uint64_t tick;
    std::vector<std::byte> bytes;
};
/// By player. `name` stands in error sentences, which name the line.
Result<std::vector<std::vector<HeldInput>>> parse_inputs(const std::string& text, const std::string& name,
                                                         std::uint32_t players, std::uint32_t input_size);

class InputSource {
  public:
    /// What scripted_input says.
    static InputSource scripted(const Game& game, std::uint64_t seed);
    /// Nothing pressed, ever.
    static InputSource idle(const Game& game);
    /// A text file or a recording, told apart by their first bytes. After a recording's end nothing is pressed.
    static Result<InputSource> open(const Game& game, const std::string& path);

    /// Valid until the next call. Any order of ticks.
    std::span<const PlayerInput> at(std::uint64_t tick);

  private:
    explicit InputSource(const Game& rules);
    void play_recording(std::uint64_t tick);
    void play_script(std::uint64_t tick);

    const Game* game;
    std::optional<std::uint64_t> seed;        ///< scripted
    std::vector<std::vector<HeldInput>> held; ///< by player
    std::optional<replay::Recording> recording;
    replay::TickBlock block;
    std::vector<std::byte> bytes; ///< of all players
    std::vector<PlayerInput> inputs;
};

} // namespace lockstone::cli
