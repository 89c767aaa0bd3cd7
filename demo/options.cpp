#include "options.h"

#include "cli/text.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>

namespace lockstone::demo {
namespace {

std::string scene_list() {
    std::string list = "\nScenes:\n";
    for (const SceneInfo& info : scenes()) {
        std::string name(info.name);
        name.resize(std::max<std::size_t>(name.size() + 2, 18), ' ');
        list += "  " + name + std::string(info.sentence) + "\n";
    }
    return list + "\nF1 lists the keys in the window. Without a display the demo writes pictures into a "
                  "folder.\nExit status: 0 all ticks bit-exact, 1 a tick differs, 2 bad usage or bad input.";
}

/// Accepts only digits: the parser's own conversion accepts -1 as the largest number.
CLI::Validator whole_number(std::uint64_t most) {
    const auto check = [most](const std::string& text) {
        const std::optional<std::uint64_t> value = cli::number_of(text);
        return value && *value <= most
                   ? std::string()
                   : "'" + text + "' is not a whole number from 0 to " + std::to_string(most);
    };
    return {check, ""};
}

void add_options(CLI::App& app, Options& options) {
    app.add_option("source", options.source,
                   "a scene or a replay file (.lsr); default rollback-arena, with --compare two-blocks");
    app.add_option("--asset", options.asset_file,
                   "asset file of `lockstone cook` to show instead of a scene");
    app.add_option("--size", options.scene.size,
                   "size of the scene: the number of objects that `lockstone scenes` names")
        ->check(whole_number(UINT32_MAX));
    app.add_option("--seed", options.scene.seed, "seed of the scene and of scripted players")
        ->check(whole_number(UINT64_MAX));
    app.add_option("--players", options.scene.players,
                   "number of players; default: the scene's own number, but at least 1, 2 with --netplay, or "
                   "one for each machine with --host, if the scene can have them")
        ->check(whole_number(UINT32_MAX));
    app.add_option("--ticks", options.ticks,
                   "number of ticks to play, of a scene or of a replay from its start")
        ->check(CLI::Range(1, 1'000'000));
    app.add_option("--input", options.input_file,
                   "play the inputs of this file: text as for `lockstone run`, or a replay");
    app.add_option("--record", options.record_file, "write a replay to this file");
    app.add_option("--frames", options.frames_folder, "write PNG pictures into this folder");
    app.add_option("--frame-every", options.frame_every, "ticks per picture, default 60")
        ->check(CLI::Range(1, 1'000'000));
    app.add_option("--width", options.width, "width of the picture [px]")->check(CLI::Range(64, 8192));
    app.add_option("--height", options.height, "height of the picture [px]")->check(CLI::Range(64, 8192));
    app.add_flag("--offscreen", options.offscreen, "draw into memory even if there is a display");
    app.add_flag("--compare", options.compare,
                 "draw the same scene of the thesis' engine as outlines over Lockstone's");
    app.add_flag("--figures", options.figures,
                 "draw the four moments of the thesis' figures from a recording of two-blocks");
    app.add_flag("--netplay", options.netplay, "two rollback peers side by side over a simulated network");
    app.add_option("--latency", options.latency_ms, "one-way delay with --netplay [ms], default 80")
        ->check(CLI::Range(0, 400));
    app.add_option("--loss", options.loss_percent, "lost packets with --netplay [%], default 5")
        ->check(CLI::Range(0, 60));
    app.add_flag("--host", options.host, "open a match over UDP and print the command that others join with");
    const CLI::Validator given(
        [](const std::string& text) { return text.empty() ? "the value is empty" : ""; }, "");
    app.add_option("--join", options.join, "join a match by the CODE@ADDRESS:PORT#KEY that its host prints")
        ->check(given);
    app.add_option("--watch", options.watch,
                   "watch a match by the CODE@ADDRESS:PORT#KEY that its host prints")
        ->check(given);
    app.add_option("--machines", options.machines,
                   "number of machines with --host, default 2; bots control the other players")
        ->check(CLI::Range(2, 4));
    app.add_option("--relay", options.relay,
                   "ADDRESS:PORT#KEY of a `lockstone relay` for --host; default: the host starts a relay")
        ->check(given);
    app.add_option("--port", options.port, "UDP port of the relay that --host starts, default any free port")
        ->check(CLI::Range(0, 65535));
    app.add_option("--plant", options.plant,
                   "with --host or --join: change this machine's world at this tick, to see the report")
        ->check(whole_number(UINT64_MAX));
    app.add_option("--show", options.show, "displays to switch on, separated by commas")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"wireframe", "contacts", "bounds", "joints", "help"}));
    app.add_flag("--script", options.script, "scripts control all players; ends after the last tick");
}

