// Joins again and late: a machine without a state takes its seat at a tick that all agree on, and all machines hold one
// match.
#include "session/match.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

MatchDef of_machines(std::uint32_t count, bool lockstep, std::uint64_t seed) {
    MatchDef def{.machines = count,
                 .lockstep = lockstep,
                 .input_delay = lockstep ? 8u : 2u,
                 .disconnect_ms = 1000,
                 .link = lossy,
                 .seed = seed};
    return def;
}

/// Checks that all machines hold one match, in which the inputs of player `who` count again from one tick on.
void check_joined(Match& match, PeerId who, std::size_t times = 1) {
    std::vector<std::uint64_t> ticks;
    const PeerId witness = who == 0 ? 1 : 0;
    for (PeerId i = 1; i <= match.def.machines; ++i) { // the machine that joined comes last
        const PeerId id = (who + i) % match.def.machines;
        CAPTURE(id);
        Match::Machine& m = match.machine(id);
        for (PeerId other = 0; other < match.def.machines; ++other) CHECK(match.agree(id, other));
        CHECK(match.notices<Desync>(id).empty());
        for (const StateRefused& refused : match.notices<StateRefused>(id)) FAIL_CHECK(refused.reason);
        for (const MatchStopped& stop : match.notices<MatchStopped>(id)) FAIL_CHECK(stop.reason);
        CHECK(m.events.holds(m.timeline.end()));
        std::vector<std::uint64_t> mine;
        for (const PlayerJoined& joined : match.notices<PlayerJoined>(id))
            if (joined.peer == who) mine.push_back(joined.tick);
        if (id == who) {
            REQUIRE(mine.size() == 1);
            CHECK(mine.back() == ticks.back());
        } else {
            REQUIRE(mine.size() == times);
            ticks = mine;
        }
    }
    const std::uint64_t tick = ticks.back();
    const Timeline& played = match.machine(witness).timeline;
    REQUIRE(played.end() > tick + 60);
    CHECK(played.ticks[tick - 1].statuses[who] == InputStatus::disconnected);
    for (std::uint64_t t = tick; t < played.end(); ++t)
        REQUIRE(played.ticks[t].statuses[who] == InputStatus::confirmed);
    bool has_pressed = false;
    for (std::uint64_t t = tick + 60; t < played.end(); ++t) {
        const auto pressed = encode_input(scripted_pad(who, t - match.def.input_delay));
        has_pressed = has_pressed ||
                      std::equal(pressed.begin(), pressed.end(), played.ticks[t].inputs.begin() + who * 4);
    }
    CHECK(has_pressed);
    Arena straight(static_cast<std::uint32_t>(match.def.players.size()));
    CHECK(run_straight(played, static_cast<std::uint32_t>(match.def.players.size()), straight) ==
          played.ticks.back().hash);
}

} // namespace

TEST_CASE("a machine that has lost all its state rejoins its seat") {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const bool lockstep = seed % 3 == 0;
        Match match(of_machines(2 + seed % 2, lockstep, seed));
        CAPTURE(seed);
        match.run(300);
        const PeerId who = static_cast<PeerId>(seed % match.def.machines);
        match.crash(who);
        // while the others still wait for it, or after they have continued
        match.run(seed % 2 == 0 ? 30 : 300);
        match.join(who);
        match.run(1200);
        check_joined(match, who);
        MESSAGE("seed ", seed, ": joined at ", match.notices<PlayerJoined>(who)[0].tick, ", confirmed ",
                match.machine(who).timeline.end(), " of ", match.machine(who == 0 ? 1 : 0).timeline.end(),
                " in ", match.frames);
        CHECK(match.machine(who).timeline.end() + 40 > match.machine(who == 0 ? 1 : 0).timeline.end());
    }
}

TEST_CASE("a machine joins late at a seat that was empty from the start") {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        CAPTURE(seed);
        const std::uint32_t machines = 2 + seed % 2;
        MatchDef def = of_machines(machines, seed % 4 == 0, seed);
        def.absent = 1u << (machines - 1);
        Match match(def);
        match.run(200 + seed * 50);
        CHECK(match.machine(0).timeline.end() > 150);
        match.join(machines - 1);
        match.run(900);
        check_joined(match, machines - 1);
    }
}

TEST_CASE("a machine fails and rejoins three times and the machines agree on each tick") {
    Match match(of_machines(3, false, 9));
    match.run(200);
    for (std::uint32_t life = 1; life <= 3; ++life) {
        match.crash(1);
        match.run(100);
        match.join(1, life);
        match.run(1500); // longer than the time in which it would be admitted at once
    }
    check_joined(match, 1, 3);
}

TEST_CASE("a machine that pauses and returns before it is dropped continues with its own state") {
    Match match(of_machines(2, false, 5));
    match.run(200);
    for (int i = 0; i < 50; ++i) match.frame(/*asleep: machine 1*/ 2); // 0.8 s of 1 s, six prediction windows
    match.run(300);
    CHECK(match.agree(0, 1));
    CHECK(match.notices<PlayerDisconnected>(0).empty());
    CHECK(match.machine(1).timeline.end() > 350);
}

TEST_CASE("two machines that request to join at the same time join at different ticks") {
    MatchDef def = of_machines(4, false, 11);
    def.absent = 8;
    Match match(def);
    match.run(200);
    match.crash(1);
    match.run(150);
    match.join(3), match.join(1);
    match.run(1500);
    for (PeerId id = 0; id < 4; ++id) {
        CAPTURE(id);
        for (PeerId other = 0; other < 4; ++other) CHECK(match.agree(id, other));
        CHECK(match.notices<Desync>(id).empty());
        CHECK(match.notices<MatchStopped>(id).empty());
        for (const InputStatus status : match.machine(id).timeline.ticks.back().statuses)
            CHECK(status == InputStatus::confirmed);
    }
    CHECK(match.notices<PlayerJoined>(0)[0].tick != match.notices<PlayerJoined>(0)[1].tick);
}
