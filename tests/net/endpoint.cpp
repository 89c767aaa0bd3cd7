// Players connect over a bad network, and each of their packets arrives unchanged, once.
#include "net/wire.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("net: two players connect and each packet arrives once and unchanged") {
    Players players(2);
    REQUIRE(players.connect());
    for (std::uint8_t i = 0; i < 100; ++i) {
        players.send(0, 1, 30u + i, std::byte{i});
        players.wire.advance();
    }
    players.wire.run(100);
    const auto taken = players.taken(1);
    REQUIRE(taken.size() == 100);
    for (std::uint8_t i = 0; i < 100; ++i) {
        CHECK(taken[i].first == 0);
        CHECK(taken[i].second == Packet(30u + i, std::byte{i}));
    }
    CHECK(players[1].stats().refused_in_all() == 0);
}

TEST_CASE("net: sixteen players connect in spite of 30 % loss, jitter and duplicates") {
    Players players(16);
    players.wire.latency_ms = 60, players.wire.jitter_ms = 40;
    players.wire.loss_permille = 300, players.wire.duplicate_permille = 100;
    CHECK(players.connect(20'000));
    std::size_t arrived = 0, twice = 0;
    for (int i = 0; i < 200; ++i) {
        players.send(3, 12, 40, static_cast<std::byte>(i));
        players.wire.advance(16);
    }
    players.wire.run(300);
    std::array<int, 256> seen{};
    for (const auto& [from, packet] : players.taken(12))
        ++arrived, twice += ++seen[std::to_integer<std::size_t>(packet[0])] > 1;
    CHECK(arrived > 110);
    CHECK(twice == 0);
}

TEST_CASE("net: an endpoint adds 19 bytes to each packet of the session") {
    Players players(2);
    REQUIRE(players.connect());
    const std::uint64_t before = players[0].stats().bytes_sent;
    players.send(0, 1, 18);
    CHECK(players[0].stats().bytes_sent - before == 37);
    CHECK(net_overhead_bytes == 19);
}

TEST_CASE("net: a packet of the maximum size arrives and an endpoint does not send a longer one") {
    Players players(2);
    REQUIRE(players.connect());
    players.send(0, 1, packet_bytes_max);
    players.send(0, 1, packet_bytes_max + 1);
    players.wire.run(100);
    CHECK(players.taken(1).size() == 1);
    CHECK(players[0].stats().over_budget == 1);
}

TEST_CASE("net: a player that restarts with the same token connects again under other keys") {
    Players players(2);
    REQUIRE(players.connect());
    for (const PeerId who : {PeerId{1}, PeerId{0}}) {
        players[who] = Endpoint::create(players.tokens[who], {}, players.wire.now_ms).value();
        players.wire.run(5000);
        REQUIRE(players.all_connected());
        players.send(0, 1), players.send(1, 0);
        players.wire.run(100);
        CHECK(players.taken(0).size() == 1);
        CHECK(players.taken(1).size() == 1);
    }
}

TEST_CASE("net: an endpoint accepts 70,000 consecutive packets and a packet after a gap of 30,000") {
    Players players(
        2,
        {.packets_per_second = 1'000'000, .opens_per_second = 1'000'000, .bytes_per_second = 1'000'000'000});
    players.wire.latency_ms = 0;
    REQUIRE(players.connect());
    std::size_t arrived = 0;
    for (int i = 0; i < 70'000; ++i) {
        players.send(0, 1, 4);
        if (i % 100 == 99) players.wire.advance(1), arrived += players.taken(1).size();
    }
    CHECK(arrived == 70'000);
    for (int i = 0; i < 30'000; ++i) {
        players.send(0, 1, 4);
        while (players[0].next_outgoing()) {} // lost
    }
    players.send(0, 1, 4);
    players.wire.run(10);
    CHECK(players.taken(1).size() == 1);
}

TEST_CASE("net: the replay window accepts packets that arrive out of order and rejects packets older than "
          "the window") {
    Players players(2, {.packets_per_second = 1'000'000, .bytes_per_second = 1'000'000'000});
    REQUIRE(players.connect());
    std::vector<Packet> kept;
    for (std::uint32_t i = 0; i < 1200; ++i) {
        players.send(0, 1, 4);
        while (const auto out = players[0].next_outgoing()) kept.push_back(packet_of(out->bytes));
    }
    const auto arrive = [&](std::size_t i) {
        players[1].receive(address(10), kept[i], players.wire.now_ms);
        players.taken(1);
    };
    arrive(1199);
    arrive(10);
    CHECK(refused(players[1], NetFault::replayed) == 1);
    for (std::size_t i = 1199 - 900; i < 1199; ++i) arrive(i);
    CHECK(players[1].stats().delivered == 901);
    arrive(20);
    CHECK(players[1].stats().delivered == 901);
    CHECK(refused(players[1], NetFault::replayed) == 2);
}

TEST_CASE("net: a third player of the match cannot read or forge packets between two players") {
    Players players(3);
    REQUIRE(players.connect());
    players.wire.keeps = true;
    players.send(0, 1, 40);
    players.wire.run(100);
    CHECK(players.taken(1).size() == 1);
    // Player 2 sends its packet, with its own keys, in the name of player 0.
    players.send(2, 1, 40);
    const auto own = players[2].next_outgoing();
    REQUIRE(own);
    Packet forged = packet_of(own->bytes);
    forged[0] = std::byte{0x80};
    players[1].receive(address(10), forged, players.wire.now_ms);
    CHECK(players.taken(1).empty());
    CHECK(refused(players[1], NetFault::unauthenticated) == 1);
}

TEST_CASE("net: the budget for sending limits the bytes that an endpoint sends in a second") {
    Players players(2, {.bytes_per_second = 10'000});
    REQUIRE(players.connect());
    const std::uint64_t before = players[0].stats().bytes_sent;
    for (int i = 0; i < 1000; ++i) {
        players.send(0, 1, 500);
        while (players[0].next_outgoing()) {}
    }
    CHECK(players[0].stats().bytes_sent - before <= 10'000);
    CHECK(players[0].stats().over_budget > 900);
}

TEST_CASE("net: an endpoint keeps its time when the given time goes backwards") {
    Players players(2);
    REQUIRE(players.connect());
    players[0].poll(5);
    players[0].receive(address(11), Packet(3, std::byte{0x91}), 5);
    players.send(0, 1);
    players.wire.run(100);
    CHECK(players.taken(1).size() == 1);
}
