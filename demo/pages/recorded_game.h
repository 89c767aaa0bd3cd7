#pragma once
/// A recording together with the scene that plays it.

#include "lockstone/game.h"
#include "replay/player.h"

#include <memory>
#include <string>

namespace lockstone::demo {

struct RecordedGame {
    replay::Recording recording;
    std::unique_ptr<Game> game; ///< null if the recording holds commands, which need none
};

/// Of a file. What a crash has cut off is named on stderr. The error names the file, the place and the reason.
Result<RecordedGame> open_recording(const std::string& path);

} // namespace lockstone::demo
