#pragma once
/// The command line of the demo.

#include "scenes/scenes.h"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace lockstone::demo {

/// Default length of a game: without a window, and with a person at a window.
constexpr std::uint64_t ticks_default = 600, ticks_default_window = 3600;

struct Options {
    std::string source = "rollback-arena"; ///< name of a scene, or a recording
    std::string asset_file;                ///< an asset to show in place of a scene; empty: none
    SceneOptions scene;
    std::optional<std::uint64_t> ticks; ///< ticks to play; for a recording: to play up to
    std::string input_file; ///< a file of inputs, text or a recording; empty: people or the script play
    std::string record_file;
    std::string frames_folder;      ///< empty: lockstone-frames; then a window writes pictures only for F12
    std::uint64_t frame_every = 60; ///< ticks per picture
    int width = 1280, height = 720; ///< [px]
    bool offscreen = false;
    bool figures = false; ///< draws the thesis' four pictures of a recording
    bool compare = false; ///< shows the thesis' engine beside Lockstone
    bool netplay = false;
    std::uint32_t latency_ms = 80;  ///< one way
    std::uint32_t loss_percent = 5; ///< of packets
    // Options of a match over UDP:
    bool host = false;
    std::string join;                   ///< the host's invitation; empty: not joined
    std::string watch;                  ///< the invitation of a watcher; empty: does not watch
    std::string relay;                  ///< ADDRESS:PORT#KEY; empty: the host starts one
    std::uint32_t port = 0;             ///< of the relay that the host starts; 0: any
    std::uint32_t machines = 2;         ///< number of machines that play the hosted match
    std::optional<std::uint64_t> plant; ///< tick of a fault on purpose; see online/planted_game.h
    bool script = false;                ///< no person plays; the program ends with the script
    std::vector<std::string> show; ///< view options that are on at the start: "wireframe", "contacts", ...

    bool source_given = false; ///< false: `source` is the default

    bool source_is_file() const;
    bool online() const { return host || !join.empty() || !watch.empty(); }
};

/// Parses the options. Returns an exit status if the program has nothing to run: 0 for help, 2 for bad usage, with a
/// message on stderr.
std::variant<Options, int> parse_options(int argc, char** argv);

/// Makes the game of the chosen scene or asset. The error names the scene, or the file and the reason.
Result<std::unique_ptr<Game>> make_game(const Options& options);

} // namespace lockstone::demo
