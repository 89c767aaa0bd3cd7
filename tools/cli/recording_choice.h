// A recording and the game that plays it.
#pragma once

#include "cli/scene_choice.h"
#include "replay/recording.h"

namespace lockstone::cli {

struct Loaded {
    replay::Recording recording;
    std::unique_ptr<Game> game; ///< null in commands mode, which needs none
};
/// The error names the file, the place and the reason.
Result<Loaded> load(const std::string& path);

} // namespace lockstone::cli
