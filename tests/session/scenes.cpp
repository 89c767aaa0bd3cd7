// The scenes with vehicles, characters and joints under rollback: every tick run again from a saved state.
#include "support/effort.h"

#include "lockstone/session.h"
#include "lockstone/session/forgetful.h"
#include "scenes/scenes.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace lockstone;

namespace {

/// Empty when two scripted players of the scene roll back `depth` ticks at every tick without a trace.
std::string rollback_fault(const char* scene, std::uint32_t size, std::uint32_t depth, std::uint64_t ticks,
                           std::string column_left_out = "") {
    const auto game = make_scene(scene, {.size = size, .seed = 1, .players = 2}).value();
    World world = game->start().value();
    WorldSimulation whole(world, *game);
    testing::ForgetfulSimulation simulation(whole, std::move(column_left_out));
    SessionDef def;
    def.input_size = game->input_size();
    def.players = {0, 0};
    const auto session = make_sync_test_session(def, depth).value();
    SessionRunner runner(*session, simulation);
    std::vector<std::byte> input(game->input_size());
    for (std::uint64_t i = 0; i < ticks; ++i) {
        for (std::uint32_t p = 0; p < 2; ++p) {
            scripted_input(*game, 1, session->current_tick(), p, input);
            session->add_local_input(p, input);
        }
        runner.frame(i);
        if (const SyncTestFailure* failure = runner.sync_failure()) return to_string(*failure);
    }
    return session->stats().hashes_compared < ticks ? "too little was compared" : "";
}

} // namespace

TEST_CASE("players who drive, walk, roll, jump and push among joints survive rollback at every tick") {
    const auto ticks = [](int whole) { return static_cast<std::uint64_t>(test::tries(whole)); };
    CHECK(rollback_fault("ragdolls", 4, 4, ticks(120)) == "");
    CHECK(rollback_fault("joint-grid", 0, 4, ticks(160)) == "");
    CHECK(rollback_fault("bridge", 24, 4, ticks(160)) == "");
    CHECK(rollback_fault("wrecking-ball", 12, 4, ticks(160)) == "");
    CHECK(rollback_fault("cars", 0, 4, ticks(120)) == "");
    CHECK(rollback_fault("character", 0, 4, ticks(120)) == "");
}

TEST_CASE("planted: a rollback that forgets what the rules remember of players is found in every scene") {
    CHECK(rollback_fault("ragdolls", 4, 4, 160, "game.players") != "");
    CHECK(rollback_fault("joint-grid", 0, 4, 160, "game.players") != "");
    CHECK(rollback_fault("bridge", 24, 4, 160, "game.players") != "");
    CHECK(rollback_fault("wrecking-ball", 12, 4, 160, "game.players") != "");
}
