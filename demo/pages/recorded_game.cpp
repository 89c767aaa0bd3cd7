#include "recorded_game.h"

#include "scenes/scenes.h"

#include <cstdio>

namespace lockstone::demo {

Result<RecordedGame> open_recording(const std::string& path) {
    Result<replay::Recording> recording = replay::Recording::open(path, replay::OnDamage::recover_cut);
    if (!recording) return recording.error();
    if (!recording->complete()) std::fprintf(stderr, "lockstone-demo: %s\n", recording->damage().c_str());
    std::unique_ptr<Game> game;
    if (recording->header().mode == replay::Mode::inputs) {
        Result<std::unique_ptr<Game>> made = make_scene_named(recording->header().game);
        if (!made) return Error{path + ": cannot be played: " + made.error().message};
        game = std::move(*made);
    }
    return RecordedGame{std::move(*recording), std::move(game)};
}

} // namespace lockstone::demo
