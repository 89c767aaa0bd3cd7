// Players of the scenes with vehicles, characters and joints: a stick moves its player, and an idle player changes
// nothing except its presence.
#include "support/effort.h"

#include "lockstone/math/math.h"
#include "scenes/scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace lockstone::test {
namespace {

struct Played {
    const char* scene;
    std::uint32_t size;
};
constexpr std::array<Played, 6> played{{{"ragdolls", 4},
                                        {"joint-grid", 0},
                                        {"cars", 0},
                                        {"bridge", 24},
                                        {"wrecking-ball", 12},
                                        {"character", 0}}};
constexpr ArenaInput away{.move_x = 0, .move_z = -127, .buttons = 0};

std::unique_ptr<Game> game_of(const Played& p, std::uint32_t players) {
    return make_scene(p.scene, {.size = p.size, .seed = 1, .players = players}).value();
}

/// One tick in which all players have the same input.
void step(const Game& game, World& world, ArenaInput input) {
    const auto bytes = encode_input(input);
    const std::vector<PlayerInput> inputs(game.player_count(), PlayerInput{bytes});
    REQUIRE(game.advance(world, inputs).ok());
}

World run(const Game& game, ArenaInput input, std::uint64_t ticks) {
    World world = game.start().value();
    while (world.tick_count() < ticks) step(game, world, input);
    return world;
}

BodyId body_of(const World& world, std::uint64_t user_key) {
    for (const BodyId body : world.bodies())
        if (world.user_key(body) == user_key) return body;
    return {};
}

Vec3 place_of_player(const World& world, std::uint32_t player) {
    return world.pose(body_of(world, user_key_of(Role::player, player))).position;
}

/// A game that drops all inputs.
class Deaf final : public Game {
  public:
    explicit Deaf(const Game& rules) : game(rules) {}
    std::string name() const override { return game.name(); }
    std::uint64_t content_id() const override { return game.content_id(); }
    std::uint32_t player_count() const override { return game.player_count(); }
    std::uint32_t input_size() const override { return game.input_size(); }
    Result<World> start() const override { return game.start(); }
    Status advance(World& world, std::span<const PlayerInput>) const override {
        step(game, world, {});
        return {};
    }

  private:
    const Game& game;
};

/// Returns an error sentence unless the stick moves every player its way within two thirds of a second.
std::string drive_fault(const Game& game) {
    const World idle = run(game, {}, 40), driven = run(game, away, 40);
    if (idle.hash() == driven.hash()) return game.name() + ": the stick changes nothing";
    for (std::uint32_t p = 0; p < game.player_count(); ++p)
        if (place_of_player(idle, p).z - place_of_player(driven, p).z < 0.3_r)
            return game.name() + ": player " + std::to_string(p) + " does not go where the stick points";
    return {};
}

/// Returns an error sentence unless every body of a scene without players moves as it does with one player and this
/// input.
/// `input`.
std::string presence_fault(const Played& p, ArenaInput input, std::uint64_t ticks) {
    const auto alone = game_of(p, 0), watched = game_of(p, 1);
    World a = alone->start().value(), b = watched->start().value();
    while (a.tick_count() < ticks) {
        REQUIRE(alone->advance(a, {}).ok());
        step(*watched, b, input);
        for (const BodyId body : a.bodies()) {
            const BodyId other = body_of(b, a.user_key(body));
            if (a.pose(body) != b.pose(other) || a.linear_velocity(body) != b.linear_velocity(other))
                return std::string(p.scene) + ": a body moves otherwise at tick " +
                       std::to_string(a.tick_count());
        }
    }
    return {};
}

} // namespace

TEST_CASE("every player of every scene moves in the direction of its stick" *
          doctest::skip(lockstone::test::is_small_sample())) {
    for (const Played& p : played)
        for (const std::uint32_t players : {1u, 2u, 4u}) CHECK(drive_fault(*game_of(p, players)) == "");
}

TEST_CASE("planted fault: the check reports inputs that do not arrive in every scene" *
          doctest::skip(lockstone::test::is_small_sample())) {
    for (const Played& p : played) {
        const auto game = game_of(p, 1);
        CHECK(drive_fault(Deaf(*game)).find("the stick changes nothing") != std::string::npos);
    }
}

TEST_CASE("an idle player changes no other body of its scene" * doctest::skip(test::is_too_long_here())) {
    CHECK(presence_fault({"ragdolls", 4}, {}, 60) == ""); // later the ragdolls touch the player
    CHECK(presence_fault({"joint-grid", 0}, {}, 200) == "");
    CHECK(presence_fault({"bridge", 24}, {}, 200) == "");
    CHECK(presence_fault({"wrecking-ball", 12}, {}, 200) == "");
}

