// Spectators: each one sees the match that was played, whenever it joins, and detects any difference.
#include "session/join/spectator.h"
#include "session/join/join_net.h"
#include "session/seal.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("spectators from the start and from later on see the match as it was played and soon live") {
    JoinNet watched(2);
    JoinNet::Guest& first = watched.watch({.hosts = {0}});
    watched.run(1200);
    CHECK(watched.behind(first) <= 60);
    JoinNet::Guest& late = watched.watch({.hosts = {0}});
    watched.run(700); // 1200 ticks at four a frame, while the match plays 500 more
    CHECK(watched.behind(late) <= 60);
    CHECK(watched.behind(first) <= 60);
    CHECK(late.session->quality(0).hashes_agreed == late.timeline.ticks.size());
    MESSAGE("behind: ", watched.behind(first), " and ", watched.behind(late), " ticks; sent ",
            watched.host(0).bytes_sent(), " bytes");
    CHECK(watched.match.agree(0, 1));
}

TEST_CASE("a spectator sees the departure of a player as the players do") {
    JoinNet watched(2);
    JoinNet::Guest& watcher = watched.watch({.hosts = {0}});
    watched.run(300);
    REQUIRE(watched.match.machine(0).session->drop_peer(1).ok());
    watched.run(300);
    CHECK(watched.behind(watcher) <= 60);
    CHECK(watcher.timeline.ticks.back().statuses[1] == InputStatus::disconnected);
}

TEST_CASE("a host with a delay shows each tick no sooner than that many ticks after it was played") {
    JoinNet watched(2, {.delay_ticks = 120});
    JoinNet::Guest& watcher = watched.watch({.hosts = {0}});
    for (int i = 0; i < 30; ++i) {
        watched.run(20);
        CHECK(watched.match.machine(0).timeline.ticks.size() - watcher.timeline.ticks.size() >=
              std::min<std::size_t>(120, watched.match.machine(0).timeline.ticks.size()));
    }
    CHECK(watched.behind(watcher) <= 180);
}

TEST_CASE("a spectator with another world reports the first tick that differs and other spectators report no "
          "desync") {
    JoinNet watched(2);
    JoinNet::Guest &right = watched.watch({.hosts = {0}}), &wrong = watched.watch({.hosts = {0}});
    watched.run(200);
    const std::uint64_t tick = wrong.session->current_tick();
    wrong.arena.state().edit_row(arena_columns().agent, 3).speed ^= 1;
    watched.run(200);
    const std::vector<Desync> told = wrong.notices_of<Desync>();
    REQUIRE(told.size() == 1);
    CHECK(told[0].tick == tick);
    CHECK(wrong.session->quality(0).hashes_agreed == tick);
    CHECK(watched.behind(right) <= 60);
    CHECK(right.notices.size() == 1); // connected
}

TEST_CASE("a spectator that leaves frees its place, a host ignores one without a place and the match is "
          "unchanged") {
    JoinNet watched(2, {.watchers_max = 1, .silence_polls = 60}), alone(2);
    JoinNet::Guest& first = watched.watch({.hosts = {0}});
    watched.run(200);
    JoinNet::Guest& second = watched.watch({.hosts = {0}});
    watched.run(200);
    CHECK(second.timeline.ticks.empty());
    CHECK(second.runner->frame(watched.match.now_ms).stall == Stall::connecting);
    first.is_there = false;
    watched.run(400);
    CHECK(watched.host(0).watchers() == 1);
    CHECK(watched.behind(second) <= 60);
    alone.run(800);
    CHECK(watched.match.machine(0).timeline.ticks == alone.match.machine(0).timeline.ticks);
}

TEST_CASE("a host and a spectator survive any bytes and ignore claims beyond the sent ticks") {
    JoinNet watched(2, {.watchers_max = 4});
    JoinNet::Guest& watcher = watched.watch({.hosts = {0}});
    test::SplitMix random(3);
    std::vector<std::byte> buffer;
    const std::uint32_t match = session::packet_context(watched.def).match;
    for (int i = 0; i < 400; ++i) {
        watched.run(1);
        for (int more = 0; more < 5; ++more) {
            const bool to_host = random.below(2) == 0;
            const auto bytes =
                to_host ? session::write_wish(
                              buffer, match,
                              {.wants_log = true,
                               .wants_state = random.below(2) == 0,
                               .wanted = random.below(2) == 0 ? random.below(500) : random.next() >> 33,
                               .asked = random.below(500)})
                        : session::write_stretch(buffer, match + random.below(2),
                                                 {random.below(500), 0, random.below(500), {}});
            std::vector<std::byte> packet(bytes.begin(), bytes.end());
            if (random.below(2) == 0)
                packet[random.below(static_cast<std::uint32_t>(packet.size()))] =
                    static_cast<std::byte>(random.next());
            if (random.below(4) != 0) test::seal(packet, 0);
            watched.network.endpoint(to_host ? 5 + random.below(2) : 6)
                .send(to_host ? 0 : 2, packet); // from a stranger
        }
    }
    CHECK(watched.behind(watcher) <= 60);
    CHECK(watcher.session->stats().dropped[static_cast<std::size_t>(PacketFault::stranger)] > 100);
    CHECK_FALSE(make_spectator_session(watched.def, 0, watched.network.endpoint(1), 0));
    CHECK_FALSE(make_spectator_session({}, 0, watched.network.endpoint(1)));
}
