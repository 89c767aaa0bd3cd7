// Outcomes that a viewer expects: towers stand, piles stay in their pit, dominoes fall, games are playable.
#include "support/scripted_inputs.h"

#include <doctest/doctest.h>

namespace lockstone::test {
namespace {

World run(const Game& game, std::uint64_t ticks) {
    World world = game.start().value();
    ScriptedInputs inputs(game);
    while (world.tick_count() < ticks) { REQUIRE(game.advance(world, inputs.at(world.tick_count())).ok()); }
    return world;
}

} // namespace

TEST_CASE("a pile stays in its pit and above its floor") {
    const World world = run(*make_scene("pile", {.size = 120}).value(), 300);
    int things = 0;
    for (const BodyId body : world.bodies()) {
        if (world.kind(body) != BodyKind::dynamic) continue;
        ++things;
        const Vec3 p = world.pose(body).position;
        CHECK(abs(p.x) < 5_r);
        CHECK(abs(p.z) < 5_r);
        CHECK(p.y > 0_r);
    }
    CHECK(things == 120);
    CHECK(world.faults() == Faults{});
}

TEST_CASE("all dominoes fall to the last one") {
    const World world = run(*make_scene("domino", {.size = 60}).value(), 900);
    int dominoes = 0;
    for (const BodyId body : world.bodies()) {
        const Look look = look_of(world.user_key(body));
        if (look.role != Role::prop) continue;
        ++dominoes;
        CAPTURE(look.number);
        CHECK(world.pose(body).position.y < 0.45_r); // 0.5 when upright
    }
    CHECK(dominoes == 60);
}

TEST_CASE("the arena's players change the owners of props and no body falls out of the arena") {
    const auto game = make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 4}).value();
    const World world = run(*game, 600);
    const std::string dump = world.state().dump();
    CHECK(dump.find("game.claim") != std::string::npos);
    bool owned = false;
    for (std::size_t at = dump.find("owner="); at != std::string::npos; at = dump.find("owner=", at + 1))
        owned = owned || dump.compare(at, 7, "owner=0") != 0;
    CHECK(owned);
    for (const BodyId body : world.bodies()) CHECK(world.pose(body).position.y > -1_r);
}

} // namespace lockstone::test
