// Opens a recording together with the game that plays it.
#pragma once

#include "cli/commands.h"
#include "cli/scene_choice.h"
#include "replay/recording.h"

namespace lockstone::cli {

/// The options --memory and --commands: the limits for a file from an untrusted source.
struct LimitChoice {
    std::uint32_t memory_mb = 1024;
    std::uint32_t commands = replay::Limits{}.commands_per_tick;

    replay::Limits limits() const { return {std::uint64_t{memory_mb} << 20, commands}; }
    /// Limits with half of the memory, for commands that open two recordings at a time.
    replay::Limits half() const { return {std::uint64_t{memory_mb} << 19, commands}; }
};
void describe_limits(CLI::App& command, LimitChoice& choice);

struct Loaded {
    replay::Recording recording;
    std::unique_ptr<Game> game; ///< null for a recording of commands, which needs no game
};
/// Opens a recording and its game. The error names the file, the place and the reason. A file that ends too early (as
/// after a crash) is opened up to its last whole chunk, and stderr says what is missing.
Result<Loaded> load(const std::string& path, const replay::Limits& limits);
/// Like load(), but without the message about a cut file, for callers that report it themselves.
Result<Loaded> load_quietly(const std::string& path, const replay::Limits& limits);
Result<replay::Recording> open_recording(const std::string& path, const replay::Limits& limits);

} // namespace lockstone::cli
