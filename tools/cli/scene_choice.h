// The arguments SCENE, --size, --seed and --players, which are equal in every command that takes a scene.
#pragma once

#include "cli/commands.h"
#include "scenes/scenes.h"

namespace lockstone::cli {

struct SceneChoice {
    std::string scene;
    SceneOptions options;
};
void describe_options(CLI::App& command, SceneOptions& options);
void describe_scene(CLI::App& command, SceneChoice& choice);

struct Started {
    std::unique_ptr<Game> game;
    World world;
};
/// Creates the scene and its world before tick 0.
Result<Started> start(const SceneChoice& choice);

/// Creates the scene that a recording was made with.
Result<std::unique_ptr<Game>> scene_of_recording(const std::string& file, const std::string& game_name);

} // namespace lockstone::cli
