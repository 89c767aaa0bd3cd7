// Datagrams of strangers change nothing, are counted by their kind, and cost little. tests/net/planted/run makes each
// test fail on purpose.
#include "net/wire.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// Player 1 of two connected players is attacked; player 0 is at `home`.
struct Attacked {
    Players players{2};
    NetAddress home = address(10), elsewhere = address(66, 4444);
    std::vector<OnTheWay> handshake;

    Attacked() {
        players.wire.keeps = true;
        REQUIRE(players.connect());
        players.wire.run(100);
        handshake = players.wire.sent;
        players.taken(0), players.taken(1);
    }
    /// A new packet of player 0 that has not arrived anywhere.
    Packet fresh(std::size_t size = 40) {
        players.send(0, 1, size);
        const auto out = players[0].next_outgoing();
        REQUIRE(out);
        return packet_of(out->bytes);
    }
    /// The first datagram of a kind that was sent during the handshake.
    Packet of_kind(int kind) const {
        for (const OnTheWay& d : handshake)
            if (std::to_integer<std::uint8_t>(d.bytes[0]) >> 4 == kind) return d.bytes;
        FAIL("nothing of this kind was sent");
        return {};
    }
    /// Checks that player `at` counts the packet as this fault, and that nothing else has changed.
    void refuses(PeerId at, const NetAddress& from, const Packet& packet, NetFault fault) {
        const NetStats before = players[at].stats();
        players[at].receive(from, packet, players.wire.now_ms);
        const NetStats& after = players[at].stats();
        INFO(std::string(name_of(fault)));
        CHECK(after.refused[static_cast<std::size_t>(fault)] ==
              before.refused[static_cast<std::size_t>(fault)] + 1);
        CHECK(after.refused_in_all() == before.refused_in_all() + 1);
        CHECK(after.sent == before.sent);
        CHECK(after.delivered == before.delivered);
        CHECK(players[at].address_of(1 - at) == address(static_cast<std::uint8_t>(11 - at)));
        CHECK(players.taken(at).empty());
    }
    /// Checks that both still exchange packets.
    void still_works() {
        players.send(0, 1), players.send(1, 0);
        players.wire.run(100);
        CHECK(players.taken(0).size() == 1);
        CHECK(players.taken(1).size() == 1);
    }
};

Packet changed(Packet packet, std::size_t at) {
    packet[at] ^= std::byte{1};
    return packet;
}

} // namespace

TEST_CASE("net: an endpoint rejects a datagram that was replayed") {
    Attacked a;
    const Packet packet = a.fresh();
    a.players[1].receive(a.home, packet, a.players.wire.now_ms);
    CHECK(a.players.taken(1).size() == 1);
    a.refuses(1, a.home, packet, NetFault::replayed);
    a.refuses(1, a.elsewhere, packet, NetFault::replayed);
    a.still_works();
}

TEST_CASE("net: an endpoint rejects a datagram that was changed in any byte") {
    Attacked a;
    const Packet packet = a.fresh();
    for (std::size_t at = 3; at < packet.size(); ++at)
        a.refuses(1, a.home, changed(packet, at), NetFault::unauthenticated);
    a.refuses(1, a.home, changed(packet, 2), NetFault::unauthenticated);
    Packet as_another_kind = packet;
    as_another_kind.resize(27);
    as_another_kind[0] = std::byte{0x90};
    a.refuses(1, a.home, as_another_kind, NetFault::unauthenticated);
    a.still_works();
}

TEST_CASE("net: an endpoint rejects a datagram that was forged at another address as spoofed") {
    Attacked a;
    a.refuses(1, a.elsewhere, changed(a.fresh(), 9), NetFault::spoofed);
    a.still_works();
}

