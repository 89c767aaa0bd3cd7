// Runs lockstone::prove on every scene: the properties of the contract, at every tick.
#include "lockstone/prove.h"
#include "support/small_game.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>

using namespace lockstone;

namespace {

const bool is_long = std::getenv("LOCKSTONE_LONG") != nullptr;

/// A small scene, whose state has few bits.
std::unique_ptr<Game> smaller_scene(const SceneInfo& info, std::uint32_t players = 0) {
    if (is_long && players == 0) return test::small_scene(info);
    return make_scene(info.name,
                      {.size = std::min(info.size_default, std::max(info.size_min, 20u)), .players = players})
        .value();
}

void check_proof(const Game& game, const ProofOptions& options) {
    const ProofInput scripted = [&](std::uint64_t tick, std::uint32_t player, std::span<std::byte> input) {
        scripted_input(game, 1, tick, player, input);
    };
    const Proof proof = prove(game, options, scripted).value();
    INFO(game.name(), "\n", to_string(proof));
    CHECK(proof.holds());
    REQUIRE(proof.checks.size() == 10);
    for (const ProofCheck& check : proof.checks) CHECK(check.compared > 0);
    const auto sets =
        std::ranges::count_if(every_simd, has_simd); // each with four pools and with tasks in random order
    CHECK(proof.checks[8].sentence == std::to_string(5 * sets) + " modes");
}

} // namespace

TEST_CASE("every scene passes all ten checks of a proof in every mode") {
    ProofOptions options;
    options.ticks = is_long ? 200 : 8;
    options.depth = is_long ? 8 : 3;
    options.bits_max = is_long ? 1000000 : 1500;
    for (const SceneInfo& info : scenes()) {
        check_proof(*smaller_scene(info), options);
        // A scene with optional players is a different game with them.
        if (info.players_max != 0 && info.players_default == 0) check_proof(*smaller_scene(info, 2), options);
    }
}

TEST_CASE("a proof uses random bytes from its seed as inputs if the game gives none") {
    const std::unique_ptr<Game> game = make_scene("rollback-arena").value();
    ProofOptions options;
    options.ticks = 10, options.bits_max = 100;
    CHECK(prove(*game, options).value().holds());
}

/// A game that starts a different world each time.
struct Restless : test::SmallGame {
    mutable int starts = 0;
    Result<World> start() const override {
        Result<World> world = SmallGame::start();
        world->set_gravity({Real(starts++), Real{}, Real{}}).value();
        return world;
    }
};

TEST_CASE("a proof reports that a game that starts another world each time does not repeat") {
    const Proof proof = prove(Restless(), {.ticks = 4, .bits_max = 10}).value();
    CHECK_FALSE(proof.holds());
    CHECK_FALSE(proof.checks[0].passed);
    CHECK(proof.checks[0].sentence.starts_with("the game starts different worlds: "));
    CHECK(proof.checks[0].sentence.find("gravity.x") != std::string::npos);
    CHECK(prove(test::SmallGame(), {.ticks = 4, .bits_max = 10}).value().holds()); // the negative control
}
