#include "cli/recording_choice.h"

namespace lockstone::cli {

Result<Loaded> load(const std::string& path) {
    Result<replay::Recording> recording = replay::Recording::open(path);
    if (!recording) return recording.error();
    Loaded loaded{std::move(*recording), nullptr};
    if (loaded.recording.header().mode == replay::Mode::commands) return loaded;
    Result<std::unique_ptr<Game>> game = scene_of_recording(path, loaded.recording.header().game);
    if (!game) return game.error();
    loaded.game = std::move(*game);
    return loaded;
}

} // namespace lockstone::cli
