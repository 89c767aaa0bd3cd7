// Hundreds of spectators watch through a relay: a player's traffic does not grow with them, a spectator that stops
// reading harms no other, and a host may leave.
#include "session/join/relayed_scenes.h"
#include "session/seal.h"
#include "support/effort.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

SpectatorRelayDef relay_def() { return {.hosts = {0, 1}, .state_polls = 300}; }

} // namespace

TEST_CASE(
    "300 spectators follow the match nearly live through a relay and a player sends as much as for one") {
    CHECK(relays::many_watchers(static_cast<std::uint32_t>(test::tries(300))) == "");
}

TEST_CASE("a player without a relay sends more for each spectator") {
    // The negative control: without the relay the count of bytes grows with the spectators.
    const auto bytes = [](std::uint32_t count) {
        RelayedMatch net(1);
        SimulatedNetwork direct(count + 1, RelayedMatch::bad, 9);
        SpectatorHost host(net.def, direct.endpoint(0));
        std::vector<std::unique_ptr<Session>> sessions;
        std::vector<std::unique_ptr<Arena>> arenas;
        std::vector<std::unique_ptr<SessionRunner>> runners;
        for (PeerId id = 1; id <= count; ++id) {
            sessions.push_back(make_spectator_session(net.def, 0, direct.endpoint(id)).value());
            arenas.push_back(std::make_unique<Arena>(3));
            runners.push_back(std::make_unique<SessionRunner>(*sessions.back(), *arenas.back()));
        }
        std::size_t told = 0;
        for (int frame = 0; frame < 300; ++frame) {
            net.run(1);
            direct.advance_to(net.match.now_ms);
            show_ticks(host, net.match.machine(0).timeline, 3, told);
            host.poll();
            for (const auto& runner : runners) runner->frame(net.match.now_ms);
        }
        return host.bytes_sent();
    };
    CHECK(bytes(10) * 100 > bytes(1) * relays::many_to_one_percent);
}

TEST_CASE("a relay sends no more to spectators that stop reading and serves the others as before") {
    RelayedMatch net(20, relay_def()), without(10, relay_def());
    for (int i = 0; i < 20; ++i) net.watch(false);
    for (int i = 0; i < 10; ++i) without.watch(false);
    net.run(300), without.run(300);
    for (std::size_t i = 10; i < 20; ++i) net.watchers[i]->reads = false;
    net.run(70), without.run(70); // drains the packets under way
    const std::uint64_t before = net.relay->counters().bytes_to_watchers,
                        before_without = without.relay->counters().bytes_to_watchers;
    net.run(400), without.run(400);
    CHECK(net.furthest_behind() <= RelayedMatch::near);
    const std::uint64_t sent = net.relay->counters().bytes_to_watchers - before,
                        sent_without = without.relay->counters().bytes_to_watchers - before_without;
    CHECK(sent * 100 <= sent_without * 105);
    CHECK(sent_without * 100 <= sent * 105);
    MESSAGE("to ten who read and ten who do not ", sent, " bytes, to ten ", sent_without);
}

TEST_CASE("planted: a spectator without another host falls behind when its host leaves") {
    JoinNet alone(3);
    JoinNet::Guest& stays = alone.watch({.hosts = {0}});
    alone.run(300);
    alone.network.unplug(0);
    alone.run(600);
    CHECK(alone.behind(stays) > 300);
}

TEST_CASE(
    "a relay rejects a state whose hash differs from the ticks and packets of a host that it does not use") {
    RelayedMatch net(2, {.hosts = {0, 1}, .state_polls = 120});
    std::vector<std::byte> buffer;
    const std::uint32_t match = session::packet_context(net.def).match;
    const std::vector<std::byte> image(500, std::byte{7});
    for (std::uint64_t frame = 0; frame < 400; ++frame) {
        net.run(1);
        const std::uint64_t next = net.relay->counters().next_tick;
        if (next < 2) continue;
        // The test sends, in the host's name, a state of its own making; and from machine 1, which the relay does not
        // use, a stretch.
        const session::Snapshot snapshot(next - 1, 12345, image);
        session::Chunk chunk;
        snapshot.chunk(0, chunk);
        net.upper.endpoint(0).send(RelayedMatch::relay_up,
                                   session::write_offer(buffer, match, snapshot.offer()));
        net.upper.endpoint(0).send(RelayedMatch::relay_up, session::write_chunk(buffer, match, chunk));
        const std::vector<std::byte> tick(6 + 3 * sizeof(Pad), std::byte{9});
        net.upper.endpoint(1).send(RelayedMatch::relay_up,
                                   session::write_stretch(buffer, match, {next + 1, 1, next + 2, tick}));
    }
    CHECK(net.relay->counters().states_refused > 0);
    CHECK(net.relay->counters().packets_dropped > 100);
    RelayedMatch::Watcher& from_start = net.watch(false);
    net.run(400);
    CHECK(net.behind(from_start) <= RelayedMatch::near);
}

TEST_CASE("a spectator relay survives any bytes from hosts and from spectators") {
    RelayedMatch net(6, relay_def());
    net.watch(false), net.watch(true);
    test::SplitMix random(5);
    std::vector<std::byte> buffer;
    const std::uint32_t match = session::packet_context(net.def).match;
    for (int i = 0; i < 600; ++i) {
        net.run(1);
        for (int more = 0; more < 4; ++more) {
            const bool from_above = random.below(2) == 0;
            session::Wish wish{.wants_log = true, .wants_state = random.below(2) == 0};
            wish.wanted = random.below(700), wish.offered = random.below(700), wish.missing = random.below(9);
            const std::vector<std::byte> ticks(18 * 3, static_cast<std::byte>(random.next()));
            const auto bytes =
                from_above ? session::write_stretch(buffer, match + random.below(2),
                                                    {random.next() >> 33, 3, random.next() >> 33, ticks})
                           : session::write_wish(buffer, match, wish);
            std::vector<std::byte> packet(bytes.begin(), bytes.end());
            if (random.below(2) == 0)
                packet[random.below(static_cast<std::uint32_t>(packet.size()))] =
                    static_cast<std::byte>(random.next());
            if (random.below(4) != 0) test::seal(packet, 0);
            if (from_above)
                net.upper.endpoint(1).send(RelayedMatch::relay_up, packet);
            else
                net.lower.endpoint(3 + random.below(4)).send(0, packet);
        }
    }
    CHECK(net.furthest_behind() <= RelayedMatch::near);
}

TEST_CASE("make_spectator_relay() rejects an invalid definition with a sentence") {
    SimulatedNetwork network(2, {}, 1);
    SessionDef def;
    def.players = {0, 1};
    const auto complaint = [&](const SpectatorRelayDef& how) {
        const auto made = make_spectator_relay(def, how, network.endpoint(0), network.endpoint(1));
        return made ? std::string() : made.error().message;
    };
    CHECK(complaint({.hosts = {0}}).empty());
    CHECK(complaint({.hosts = {}}) == "spectator relay: 0 hosts, expected 1 to 16");
    CHECK(complaint({.hosts = {0}, .log_ticks_max = 10}) ==
          "spectator relay: log_ticks_max is 10, at least 1024");
    CHECK(complaint({.hosts = {0}, .state_polls = 60}) ==
          "spectator relay: state_polls is 60, 0 or at least 120");
    CHECK(complaint({.hosts = {0}, .state_bytes_max = 0}) ==
          "spectator relay: state_bytes_max is 0, expected 1 to 67108864");
}
