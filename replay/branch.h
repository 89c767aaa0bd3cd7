// What if: a recording copied up to a time, to go on from there with other inputs or commands.
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

} // namespace lockstone::replay
