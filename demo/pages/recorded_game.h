#pragma once
/// A recording together with the scene that plays it.

#include "lockstone/game.h"
#include "replay/player.h"

#include <memory>
#include <string>

namespace lockstone::demo {

struct RecordedGame {
    replay::Recording recording;
    std::unique_ptr<Game> game; ///< null for a recording of commands, which needs no game
};

/// Opens a recording from a file. If the file was cut by a crash, stderr says what is missing. The error names the
/// file, the place and the reason.
Result<RecordedGame> open_recording(const std::string& path);

} // namespace lockstone::demo
