#include "cli/scene_choice.h"

namespace lockstone::cli {

void describe_options(CLI::App& command, SceneOptions& options) {
    add_number(
        command, "--size", options.size,
        "size of the scene: the number of objects that `lockstone scenes` names; 0: the scene's default");
    add_number(command, "--seed", options.seed, "seed of placement and random numbers");
    add_number(command, "--players", options.players, "number of players; 0: the scene's default");
}

void describe_scene(CLI::App& command, SceneChoice& choice) {
    add_text(command, "SCENE", choice.scene, "name of a scene, see `lockstone scenes`").required();
    describe_options(command, choice.options);
}

Result<Started> start(const SceneChoice& choice) {
    Result<std::unique_ptr<Game>> game = make_scene(choice.scene, choice.options);
    if (!game) return game.error();
    Result<World> world = (*game)->start();
    if (!world) return Error{choice.scene + ": cannot start: " + world.error().message};
    return Started{std::move(*game), std::move(*world)};
}

Result<std::unique_ptr<Game>> scene_of_recording(const std::string& file, const std::string& game_name) {
    Result<std::unique_ptr<Game>> game = make_scene_named(game_name);
    if (!game)
        return Error{file + ": was recorded with a game that is not built in: " + game.error().message};
    return game;
}

} // namespace lockstone::cli
