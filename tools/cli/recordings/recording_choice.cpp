#include "cli/recordings/recording_choice.h"

#include "cli/text.h"
#include "replay/sink.h"

namespace lockstone::cli {

void describe_limits(CLI::App& command, LimitChoice& choice) {
    add_number(command, "--memory", choice.memory_mb, "memory limit for recordings [MB], 16 or more", 16,
               1u << 24);
    add_number(command, "--commands", choice.commands,
               "largest number of commands in one tick; an explosion counts as 64", 1);
}

Result<replay::Recording> open_recording(const std::string& path, const replay::Limits& limits) {
    Result<replay::Recording> recording =
        replay::Recording::open(path, replay::OnDamage::recover_cut, limits);
    if (recording && !recording->complete())
        print_notice(recording->damage() + (replay::is_being_written(path)
                                                ? "; it is being written"
                                                : " (lockstone repair makes it complete)"));
    return recording;
}

namespace {

Result<Loaded> with_game(const std::string& path, Result<replay::Recording> recording) {
    if (!recording) return recording.error();
    Loaded loaded{std::move(*recording), nullptr};
    if (loaded.recording.header().mode == replay::Mode::commands) return loaded;
    Result<std::unique_ptr<Game>> game = scene_of_recording(path, loaded.recording.header().game);
    if (!game) return game.error();
    loaded.game = std::move(*game);
    return loaded;
}

} // namespace

Result<Loaded> load(const std::string& path, const replay::Limits& limits) {
    return with_game(path, open_recording(path, limits));
}

Result<Loaded> load_quietly(const std::string& path, const replay::Limits& limits) {
    return with_game(path, replay::Recording::open(path, replay::OnDamage::recover_cut, limits));
}

} // namespace lockstone::cli
