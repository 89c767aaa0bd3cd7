// The built-in scenes: small games that the command line, the tests and the demo share.
//
//   auto game = make_scene("pyramid", {.size = 12});
//   if (!game) return report(game.error().message);      // names the scenes there are
//   World world = (*game)->start().value();
//   std::vector<std::byte> input((*game)->input_size());
//   scripted_input(**game, seed, world.tick_count(), player, input);
//
// Every scene is a lockstone::Game: a pure function of state and inputs. All placement uses fixed point.
#pragma once

#include "lockstone/input.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace lockstone {

struct SceneOptions {
    std::uint32_t size = 0;    ///< 0: the scene's default; SceneInfo::size_of names the unit
    std::uint64_t seed = 1;    ///< for placement and the game's random stream
    std::uint32_t players = 0; ///< 0: the scene's default
};

struct SceneInfo {
    std::string_view name;
    std::string_view sentence;
    std::string_view size_of;   ///< "boxes"; empty if the scene has one size
    std::uint32_t size_default; ///< 0 if the scene has one size
    std::uint32_t size_min, size_max;
    std::uint32_t players_default, players_min, players_max; ///< 0 if the scene has no players
};

/// All scenes in the order of lists.
std::span<const SceneInfo> scenes();
const SceneInfo* find_scene(std::string_view name);

/// Makes a scene. The error lists the scenes and the most similar name, or states the range of the option.
Result<std::unique_ptr<Game>> make_scene(std::string_view name, const SceneOptions& options = {});
/// Makes the game from the Game::name() of a scene: "pile size=1000 seed=1 players=0". Recordings hold this text.
Result<std::unique_ptr<Game>> make_scene_named(std::string_view game_name);

/// A scene that shows an asset. Several copies of a hull or a compound fall onto a plane; a mesh or a height field is
/// the ground that bodies fall on. It is not in the list of scenes: a recording of it can be played only together with
/// the asset.
Result<std::unique_ptr<Game>> make_asset_scene(std::shared_ptr<const AssetLibrary> assets, AssetId shown,
                                               const SceneOptions& options = {});

/// The input of a scripted `player` at `tick`: a pure function of the arguments.
/// `input` has game.input_size() bytes; all zero for games that are not scenes.
void scripted_input(const Game& game, std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                    std::span<std::byte> input);

// ---- the input of every scene with players --------------------------------------------------------------------

/// One player's input; `encode_input` makes the bytes.
struct ArenaInput {
    std::int8_t move_x = 0, move_z = 0; ///< -127..127 of full force along x and z
    std::uint8_t buttons = 0;           ///< ArenaButton bits
};
enum ArenaButton : std::uint8_t { arena_jump = 1, arena_push = 2 };
template <class Visit> constexpr void describe(ArenaInput& i, Visit&& visit) {
    visit("move_x", i.move_x), visit("move_z", i.move_z), visit("buttons", i.buttons);
}

/// The effect of the stick and the buttons in a word or a few: "roll", "jump", "push".
struct Controls {
    std::string_view stick, jump, push;
};
/// The controls of one player of a scene; empty if the player controls nothing.
Controls controls_of(const Game& game, std::uint32_t player);

// ---- roles of bodies, for viewers -----------------------------------------------------------------------------

enum class Role : std::uint32_t { terrain, wall, prop, player, machine, human };
/// For a part of a human, the number is this times the human's index, plus RagdollPart.
inline constexpr std::uint32_t human_stride = 16;

/// A body's user_key in every scene: its role and its number among bodies of that role.
constexpr std::uint64_t user_key_of(Role role, std::uint32_t number) {
    return std::uint64_t{static_cast<std::uint32_t>(role)} << 32 | number;
}
struct Look {
    Role role;
    std::uint32_t number; ///< player 0.., prop 0..; see human_stride
    std::uint32_t colour; ///< 0xRRGGBB
};
Look look_of(std::uint64_t user_key);

} // namespace lockstone
