// Whole matches: on every simulated network all machines confirm the same ticks with the same inputs and states.
#include "session/match.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

void check_agreement(Match& match, std::uint64_t ticks_least) {
    for (PeerId id = 0; id < match.def.machines; ++id) {
        CAPTURE(id);
        Match::Machine& m = match.machine(id);
        CHECK(m.timeline.ticks.size() >= ticks_least);
        CHECK(match.agree(0, id));
        CHECK(match.notices<Desync>(id).empty());
        CHECK(m.session->stats().hashes_compared > 0);
        CHECK(m.events.holds(m.timeline.ticks.size()));
        CHECK(m.session->stats().depth_max <= match.def.prediction_max);
        const std::uint32_t players = static_cast<std::uint32_t>(match.def.players.size());
        Arena straight(players);
        CHECK(run_straight(m.timeline, players, straight) == m.timeline.ticks.back().hash);
    }
}

} // namespace

TEST_CASE("two machines on a lossy network confirm the same inputs and hashes for thousands of ticks") {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        CAPTURE(seed);
        Match match({.link = lossy, .seed = seed});
        match.run(4000);
        check_agreement(match, 3000);
        const SessionStats& stats = match.machine(0).session->stats();
        CHECK(stats.rollbacks > 100);
        CHECK(stats.dropped[static_cast<std::size_t>(PacketFault::damaged)] > 0);
        MESSAGE("rollback, seed ", seed, ": ticks ", stats.ticks, ", rollbacks ", stats.rollbacks,
                ", resimulated ", stats.resimulated, ", depth ", stats.depth_max, ", stalls ", stats.stalls,
                ", bytes/player/s ", stats.bytes_per_player_second());
    }
}

TEST_CASE("lockstep on a lossy network confirms the same inputs and hashes, without a rollback") {
    Match match({.lockstep = true, .input_delay = 8, .prediction_max = 0, .link = lossy});
    match.run(4000);
    check_agreement(match, 2500);
    CHECK(match.machine(0).session->stats().rollbacks == 0);
    CHECK(match.machine(0).session->stats().resimulated == 0);
    CHECK(match.machine(0).events.count(EventStatus::predicted) == 0);
    CHECK(match.machine(0).events.count(EventStatus::confirmed) > 0);
}

TEST_CASE(
    "four players on three machines agree although the machines receive the inputs at different times") {
    Match match({.players = {0, 1, 1, 2}, .machines = 3, .link = lossy});
    match.run(3000);
    check_agreement(match, 2000);
}

TEST_CASE("a seed determines a match packet by packet") {
    const auto play = [](std::uint64_t seed) {
        Match match({.link = lossy, .seed = seed});
        match.run(1000);
        const SessionStats& s = match.machine(1).session->stats();
        return std::array{s.rollbacks,      s.resimulated, s.packets_received,
                          s.bytes_received, s.bytes_sent,  match.machine(1).timeline.ticks.back().hash};
    };
    CHECK(play(11) == play(11));
    CHECK(play(11) != play(12));
}

TEST_CASE("a machine that is ahead slows down until both machines are level") {
    Match match({.link = {.latency_ms = 50}});
    match.run(60);
    for (int i = 0; i < 6; ++i) match.frame(/*asleep: machine 1*/ 2);
    const std::uint64_t ahead =
        match.machine(0).session->current_tick() - match.machine(1).session->current_tick();
    CHECK(ahead >= 5);
    match.run(300);
    const std::int64_t left = static_cast<std::int64_t>(match.machine(0).session->current_tick()) -
                              static_cast<std::int64_t>(match.machine(1).session->current_tick());
    CHECK(left >= -2);
    CHECK(left <= 2);
    CHECK(match.machine(0).session->quality(1).ping_ms >= 100);
    CHECK(match.machine(0).session->quality(1).ping_ms <= 140);
}

TEST_CASE("machines agree while each of them changes its input delay differently") {
    Match match({.link = lossy});
    for (std::uint32_t i = 0; i < 40; ++i) {
        match.machine(i % 2).session->set_input_delay(i * 7 % 12);
        match.run(50);
    }
    check_agreement(match, 1000);
}

TEST_CASE("a session disconnects the players of a silent machine at the tick where their inputs end") {
    Match match({.disconnect_ms = 1000, .link = {.latency_ms = 60, .jitter_ms = 30, .loss_permille = 100}});
    match.run(300);
    match.network.unplug(1);
    match.run(400);
    const auto left = match.notices<PlayerDisconnected>(0);
    REQUIRE(left.size() == 1);
    CHECK(left[0].player == 1);
    CHECK(left[0].peer == 1);
    const auto& ticks = match.machine(0).timeline.ticks;
    REQUIRE(ticks.size() > left[0].tick + 100); // the match continues
    CHECK(ticks[left[0].tick - 1].statuses[1] == InputStatus::confirmed);
    for (std::uint64_t t = left[0].tick; t < ticks.size(); ++t) {
        REQUIRE(ticks[t].statuses[1] == InputStatus::disconnected);
        REQUIRE(std::ranges::all_of(std::span(ticks[t].inputs).subspan(4),
                                    [](std::byte b) { return b == std::byte{}; }));
    }
    Arena straight(2);
    CHECK(run_straight(match.machine(0).timeline, 2, straight) == ticks.back().hash);
}

