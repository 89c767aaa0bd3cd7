// Recordings made of recordings. What if: copied up to a time, to go on from there with other inputs or commands.
// Also: repair makes a complete file of a damaged one, add_keyframes adds keyframes afterwards.
#pragma once

#include "replay/player.h"
#include "replay/recorder.h"

namespace lockstone::replay {

/// A recorder whose next tick is `at`, and the world as it stands there. HEAD tells the origin: options "branch.of" (the
/// source's checksum) and "branch.at".
struct InputBranch {
    InputRecorder recorder;
    World world;
};
Result<InputBranch> branch_inputs(const Recording& source, const Game& game, std::uint64_t at, Sink& sink,
                                  const RecorderOptions& options = {});

/// The same for commands. Attach by CommandRecorder::resume(std::move(writer), world, keyframe_ticks) once `world`
/// has its place.
struct CommandBranch {
    Writer writer;
    World world;
};
Result<CommandBranch> branch_commands(const Recording& source, std::uint64_t at, Sink& sink,
                                      const RecorderOptions& options = {});

/// All ticks of a recording that was cut or damaged, as a complete file: nothing is simulated. HEAD tells the origin:
/// options "repaired.of" (the checksum of the last whole chunk) and "repaired.end" (the time where it ends).
Status repair(const Recording& source, Sink& sink);

/// The whole recording again with keyframes every keyframe_ticks, made by re-simulation: for one that was fed from a
/// confirmed timeline, where no state was at hand, or that was recovered. Ends as a complete recording. Refuses a
/// recording that re-simulation does not reproduce. The options are those of the source.
Status add_keyframes(const Recording& source, const Game* game, Sink& sink,
                     const RecorderOptions& options = {});

} // namespace lockstone::replay
