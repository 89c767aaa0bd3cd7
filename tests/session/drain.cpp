// The end of a match: every machine confirms and records all ticks that ran, to the last one.
#include "session/match.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

constexpr std::uint64_t match_ticks = 400;

/// Advances every machine to the last tick of the match. Then each drains or stops. Returns the number of confirmed
/// ticks by machine.
std::vector<std::size_t> confirmed_at_the_end(Match& match, bool drains) {
    std::vector<bool> done(match.def.machines, false);
    for (int frame = 0; frame < 4000; ++frame) {
        ++match.frames;
        match.now_ms = match.frames * 1000 / 60;
        match.network.advance_to(match.now_ms);
        for (PeerId id = 0; id < match.def.machines; ++id) {
            Match::Machine& m = match.machine(id);
            if (m.session->current_tick() < match_ticks)
                match.frame_of(id);
            else if (drains)
                done[id] = m.runner->drain(match.now_ms);
        }
        if (std::ranges::find(done, false) == done.end()) break;
    }
    std::vector<std::size_t> ticks;
    for (PeerId id = 0; id < match.def.machines; ++id)
        ticks.push_back(match.machine(id).timeline.ticks.size());
    return ticks;
}

} // namespace

TEST_CASE("every machine records a drained match to its last tick") {
    for (const bool lockstep : {false, true})
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            CAPTURE(lockstep);
            CAPTURE(seed);
            MatchDef def{.machines = 3, .lockstep = lockstep, .seed = seed};
            def.input_delay = lockstep ? 8 : 2;
            def.link = {.latency_ms = 60, .jitter_ms = 30, .loss_permille = 100};
            Match match(def);
            CHECK(confirmed_at_the_end(match, true) == std::vector<std::size_t>(3, match_ticks));
            CHECK(match.agree(0, 1));
            CHECK(match.agree(0, 2));
            Arena straight(3);
            CHECK(run_straight(match.machine(0).timeline, 3, straight) ==
                  match.machine(0).timeline.ticks.back().hash);
        }
}

TEST_CASE("without draining, the record of a match ends before its last tick") {
    Match match({.link = {.latency_ms = 60}});
    for (const std::size_t ticks : confirmed_at_the_end(match, false)) CHECK(ticks < match_ticks);
}

TEST_CASE("a drained sync test confirms every tick") {
    SessionDef def;
    def.input_size = input_size_of<Pad>;
    def.players = {0};
    const std::unique_ptr<Session> session = make_sync_test_session(def, 5).value();
    Arena arena(1);
    Timeline timeline;
    SessionRunner runner(*session, arena, {&timeline});
    for (std::uint64_t tick = 0; tick < 30; ++tick) {
        session->add_local_input(0, encode_input(scripted_pad(0, tick)));
        runner.frame(tick);
    }
    CHECK(timeline.ticks.size() == 25);
    CHECK(runner.drain(30));
    CHECK(timeline.ticks.size() == 30);
    CHECK(timeline.in_order);
}