TEST_CASE("machines that remain agree on the tick where a player left though they received different numbers "
          "of inputs") {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        CAPTURE(seed);
        Match match({.machines = 3,
                     .disconnect_ms = 1000,
                     .link = {.latency_ms = 60, .jitter_ms = 30, .loss_permille = 100},
                     .seed = seed});
        match.run(300);
        match.network.set_link(2, 0, {.loss_permille = 1000}); // machine 1 receives machine 2 a little longer
        match.run(6);
        match.network.unplug(2);
        match.run(400);
        CHECK(match.agree(0, 1));
        const auto told_0 = match.notices<PlayerDisconnected>(0);
        const auto told_1 = match.notices<PlayerDisconnected>(1);
        REQUIRE(told_0.size() == 1);
        REQUIRE(told_1.size() == 1);
        CHECK(told_0[0].player == 2);
        CHECK(told_0[0].tick == told_1[0].tick);
        CHECK(match.machine(0).timeline.ticks.size() > 500);
        CHECK(match.notices<Desync>(0).empty());
    }
}

TEST_CASE("a machine that learns of a departure waits for the inputs that it still lacks") {
    Match match({.machines = 3, .disconnect_ms = 1000, .link = {.latency_ms = 60}});
    match.run(300);
    // Machine 0 receives machine 2 a second late, and never its last packets. Machine 1 receives all and times out
    // first.
    match.network.set_link(2, 0, {.latency_ms = 900});
    match.run(20);
    match.network.set_link(2, 0, {.loss_permille = 1000});
    match.run(6);
    match.network.unplug(2);
    match.run(400);
    CHECK(match.agree(0, 1));
    REQUIRE(match.notices<PlayerDisconnected>(0).size() == 1);
    REQUIRE(match.notices<PlayerDisconnected>(1).size() == 1);
    CHECK(match.notices<PlayerDisconnected>(0)[0].tick == match.notices<PlayerDisconnected>(1)[0].tick);
    CHECK(match.machine(0).timeline.ticks.size() > 500);
    CHECK(match.machine(0).session->stats().dropped[static_cast<std::size_t>(PacketFault::implausible)] == 0);
}

TEST_CASE("a machine whose packets no longer arrive receives a notice of its disconnection") {
    Match match({.disconnect_ms = 1000, .link = {.latency_ms = 60}});
    match.run(300);
    match.network.set_link(1, 0, {.loss_permille = 1000});
    match.run(60 + 4 + 3); // 1 s of silence, then the latencies of the last packet and of the farewell
    CHECK(match.notices<PlayerDisconnected>(0).size() == 1);
    match.run(6);
    CHECK(match.notices<PlayerDisconnected>(1).size() == 1);
}

TEST_CASE("a machine that cannot receive another one stalls the match and the others drop it and continue") {
    Match match({.machines = 3, .disconnect_ms = 1000, .link = {.latency_ms = 60}});
    match.run(300);
    match.network.set_link(2, 0, {.loss_permille = 1000});
    match.run(600);
    CHECK(match.agree(1, 2));
    REQUIRE(match.notices<PlayerDisconnected>(1).size() == 1);
    REQUIRE(match.notices<PlayerDisconnected>(2).size() == 1);
    CHECK(match.notices<PlayerDisconnected>(1)[0].player == 0);
    CHECK(match.notices<PlayerDisconnected>(1)[0].tick == match.notices<PlayerDisconnected>(2)[0].tick);
    CHECK(match.notices<MatchStopped>(0).size() == 1);
    CHECK(match.machine(1).timeline.ticks.size() > 600);
}

TEST_CASE("sixteen players with the widest inputs and fifteen on one machine advance by packets that hold a "
          "few inputs") {
    SimulatedNetwork network(2, {.latency_ms = 20}, 1);
    SessionDef def;
    def.input_size = input_bytes_max;
    def.players.assign(16, 0);
    def.players[15] = 1;
    std::array<std::unique_ptr<Session>, 2> sessions;
    for (PeerId id = 0; id < 2; ++id) {
        def.self = id;
        sessions[id] = make_rollback_session(def, network.endpoint(id)).value();
    }
    std::array<std::uint64_t, 2> confirmed{};
    std::array<std::byte, input_bytes_max> input{};
    for (std::uint64_t frame = 0; frame < 600; ++frame) {
        network.advance_to(frame * 16);
        for (PeerId id = 0; id < 2; ++id) {
            input.fill(static_cast<std::byte>(sessions[id]->current_tick())); // changes every tick
            for (std::uint32_t p = 0; p < 16; ++p) {
                if (def.players[p] == id) sessions[id]->add_local_input(p, input);
            }
            sessions[id]->poll(frame * 16);
            for (const Request& request : sessions[id]->advance().requests) {
                if (const Advance* a = std::get_if<Advance>(&request)) sessions[id]->report_hash(a->tick, 0);
            }
            while (sessions[id]->next_confirmed()) ++confirmed[id];
        }
    }
    CHECK(confirmed[0] > 100);
    CHECK(confirmed[1] > 100);
    CHECK(sessions[0]->stats().packets_dropped == 0);
}

TEST_CASE("a session reports a machine of another match or line-up and drops all its packets") {
    SimulatedNetwork network(2, {}, 1);
    SessionDef def;
    def.input_size = 4;
    def.players = {0, 1};
    const auto first = make_rollback_session(def, network.endpoint(0)).value();
    def.self = 1;
    def.match_id = 1;
    const auto second = make_rollback_session(def, network.endpoint(1)).value();
    for (std::uint64_t now = 0; now < 100; ++now) {
        network.advance_to(now);
        first->poll(now);
        second->poll(now);
        CHECK(first->advance().stall == Stall::connecting);
    }
    const auto notice = first->next_notice();
    REQUIRE(notice);
    CHECK(std::get<PeerIncompatible>(*notice).peer == 1);
    CHECK_FALSE(first->next_notice());
    CHECK(first->stats().dropped[static_cast<std::size_t>(PacketFault::match)] ==
          first->stats().packets_received);
}
