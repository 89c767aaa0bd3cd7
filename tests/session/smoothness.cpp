// The motion of a match over a bad network is smooth, and over a hopeless network the match stays correct.
//
// Bounds, from the delays that players tolerate: at 5 % loss and a round trip of 100 +- 20 ms no machine stops for more
// than 100 ms, and of 100 frames that roll back 99 roll back at most 8 ticks. fortress-rollback reports 15 stalls a
// minute there.
#include "session/match.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

struct Feel {
    std::vector<std::uint64_t> depths; ///< by rollback [ticks]
    std::uint64_t stalls = 0, longest_ms = 0, frames = 0;

    std::uint64_t depth_of(std::uint64_t permille) {
        std::ranges::sort(depths);
        return depths.empty() ? 0 : depths[(depths.size() - 1) * permille / 1000];
    }
};

/// Plays a minute after the machines have connected.
Feel play(const LinkDef& link, std::uint64_t seed) {
    Match match({.link = link, .seed = seed});
    match.run(120);
    Feel feel;
    std::array<std::uint64_t, 2> standing{};
    for (feel.frames = 0; feel.frames < 3600; ++feel.frames) {
        std::array<SessionStats, 2> before;
        for (PeerId id = 0; id < 2; ++id) before[id] = match.machine(id).session->stats();
        match.frame();
        for (PeerId id = 0; id < 2; ++id) {
            const SessionStats& now = match.machine(id).session->stats();
            const bool stalled = now.stalls != before[id].stalls;
            standing[id] = stalled ? standing[id] + 1 : 0;
            feel.longest_ms = std::max(feel.longest_ms, standing[id] * 1000 / 60);
            feel.stalls += standing[id] == 1 ? 1u : 0u;
            if (now.rollbacks != before[id].rollbacks)
                feel.depths.push_back(now.resimulated - before[id].resimulated);
        }
    }
    CHECK(match.agree(0, 1));
    CHECK(match.notices<Desync>(0).empty());
    return feel;
}

} // namespace

TEST_CASE("a match at 5 % loss and 100 +- 20 ms stalls for at most 100 ms and has short rollbacks") {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        CAPTURE(seed);
        Feel feel = play({.latency_ms = 40, .jitter_ms = 20, .loss_permille = 50}, seed);
        MESSAGE("seed ", seed, ": ", feel.stalls, " stalls in two machine-minutes, the longest ",
                feel.longest_ms, " ms; ", feel.depths.size(), " rollbacks, depth median ", feel.depth_of(500),
                ", p99 ", feel.depth_of(990));
        CHECK(feel.longest_ms <= 100);
        CHECK(feel.depth_of(990) <= 8);
        CHECK(feel.depths.size() > 100);
    }
}

TEST_CASE("planted: a match over a worse network stalls for more than 100 ms") {
    Feel feel = play({.latency_ms = 120, .jitter_ms = 20, .loss_permille = 600}, 1);
    CHECK(feel.longest_ms > 100);
}

TEST_CASE("a match with 90 % loss, two seconds of ping, duplicates and reordering is slow and correct") {
    for (const bool lockstep : {false, true}) {
        CAPTURE(lockstep);
        Match match({.lockstep = lockstep,
                     .input_delay = lockstep ? 16u : 2u,
                     .disconnect_ms = 60'000,
                     .link = {.latency_ms = 900,
                              .jitter_ms = 200,
                              .loss_permille = 900,
                              .duplicate_permille = 300,
                              .reorder_permille = 300,
                              .reorder_ms = 400},
                     .connect_ms = 60'000});
        match.run(20'000);
        MESSAGE((lockstep ? "lockstep: " : "rollback: "), match.machine(0).timeline.ticks.size(),
                " ticks in 20,000 frames, ", match.machine(0).session->stats().bytes_per_player_second(),
                " B/s");
        CHECK(match.machine(0).timeline.ticks.size() > 500);
        CHECK(match.agree(0, 1));
        CHECK(match.notices<Desync>(0).empty());
        CHECK(match.notices<PlayerDisconnected>(0).empty());
        CHECK(match.machine(0).session->stats().bytes_per_player_second() < 4200);
    }
}
