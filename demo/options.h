#pragma once
/// The command line of the demo.

#include "scenes/scenes.h"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace lockstone::demo {

/// How long to play where nothing says so: to files, and with people in front of a window.
constexpr std::uint64_t ticks_default = 600, ticks_default_window = 3600;

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
    // A match over UDP.
    bool host = false;
    std::string join;                   ///< the host's invitation; empty: not joined
    std::string watch;                  ///< the same of a watcher
    std::string relay;                  ///< ADDRESS:PORT#KEY; empty: the host starts one
    std::uint32_t port = 0;             ///< of the relay that the host starts; 0: any
    std::uint32_t machines = 2;         ///< that play the hosted match
    std::optional<std::uint64_t> plant; ///< tick of a fault on purpose, see online/planted_game.h
    bool script = false;                ///< nobody plays; the program ends by itself
    std::vector<std::string> show;      ///< what is switched on from the start: "wireframe", "contacts", ...

    bool source_given = false; ///< by name; else `source` is a default

    bool source_is_file() const;
    bool online() const { return host || !join.empty() || !watch.empty(); }
};

/// The options; or the exit status when there is nothing to do (help: 0, bad usage: 2, said on stderr).
std::variant<Options, int> parse_options(int argc, char** argv);

/// The scene or the asset that the options choose. The error names the scene, the file, the reason.
Result<std::unique_ptr<Game>> make_game(const Options& options);

} // namespace lockstone::demo
