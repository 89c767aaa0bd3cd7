#pragma once
/// The command line of the demo.

#include "scenes/scenes.h"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace lockstone::demo {

struct Options {
    std::string source = "rollback-arena"; ///< a scene's name, or a replay file
    std::string asset_file;                ///< shown instead of a scene; empty: none
    SceneOptions scene;
    std::optional<std::uint64_t> ticks; ///< how long to play; of a replay: how far
    std::string input_file;             ///< inputs to play, text or a replay; empty: people or the script
    std::string record_file;
    std::string frames_folder;      ///< empty: lockstone-frames; in a window then only F12 writes
    std::uint64_t frame_every = 60; ///< ticks per picture
    int width = 1280, height = 720; ///< [px]
    bool offscreen = false;
    bool figures = false; ///< the thesis' four pictures of a recording
    bool compare = false; ///< the thesis' engine beside ours
    bool netplay = false;
    std::uint32_t latency_ms = 80;  ///< one way
    std::uint32_t loss_percent = 5; ///< of packets
    bool script = false;            ///< nobody plays; the program ends by itself
    std::vector<std::string> show;  ///< what is switched on from the start: "wireframe", "contacts", ...

    bool source_is_file() const;
};

/// The options; or the exit status when there is nothing to do (help: 0, bad usage: 2, said on stderr).
std::variant<Options, int> parse_options(int argc, char** argv);

/// The scene or the asset that the options choose. The error names the scene, the file, the reason.
Result<std::unique_ptr<Game>> make_game(const Options& options);

} // namespace lockstone::demo
