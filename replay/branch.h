// Recordings made from recordings. A branch copies a recording up to a time, and goes on with other inputs or
// commands. repair() makes a complete file of a damaged one; add_keyframes() adds keyframes later.
#pragma once

#include "replay/player.h"
#include "replay/recorder.h"

namespace lockstone::replay {

/// A recorder whose next tick is `at`, and the world at that time. Options in HEAD record the origin: "branch.of"
/// (the source's checksum) and "branch.at".
struct InputBranch {
    InputRecorder recorder;
    World world;
};
Result<InputBranch> branch_inputs(const Recording& source, const Game& game, std::uint64_t at, Sink& sink,
                                  const RecorderOptions& options = {});

/// The equivalent for commands. Once `world` is at its final address, attach it by
/// CommandRecorder::resume(std::move(writer), world, keyframe_ticks).
struct CommandBranch {
    Writer writer;
    World world;
};
Result<CommandBranch> branch_commands(const Recording& source, std::uint64_t at, Sink& sink,
                                      const RecorderOptions& options = {});

/// Writes all ticks of a recording that was cut or damaged as a complete file; simulates nothing. Options in HEAD
/// record the origin: "repaired.of" (the checksum of the last whole chunk) and "repaired.end" (the time at which it
/// ends).
Status repair(const Recording& source, Sink& sink);

/// Writes the whole recording with a keyframe every keyframe_ticks, made by re-simulation: for a recording of a
/// confirmed timeline, for which no state was available, or for a recovered one. The result is a complete recording.
/// Fails if re-simulation does not reproduce the recording. HEAD gets the options of the source.
Status add_keyframes(const Recording& source, const Game* game, Sink& sink,
                     const RecorderOptions& options = {});

} // namespace lockstone::replay
