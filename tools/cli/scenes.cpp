// The command `lockstone scenes`.
#include "scenes/scenes.h"
#include "cli/commands.h"
#include "json/json.h"

#include <cstdio>

namespace lockstone::cli {
namespace {

struct Args {
    bool json = false;
};

void describe(CLI::App& command, Args& args) {
    add_flag(command, "--json", args.json, "print the list as JSON");
}

std::string options_of(const SceneInfo& info) {
    std::string text;
    if (info.size_max != 0)
        text += "; size: " + std::string(info.size_of) + ", " + std::to_string(info.size_default);
    if (info.players_max != 0)
        text += "; players: " + std::to_string(info.players_min) + " to " + std::to_string(info.players_max);
    return text.empty() ? text : " (" + text.substr(2) + ")";
}

Result<Exit> list(const Args& args) {
    json::Value all = json::Value::array();
    for (const SceneInfo& info : scenes()) {
        if (!args.json)
            std::printf("%-16s%s%s\n", std::string(info.name).c_str(), std::string(info.sentence).c_str(),
                        options_of(info).c_str());
        all.push_back({{"name", info.name},
                       {"sentence", info.sentence},
                       {"size_of", info.size_of},
                       {"size", info.size_default},
                       {"players_min", info.players_min},
                       {"players_max", info.players_max}});
    }
    if (args.json) std::printf("%s\n", all.dump(2).c_str());
    return Exit::good;
}

} // namespace

void add_scenes(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "scenes", "List the built-in scenes.", describe, list);
}

} // namespace lockstone::cli
