// Properties of every built-in scene.
#include "support/scripted_inputs.h"

#include <doctest/doctest.h>

#include <set>

namespace lockstone::test {
namespace {

World started(const Game& game) { return game.start().value(); }

std::uint64_t hash_after(const Game& game, std::uint64_t ticks, std::uint64_t seed) {
    World world = started(game);
    ScriptedInputs inputs(game, seed);
    while (world.tick_count() < ticks) { REQUIRE(game.advance(world, inputs.at(world.tick_count())).ok()); }
    return world.hash();
}

} // namespace

TEST_CASE("every scene starts with the same state each time") {
    for (const SceneInfo& info : scenes()) {
        CAPTURE(info.name);
        const auto game = make_scene(info.name);
        REQUIRE(game.ok());
        CHECK(started(**game).hash() == started(**game).hash());
        CHECK(started(**game).tick_count() == 0);
    }
}

TEST_CASE("every body of every scene has a unique key") {
    for (const SceneInfo& info : scenes()) {
        CAPTURE(info.name);
        for (const std::uint32_t players : {0u, info.players_max}) {
            const World world = started(*make_scene(info.name, {.players = players}).value());
            std::set<std::uint64_t> keys;
            for (const BodyId body : world.bodies()) keys.insert(world.user_key(body));
            CHECK(keys.size() == world.body_count());
        }
    }
}

TEST_CASE("make_scene_named() with a game's name makes an equal game") {
    const auto game = make_scene("rollback-arena", {.size = 0, .seed = 77, .players = 3}).value();
    const auto again = make_scene_named(game->name());
    REQUIRE(again.ok());
    CHECK((*again)->content_id() == game->content_id());
    CHECK(started(**again).hash() == started(*game).hash());
}

TEST_CASE("options change the content id") {
    const auto id = [](SceneOptions o) { return make_scene("pile", o).value()->content_id(); };
    CHECK(id({.size = 10}) != id({.size = 11}));
    CHECK(id({.size = 10, .seed = 1}) != id({.size = 10, .seed = 2}));
    CHECK(id({}) == id({.size = 1000}));
}

TEST_CASE("scripted inputs depend only on seed and tick and player and change the outcome") {
    const auto game = make_scene("rollback-arena").value();
    std::array<std::byte, 3> a{}, b{}, other_seed{}, other_player{};
    scripted_input(*game, 5, 123, 1, a);
    scripted_input(*game, 5, 123, 1, b);
    scripted_input(*game, 6, 123, 1, other_seed);
    scripted_input(*game, 5, 123, 0, other_player);
    CHECK(a == b);
    CHECK(a != other_seed);
    CHECK(a != other_player);
    CHECK(hash_after(*game, 30, 5) == hash_after(*game, 30, 5));
    CHECK(hash_after(*game, 30, 5) != hash_after(*game, 30, 6));
}

TEST_CASE("the arena has 72 bodies for any number of players") {
    for (const std::uint32_t players : {2u, 3u, 4u})
        CHECK(started(*make_scene("rollback-arena", {.size = 0, .seed = 1, .players = players}).value())
                  .body_count() == 72);
}

TEST_CASE("the error for an unknown scene lists the scenes and suggests a similar name") {
    const auto near = make_scene("pyramyd");
    REQUIRE_FALSE(near.ok());
    CHECK(near.error().message.find("did you mean 'pyramid'?") != std::string::npos);
    CHECK(near.error().message.find("rollback-arena") != std::string::npos);
    const auto far = make_scene("xylophone");
    REQUIRE_FALSE(far.ok());
    CHECK(far.error().message.find("did you mean") == std::string::npos);
}

TEST_CASE("the error for an option out of range names the option and its range") {
    CHECK(make_scene("pyramid", {.size = 1000}).error().message ==
          "pyramid: size is 1000, it must be 1 to 100");
    CHECK(make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 9}).error().message ==
          "rollback-arena: players is 9, it must be 2 to 4");
    CHECK(make_scene("stack", {.size = 0, .seed = 1, .players = 2}).error().message ==
          "stack: players is not an option of this scene, but 2 was given");
    CHECK_FALSE(make_scene_named("pile size=10 seed=x players=0").ok());
    CHECK_FALSE(make_scene_named("pile size=10 seed=1 players=0 more=1").ok());
    CHECK_FALSE(make_scene_named("").ok());
}

} // namespace lockstone::test
