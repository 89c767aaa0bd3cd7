// Desyncs: a session reports the first tick that differs, once, and reports none in a match without a fault.
#include "session/match.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// A faulty machine: after each run of tick `bad_tick` one bit of one row is wrong.
class WrongArena final : public Arena {
  public:
    WrongArena(std::uint32_t players, std::uint64_t tick) : Arena(players), bad_tick(tick) {}
    void advance(std::span<const PlayerInput> inputs) override {
        const std::uint64_t tick = state().rows(arena_columns().clock)[0].tick;
        Arena::advance(inputs);
        if (tick == bad_tick) agents()[3].speed ^= 1;
    }

  private:
    std::uint64_t bad_tick;
};

Match match_with_fault(std::uint64_t bad_tick, std::uint64_t seed, bool lockstep) {
    const LinkDef link{.latency_ms = 60, .jitter_ms = 30, .loss_permille = 100};
    return Match({.lockstep = lockstep, .input_delay = 4, .prediction_max = 8, .link = link, .seed = seed},
                 [&](PeerId id) -> std::unique_ptr<Simulation> {
                     if (id == 1) return std::make_unique<WrongArena>(2, bad_tick);
                     return std::make_unique<Arena>(2);
                 });
}

} // namespace

TEST_CASE("both machines report a desync once and at the tick where one machine goes wrong") {
    for (const std::uint64_t bad_tick : {0u, 1u, 77u, 300u}) {
        for (const bool lockstep : {false, true}) {
            CAPTURE(bad_tick);
            CAPTURE(lockstep);
            Match match = match_with_fault(bad_tick, bad_tick + 5, lockstep);
            match.run(700);
            const auto told_0 = match.notices<Desync>(0);
            const auto told_1 = match.notices<Desync>(1);
            REQUIRE(told_0.size() == 1);
            REQUIRE(told_1.size() == 1);
            CHECK(told_0[0].tick == bad_tick);
            CHECK(told_1[0].tick == bad_tick);
            CHECK(told_0[0].peer == 1);
            CHECK(told_0[0].local == told_1[0].remote);
            CHECK(told_0[0].remote == told_1[0].local);
            CHECK(told_0[0].local ==
                  static_cast<std::uint32_t>(match.machine(0).timeline.ticks[bad_tick].hash));
            CHECK(match.machine(0).session->quality(1).hashes_agreed == bad_tick);
            CHECK_FALSE(match.agree(0, 1));
        }
    }
}

TEST_CASE("a match without the fault reports no desync") {
    for (const bool lockstep : {false, true}) {
        Match match = match_with_fault(~std::uint64_t{0}, 5, lockstep);
        match.run(700);
        CHECK(match.notices<Desync>(0).empty());
        CHECK(match.notices<Desync>(1).empty());
        CHECK(match.machine(0).session->quality(1).hashes_agreed > 400);
        CHECK(match.agree(0, 1));
    }
}