/// Checks combinations of options, which CLI11 cannot check. Returns an empty text if they fit together.
std::string contradiction(const Options& options) {
    const int online = options.host + !options.join.empty() + !options.watch.empty();
    if (options.netplay + options.compare + options.figures + online > 1)
        return "only one can be shown of --netplay, --compare, --figures, --host, --join and --watch";
    if (options.online() && !options.input_file.empty())
        return "a match over UDP reads no input file: leave --input out";
    if (options.online() && !options.asset_file.empty())
        return "a match over UDP needs a scene, not an asset";
    if (options.online() && options.source_is_file())
        return "a match over UDP needs a scene, not the replay file " + options.source;
    if (!options.host && (!options.relay.empty() || options.port != 0))
        return "--relay and --port go with --host";
    if (!options.relay.empty() && options.port != 0)
        return "--port is for the relay that --host starts: leave --port or --relay out";
    if (options.plant && !options.host && options.join.empty()) return "--plant goes with --host or --join";
    if (!options.asset_file.empty() && options.netplay) return "--netplay needs a scene, not an asset";
    if (options.compare && !options.record_file.empty())
        return "--compare records nothing: leave --record out";
    if (options.compare && !options.input_file.empty())
        return "--compare uses scripted inputs: leave --input out";
    if (options.figures && !options.source_is_file()) return "--figures needs a replay file";
    if (!options.source_is_file()) return {};
    if (options.netplay || options.compare)
        return std::string(options.netplay ? "--netplay" : "--compare") + " needs a scene, not a replay file";
    if (!options.record_file.empty()) return "--record needs a scene: " + options.source + " is a recording";
    if (!options.input_file.empty())
        return "--input needs a scene: " + options.source + " has its own inputs";
    return {};
}

/// Options without effect on the chosen page; empty if there are none.
std::string misplaced(const CLI::App& app, const Options& options) {
    if (app.count("--machines") != 0 && !options.host) return "--machines goes with --host";
    if (app.count("--latency") + app.count("--loss") != 0 && !options.netplay)
        return "--latency and --loss go with --netplay";
    return {};
}

/// A person at a window wants to play, so a scene gets a player even if it has none by default.
void add_default_players(Options& options) {
    const SceneInfo* info = options.asset_file.empty() ? find_scene(options.source) : nullptr;
    if (info == nullptr) return;
    const std::uint32_t wanted = options.host ? options.machines : options.netplay ? 2 : 1;
    options.scene.players = std::max(info->players_default, std::min(wanted, info->players_max));
}

} // namespace

bool Options::source_is_file() const {
    if (!asset_file.empty()) return false;
    if (find_scene(source) != nullptr) return false;
    const std::filesystem::path path(source);
    return path.extension() == ".lsr" || path.has_parent_path() || std::filesystem::exists(path);
}

Result<std::unique_ptr<Game>> make_game(const Options& options) {
    if (options.asset_file.empty()) return make_scene(options.source, options.scene);
    AssetLibrary library;
    const Result<AssetId> id = load_assets(options.asset_file, library);
    if (!id) return id.error();
    return make_asset_scene(std::make_shared<const AssetLibrary>(std::move(library)), *id, options.scene);
}

std::variant<Options, int> parse_options(int argc, char** argv) {
    Options options;
    CLI::App app("Shows a scene or a replay of Lockstone, and proves that its replay is bit-exact.",
                 "lockstone-demo");
    app.footer(scene_list());
    add_options(app, options);
    try {
        app.parse(argc, argv);
        if (!options.asset_file.empty() && app.count("source") != 0)
            throw CLI::ValidationError("--asset replaces the scene: leave " + options.source + " out");
    } catch (const CLI::CallForHelp&) {
        std::printf("%s", app.help().c_str());
        return 0;
    } catch (const CLI::ParseError& error) {
        std::fprintf(stderr, "lockstone-demo: %s\n", error.what());
        return 2;
    }
    options.source_given = app.count("source") != 0;
    if (options.compare && !options.source_given) options.source = "two-blocks"; // the scene of the thesis
    if (options.figures) options.frame_every = 1; // each of its steps is a picture
    std::string why = contradiction(options);
    if (why.empty()) why = misplaced(app, options);
    if (why.empty())
        if (const Status can =
                cli::check_outputs({options.record_file}, {options.input_file, options.asset_file});
            !can)
            why = can.error().message;
    if (!why.empty()) {
        std::fprintf(stderr, "lockstone-demo: %s\n", why.c_str());
        return 2;
    }
    if (app.count("--players") == 0 && !options.compare) add_default_players(options);
    return options;
}

} // namespace lockstone::demo
