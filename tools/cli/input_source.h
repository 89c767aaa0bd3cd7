// The source of the players' inputs in a run: the scene's script, a text file, or a recording.
//
// The text file has one input per line. An input lasts until the next line of the same player; before a player's first
// line it is zero.
//
//   # tick  player  bytes in hex, or - for nothing pressed
//   0       0       7f0000
//   30      0       -
//   30      1       008102
//
// Blank lines are skipped, and so is text after a #. The ticks of each player must ascend.
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
/// The lines of the file by player. Error sentences contain `name` and the number of the line.
Result<std::vector<std::vector<HeldInput>>> parse_inputs(const std::string& text, const std::string& name,
                                                         std::uint32_t players, std::uint32_t input_size);

class InputSource {
  public:
    /// Inputs from scripted_input.
    static InputSource scripted(const Game& game, std::uint64_t seed);
    /// Inputs in which no player ever presses anything.
    static InputSource idle(const Game& game);
    /// Inputs from a text file or a recording; its first bytes decide which it is. After the end of a recording no
    /// input is pressed.
    static Result<InputSource> open(const Game& game, const std::string& path);

    /// The inputs of a tick. Valid until the next call. Ticks may be requested in any order.
    std::span<const PlayerInput> at(std::uint64_t tick);

  private:
    explicit InputSource(const Game& rules);
    void play_recording(std::uint64_t tick);
    void play_script(std::uint64_t tick);

    const Game* game;
    std::optional<std::uint64_t> seed;        ///< set if the source is scripted
    std::vector<std::vector<HeldInput>> held; ///< by player
    std::optional<replay::Recording> recording;
    replay::TickBlock block;
    std::vector<std::byte> bytes; ///< of all players
    std::vector<PlayerInput> inputs;
};

} // namespace lockstone::cli