TEST_CASE("net: an endpoint rejects a datagram that is too short or too long or of an unknown kind") {
    Attacked a;
    a.refuses(1, a.home, {}, NetFault::truncated);
    for (std::size_t size = 1; size < net_overhead_bytes; ++size)
        a.refuses(1, a.home, Packet(size, std::byte{0x80}), NetFault::truncated);
    a.refuses(1, a.home, Packet(net_datagram_bytes_max + 1, std::byte{0x80}), NetFault::oversized);
    a.refuses(1, a.home, Packet(65'000, std::byte{0x80}), NetFault::oversized);
    a.refuses(1, a.home, Packet(40, std::byte{0}), NetFault::malformed);
    a.refuses(1, a.home, Packet(40, std::byte{0xb0}), NetFault::oversized);
    a.refuses(1, a.home, Packet(packet_bytes_max, std::byte{0x60}), NetFault::unexpected); // not for players
    for (const int kind : {1, 2, 3, 4}) {
        Packet packet = a.of_kind(kind);
        packet.push_back(std::byte{0});
        a.refuses(kind % 2 == 1 ? 0 : 1, a.home, packet, NetFault::oversized);
        packet.resize(packet.size() - 2);
        a.refuses(kind % 2 == 1 ? 0 : 1, a.home, packet, NetFault::truncated);
    }
    a.still_works();
}

TEST_CASE("net: an endpoint rejects a datagram from a slot that belongs to no other player") {
    Attacked a;
    Packet packet = a.fresh();
    for (const int slot : {1, 2, 15}) {
        packet[0] = static_cast<std::byte>(0x80 | slot);
        a.refuses(1, a.home, packet, NetFault::stranger);
    }
    a.still_works();
}

TEST_CASE("net: an endpoint rejects a handshake of another version or match") {
    Attacked a;
    for (const int kind : {1, 3}) {
        a.refuses(0, a.elsewhere, changed(a.of_kind(kind), 1), NetFault::version);
        a.refuses(0, a.elsewhere, changed(a.of_kind(kind), 2), NetFault::match);
    }
    a.refuses(1, a.home, changed(a.of_kind(2), 1), NetFault::version);
    a.refuses(1, a.home, changed(a.of_kind(4), 1), NetFault::version);
    a.still_works();
}

TEST_CASE("net: an endpoint rejects a request without a cookie for the sender's address before it decrypts "
          "the request") {
    Attacked a;
    const std::uint64_t opened = a.players[0].stats().opened;
    a.refuses(0, a.elsewhere, a.of_kind(3), NetFault::cookie);
    a.refuses(0, address(66), a.of_kind(3), NetFault::cookie);
    a.refuses(0, address(11, 1), a.of_kind(3), NetFault::cookie);
    a.refuses(0, address(11), changed(a.of_kind(3), 14), NetFault::cookie);
    a.players.wire.now_ms += 9000;
    a.refuses(0, address(11), a.of_kind(3), NetFault::cookie);
    CHECK(a.players[0].stats().opened == opened);
}

TEST_CASE("net: an endpoint rejects a request that is replayed or changed behind its cookie") {
    Attacked a;
    a.refuses(0, address(11), a.of_kind(3), NetFault::replayed);
    a.refuses(0, address(11), changed(a.of_kind(3), 60), NetFault::unauthenticated);
    a.still_works();
}

TEST_CASE("net: an endpoint rejects answers that it does not expect") {
    Attacked a;
    a.refuses(1, a.home, a.of_kind(2), NetFault::unexpected);
    a.refuses(1, a.home, a.of_kind(4), NetFault::unexpected);
    a.refuses(1, a.home, Packet(24, std::byte{0xc0}), NetFault::unexpected);
    a.still_works();
}

TEST_CASE(
    "net: a hello draws an answer that is no longer than the hello and leaves no state at the endpoint") {
    Attacked a;
    const std::uint64_t bytes = a.players[0].stats().bytes_sent, opened = a.players[0].stats().opened;
    const Packet hello = a.of_kind(1);
    a.players[0].receive(a.elsewhere, hello, a.players.wire.now_ms);
    const auto answer = a.players[0].next_outgoing();
    REQUIRE(answer);
    CHECK(answer->to == a.elsewhere);
    CHECK(answer->bytes.size() <= hello.size());
    CHECK(a.players[0].stats().bytes_sent - bytes == answer->bytes.size());
    CHECK(a.players[0].stats().opened == opened);
    a.still_works();
}

TEST_CASE("net: an endpoint sends an unproven address at most as many bytes as it received from there") {
    Attacked a;
    Random random = Random::seeded(5);
    for (std::uint64_t i = 0; i < 20'000; ++i) {
        const std::vector<OnTheWay>& kept = a.handshake;
        Packet packet = kept[random.below(static_cast<std::uint32_t>(kept.size()))].bytes;
        if (random.below(2) == 0)
            packet[random.below(static_cast<std::uint32_t>(packet.size()))] ^= std::byte{1};
        const PeerId at = random.below(2);
        a.players[at].receive(address(static_cast<std::uint8_t>(random.below(250)), 9), packet,
                              a.players.wire.now_ms += i % 3);
        std::size_t answered = 0;
        while (const auto out = a.players[at].next_outgoing()) answered += out->bytes.size();
        REQUIRE(answered <= packet.size());
    }
}

TEST_CASE("net: after the token's end an endpoint answers no handshake and keeps its connections") {
    Attacked a;
    a.players.wire.now_ms = start_ms + 60'000;
    a.refuses(0, a.elsewhere, a.of_kind(1), NetFault::expired);
    a.refuses(0, address(11), a.of_kind(3), NetFault::expired);
    CHECK_FALSE(Endpoint::create(a.players.tokens[0], {}, start_ms + 60'000));
    a.still_works();
}

TEST_CASE("net: an endpoint limits its answers per second to hellos of one source and of all sources") {
    Attacked a;
    const Packet hello = a.of_kind(1);
    for (int i = 0; i < 1000; ++i) a.players[0].receive(a.elsewhere, hello, a.players.wire.now_ms);
    CHECK(a.players[0].stats().answered <= 2 + EndpointDef{}.hellos_per_source);
    CHECK(refused(a.players[0], NetFault::over_rate) >= 1000 - EndpointDef{}.hellos_per_source);
    for (std::uint32_t i = 0; i < 100'000; ++i) {
        NetAddress from = a.elsewhere;
        from.ip[12] = static_cast<std::uint8_t>(i), from.ip[13] = static_cast<std::uint8_t>(i >> 8);
        a.players[0].receive(from, hello, a.players.wire.now_ms);
        while (a.players[0].next_outgoing()) {}
    }
    CHECK(a.players[0].stats().answered <=
          2 + EndpointDef{}.hellos_per_source + EndpointDef{}.hellos_per_second);
    a.still_works();
}

TEST_CASE("net: strangers that flood an endpoint with hellos do not keep a player out") {
    Players players(2);
    Packet hello(24, std::byte{0});
    hello[0] = std::byte{0x11}, hello[1] = std::byte{1}, hello[2] = std::byte{77};
    Random random = Random::seeded(3);
    for (int frame = 0; frame < 100 && !players.all_connected(); ++frame) {
        for (std::uint32_t i = 0; i < 500; ++i) {
            NetAddress from = address(66);
            from.ip[12] = static_cast<std::uint8_t>(random.below(256)),
            from.ip[13] = static_cast<std::uint8_t>(random.below(256));
            players[0].receive(from, hello, players.wire.now_ms + 16);
        }
        players.wire.advance(16);
    }
    CHECK(players.all_connected());
    CHECK(refused(players[0], NetFault::over_rate) > 1000);
}

TEST_CASE("net: an endpoint drops packets of a peer beyond its rate") {
    Attacked a;
    std::size_t got = 0;
    for (int i = 0; i < 2000; ++i)
        a.players[1].receive(a.home, a.fresh(4), a.players.wire.now_ms), got += a.players.taken(1).size();
    CHECK(got <= EndpointDef{}.packets_per_second);
    CHECK(got > 400);
    CHECK(refused(a.players[1], NetFault::over_rate) > 1500);
}

TEST_CASE("net: a second's flood makes an endpoint open at most its limit of ciphertexts") {
    Attacked a;
    const Packet forged = changed(a.fresh(), 9);
    const std::uint64_t before = a.players[1].stats().opened;
    for (int i = 0; i < 200'000; ++i) a.players[1].receive(a.elsewhere, forged, a.players.wire.now_ms);
    CHECK(a.players[1].stats().opened - before <= EndpointDef{}.opens_per_second);
    CHECK(refused(a.players[1], NetFault::over_rate) >= 150'000);
    a.players.wire.now_ms += 1000;
    a.still_works();
}

TEST_CASE(
    "net: an endpoint changes a player's address only after a challenge is answered from the new address") {
    Attacked a;
    const NetAddress moved = address(10, 50'123);
    a.players.wire.move(a.home, moved);
    a.players.send(0, 1);
    a.players.wire.advance(20), a.players.wire.advance(20);
    CHECK(a.players[1].address_of(0) == a.home);
    a.players.wire.run(200);
    CHECK(a.players[1].address_of(0) == moved);
    CHECK(a.players[1].stats().paths_changed == 1);
    a.players.taken(1);
    a.still_works();
}

TEST_CASE("net: a fresh packet of a player that an attacker sends from elsewhere draws one challenge and no "
          "more packets") {
    Attacked a;
    for (int i = 0; i < 50; ++i) {
        const Packet stolen = a.fresh(); // under way to player 1, which gets it from elsewhere
        a.players[1].receive(a.elsewhere, stolen, a.players.wire.now_ms);
        a.players.send(1, 0);
        int to_elsewhere = 0;
        while (const auto out = a.players[1].next_outgoing()) {
            to_elsewhere += out->to == a.elsewhere ? 1 : 0;
            CHECK(out->bytes.size() <= stolen.size());
        }
        CHECK(to_elsewhere <= (i % 25 == 0 ? 1 : 0));
        a.players.wire.now_ms += 10;
    }
    CHECK(a.players[1].address_of(0) == a.home);
    CHECK(a.players[1].stats().paths_changed == 0);
    a.players.taken(0), a.players.taken(1);
    a.still_works();
}

TEST_CASE("net: an older packet from elsewhere does not draw a challenge") {
    Attacked a;
    const Packet older = a.fresh(), newer = a.fresh();
    a.players[1].receive(a.home, newer, a.players.wire.now_ms);
    a.players[1].receive(a.elsewhere, older, a.players.wire.now_ms);
    CHECK_FALSE(a.players[1].next_outgoing());
    CHECK(a.players.taken(1).size() == 2);
}

TEST_CASE("net: a challenge that is answered from elsewhere does not change a player's address") {
    Attacked a;
    const NetAddress moved = address(10, 50'123);
    a.players[1].receive(moved, a.fresh(), a.players.wire.now_ms);
    const auto challenge = a.players[1].next_outgoing();
    REQUIRE(challenge);
    REQUIRE(challenge->to == moved);
    a.players[0].receive(address(11), challenge->bytes, a.players.wire.now_ms);
    const auto answer = a.players[0].next_outgoing();
    REQUIRE(answer);
    a.players.taken(1);
    a.refuses(1, a.elsewhere, packet_of(answer->bytes), NetFault::unexpected);
    CHECK(a.players[1].stats().paths_changed == 0);
}

TEST_CASE(
    "net: a player that claims another's place in the match cannot connect without the key of that place") {
    Players players(3);
    ConnectToken stolen = players.tokens[2];
    stolen.slot = 1, stolen.public_keys[1] = public_key_of(stolen.secret);
    Endpoint impostor = Endpoint::create(stolen, {}, start_ms).value();
    players.wire.attach(address(66), impostor);
    REQUIRE(players.connect());
    players.wire.run(2000);
    CHECK_FALSE(impostor.is_connected(0));
    CHECK(refused(players[0], NetFault::spoofed) > 0);
    CHECK(players[0].address_of(1) == address(11));
}
