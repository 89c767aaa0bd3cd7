#include "scenes/scene.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <initializer_list>
#include <system_error>
#include <vector>

namespace lockstone {
namespace {

using namespace scenes_detail;

constexpr std::array<SceneInfo, 17> infos{{
    {"two-blocks",
     "two blocks in the air get a push and a twist, meet above the ground, bounce apart and settle", "", 0, 0,
     0, 0, 0, 0},
    {"stack", "a tower of boxes that must not move", "boxes", 10, 1, 200, 0, 0, 0},
    {"pyramid", "a wall of boxes, each row one shorter than the one below", "boxes in the lowest row", 40, 1,
     100, 0, 0, 0},
    {"pile", "spheres, boxes and capsules dropped into a walled pit of 10 x 10 m", "bodies", 1000, 3, 8000, 0,
     0, 0},
    {"convex-pile",
     "hulls, cylinders, cones, rounded boxes and capsules dropped into a walled pit of 8 x 8 m", "bodies",
     400, 1, 4000, 0, 0, 0},
    {"terrain", "bodies of every kind roll down hills of 204,800 triangles, with an arch that is a mesh",
     "bodies", 240, 1, 4000, 0, 0, 0},
    {"washer", "a turning drum with paddles, in which small bodies tumble", "bodies", 300, 1, 640, 0, 0, 0},
    {"domino", "a spiral of dominoes that a rolling ball topples", "dominoes", 150, 2, 2000, 0, 0, 0},
    {"character", "up to four characters on a round of stairs, crates, a tunnel, platforms and a seesaw", "",
     0, 0, 0, 1, 1, 4},
    {"cars", "cars of up to four drivers and a tank on hills, with ramps and crates", "", 0, 0, 0, 1, 1, 4},
    {"ragdolls", "humans fall down a flight of stairs, heap up below and come to rest", "ragdolls", 20, 1,
     200, 0, 0, 4},
    {"joint-grid",
     "a station for every kind of joint: motors, springs, limits, friction, and one that breaks", "", 0, 0, 0,
     0, 0, 4},
    {"bridge", "planks on hinges between two banks, loaded with boxes", "planks", 200, 4, 400, 0, 0, 4},
    {"wrecking-ball", "a ball as heavy as a thousand links swings on a chain into a wall", "links", 30, 4, 60,
     0, 0, 4},
    {"water", "boats, crates and a ball of each density in a basin with a current, under a wind", "crates",
     40, 1, 400, 0, 0, 0},
    {"blast", "houses of crates, and an explosion among them every three seconds", "houses", 12, 1, 60, 0, 0,
     0},
    {"rollback-arena", "72 bodies and up to four players who roll, jump, push, capture props and play tag",
     "", 0, 0, 0, 2, 2, 4},
}};
constexpr std::array<MakeScene, infos.size()> makers{
    make_two_blocks, make_stack,         make_pyramid,   make_pile,  make_convex_pile,   make_terrain,
    make_washer,     make_domino,        make_character, make_cars,  make_ragdolls,      make_joint_grid,
    make_bridge,     make_wrecking_ball, make_water,     make_blast, make_rollback_arena};

/// Levenshtein's distance: the smallest number of letters to insert, delete or replace.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0u : 1u);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row[b.size()];
}

/// Concatenates by appending, since `"text" + std::string` causes a false warning of g++ 12 (its bug 105329).
std::string join(std::initializer_list<std::string_view> pieces) {
    std::string out;
    for (const std::string_view piece : pieces) out += piece;
    return out;
}

Error unknown_scene(std::string_view name) {
    const auto nearest =
        std::min_element(infos.begin(), infos.end(), [&](const SceneInfo& a, const SceneInfo& b) {
            return edit_distance(name, a.name) < edit_distance(name, b.name);
        });
    std::string sentence = join({"no scene is called '", name, "'"});
    if (edit_distance(name, nearest->name) * 2 < nearest->name.size())
        sentence += join({"; did you mean '", nearest->name, "'?"});
    else
        sentence += ".";
    sentence += " The scenes are";
    for (const SceneInfo& info : infos) sentence += join({&info == &infos.front() ? " " : ", ", info.name});
    return {sentence};
}

Status check(std::string_view scene, std::string_view what, std::uint32_t value, std::uint32_t low,
             std::uint32_t high) {
    if (value >= low && value <= high) return {};
    const std::string given = std::to_string(value);
    if (high == 0)
        return Error{join({scene, ": ", what, " is not an option of this scene, but ", given, " was given"})};
    return Error{join({scene, ": ", what, " is ", given, ", it must be ", std::to_string(low), " to ",
                       std::to_string(high)})};
}

/// Reads " key=number" from the front of `text`.
bool take_option(std::string_view& text, std::string_view key, std::uint64_t& value) {
    if (!text.starts_with(' ')) return false;
    text.remove_prefix(1);
    if (!text.starts_with(key) || !text.substr(key.size()).starts_with('=')) return false;
    text.remove_prefix(key.size() + 1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{}) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return true;
}

} // namespace