TEST_CASE("planted fault: the check reports the changes that an active player makes to other bodies" *
          doctest::skip(lockstone::test::is_small_sample())) {
    const ArenaInput push{.move_x = 0, .move_z = -127, .buttons = arena_push};
    CHECK(presence_fault({"ragdolls", 4}, push, 120) != "");
    CHECK(presence_fault({"joint-grid", 0}, push, 120) != "");
    CHECK(presence_fault({"bridge", 24}, {.move_x = 127, .move_z = 0, .buttons = 0}, 60) != "");
    CHECK(presence_fault({"wrecking-ball", 12}, away, 10) != "");
}

TEST_CASE("scenes without players have no inputs and no column for players") {
    for (const char* scene : {"ragdolls", "joint-grid", "bridge", "wrecking-ball"}) {
        CAPTURE(scene);
        const auto game = make_scene(scene).value();
        CHECK(game->player_count() == 0);
        CHECK(game->input_size() == 0);
        CHECK(game->start()->state().layout().find_column("game.players") == nullptr);
        CHECK(make_scene(scene, {.players = 2}).value()->input_size() == input_size_of<ArenaInput>);
    }
}

TEST_CASE("controls_of() describes the controls of every player of a scene and of no other number") {
    for (const SceneInfo& info : scenes()) {
        CAPTURE(info.name);
        const auto game = make_scene(info.name, {.players = info.players_max}).value();
        for (std::uint32_t p = 0; p < 6; ++p) {
            const Controls controls = controls_of(*game, p);
            for (const std::string_view word : {controls.stick, controls.jump, controls.push})
                CHECK(word.empty() == (p >= info.players_max));
        }
    }
}

TEST_CASE("a player that falls off the bridge or over the stairs restarts once at its start" *
          doctest::skip(lockstone::test::is_small_sample())) {
    for (const Played& p : {Played{"bridge", 24}, Played{"ragdolls", 1}}) {
        CAPTURE(p.scene);
        const auto game = game_of(p, 1);
        World world = game->start().value();
        const Vec3 start = place_of_player(world, 0);
        int restarts = 0;
        for (int t = 0; t < 600; ++t) {
            const Vec3 before = place_of_player(world, 0);
            step(*game, world, restarts == 0 ? away : ArenaInput{});
            const Vec3 now = place_of_player(world, 0);
            if (length(now - before) < 1_r) continue;
            ++restarts;
            CHECK(length(now - start) < 0.5_r);
        }
        CHECK(restarts == 1);
    }
}

TEST_CASE("a ball jumps off the body that it lies on and does not jump in the air") {
    const auto game = game_of({"bridge", 24}, 1);
    World world = game->start().value();
    const Real start = place_of_player(world, 0).y;
    Real highest = start;
    for (int t = 0; t < 160; ++t) {
        step(*game, world, {.move_x = 0, .move_z = 0, .buttons = arena_jump});
        highest = max(highest, place_of_player(world, 0).y);
    }
    CHECK(highest - start > 1.5_r); // 6 m/s: 1.8 m
    CHECK(highest - start < 2_r);
}

TEST_CASE("the wrecking ball hits its wall and the player's push button rebuilds the wall" *
          doctest::skip(lockstone::test::is_small_sample())) {
    const auto game = game_of({"wrecking-ball", 20}, 1);
    World world = game->start().value();
    const auto top = [&] { return world.pose(body_of(world, user_key_of(Role::prop, 71))).position; };
    const Vec3 built = top();
    while (world.tick_count() < 240) step(*game, world, {});
    CHECK(length(top() - built) > 1_r);
    step(*game, world, {.move_x = 0, .move_z = 0, .buttons = arena_push});
    CHECK(length(top() - built) < 0.1_r);
}

TEST_CASE("the wrecking ball comes to rest when it is slowed and swings sideways up to its limit" *
          doctest::skip(test::is_too_long_here())) {
    const auto game = game_of({"wrecking-ball", 20}, 1);
    World world = game->start().value();
    const auto velocity = [&] { return world.linear_velocity(body_of(world, user_key_of(Role::player, 0))); };
    const ArenaInput slow{.move_x = 0, .move_z = 0, .buttons = arena_jump};
    while (world.tick_count() < 500) step(*game, world, slow);
    CHECK(length(velocity()) < 0.2_r);
    CHECK(abs(place_of_player(world, 0).z) < 0.2_r);
    Real farthest{};
    while (world.tick_count() < 1100) {
        const std::int8_t along = velocity().z > 0_r ? 127 : -127;
        step(*game, world, {.move_x = 0, .move_z = along, .buttons = 0});
        farthest = max(farthest, abs(place_of_player(world, 0).z));
    }
    CHECK(farthest > 2_r);
    CHECK(farthest < 3.2_r); // the mast is 5 m away
}

} // namespace lockstone::test