std::span<const SceneInfo> scenes() { return infos; }

const SceneInfo* find_scene(std::string_view name) {
    const auto found =
        std::find_if(infos.begin(), infos.end(), [&](const SceneInfo& i) { return i.name == name; });
    return found == infos.end() ? nullptr : &*found;
}

Result<std::unique_ptr<Game>> make_scene(std::string_view name, const SceneOptions& options) {
    const SceneInfo* info = find_scene(name);
    if (info == nullptr) return unknown_scene(name);
    SceneOptions filled = options;
    if (filled.size == 0) filled.size = info->size_default;
    if (filled.players == 0) filled.players = info->players_default;
    if (Status s = check(name, "size", filled.size, info->size_min, info->size_max); !s) return s.error();
    if (Status s = check(name, "players", filled.players, info->players_min, info->players_max); !s)
        return s.error();
    return std::unique_ptr<Game>(makers[static_cast<std::size_t>(info - infos.data())](*info, filled));
}

Result<std::unique_ptr<Game>> make_scene_named(std::string_view game_name) {
    std::string_view rest = game_name;
    const std::string_view name = rest.substr(0, rest.find(' '));
    rest.remove_prefix(name.size());
    if (find_scene(name) == nullptr) return unknown_scene(name);
    std::uint64_t size = 0, seed = 0, players = 0;
    const bool read = take_option(rest, "size", size) && take_option(rest, "seed", seed) &&
                      take_option(rest, "players", players) && rest.empty();
    if (!read || size > UINT32_MAX || players > UINT32_MAX)
        return Error{join(
            {"'", game_name, "' is not a scene with its options, like 'pile size=1000 seed=1 players=0'"})};
    return make_scene(name, {.size = static_cast<std::uint32_t>(size),
                             .seed = seed,
                             .players = static_cast<std::uint32_t>(players)});
}

void scripted_input(const Game& game, std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                    std::span<std::byte> input) {
    std::fill(input.begin(), input.end(), std::byte{});
    if (const auto* scene = dynamic_cast<const Scene*>(&game)) scene->script(seed, tick, player, input);
}

Controls controls_of(const Game& game, std::uint32_t player) {
    const auto* scene = dynamic_cast<const Scene*>(&game);
    return scene != nullptr && player < game.player_count() ? scene->controls(player) : Controls{};
}

constexpr std::array<std::uint32_t, 6> prop_colours{0x4e79a7, 0xf28e2b, 0x59a14f,
                                                    0xedc948, 0xb07aa1, 0x76b7b2};

/// Each human has a shirt of its own colour; trousers, shoes and skin have equal colours for all.
static std::uint32_t human_colour(std::uint32_t number) {
    switch (static_cast<RagdollPart>(number % human_stride)) {
    case RagdollPart::abdomen:
    case RagdollPart::chest:
    case RagdollPart::upper_arm_left:
    case RagdollPart::upper_arm_right:
        return prop_colours[number / human_stride % prop_colours.size()];
    case RagdollPart::head:
    case RagdollPart::forearm_left:
    case RagdollPart::forearm_right:
        return 0xd9a066;
    case RagdollPart::foot_left:
    case RagdollPart::foot_right:
        return 0x2b2622;
    default:
        return 0x3d4a5c;
    }
}

Look look_of(std::uint64_t user_key) {
    constexpr std::array<std::uint32_t, 4> player_colours{0xe15759, 0x2f6fde, 0x2ca02c, 0xffbf00};
    const Role role = static_cast<Role>(user_key >> 32);
    const auto number = static_cast<std::uint32_t>(user_key);
    switch (role) {
    case Role::terrain:
        return {role, number, 0x8a8f98};
    case Role::wall:
        return {role, number, 0x5c6370};
    case Role::prop:
        return {role, number, prop_colours[number % prop_colours.size()]};
    case Role::player:
        return {role, number, player_colours[number % player_colours.size()]};
    case Role::machine:
        return {role, number, 0x3b3f46};
    case Role::human:
        return {role, number, human_colour(number)};
    }
    return {Role::prop, number, prop_colours[0]};
}

} // namespace lockstone
