// A door admits every machine with a token, does not answer any other, and gives free places to the next machine.
#include "net/wire.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

const NetAddress door_at = address(1, 8800);

struct Watched {
    Wire wire;
    WatchDoor door;
    std::vector<std::unique_ptr<Endpoint>> watchers;

    explicit Watched(std::uint32_t places = 8)
        : door(WatchDoor::create({.address = door_at,
                                  .expires_ms = start_ms + 3'600'000,
                                  .watchers_max = places,
                                  .idle_ms = 10'000},
                                 start_ms)
                   .value()) {
        wire.keeps = true;
        wire.attach(door_at, door);
    }
    Endpoint& come(std::uint8_t host) {
        watchers.push_back(std::make_unique<Endpoint>(
            Endpoint::create(door.let_in(wire.now_ms).value(), {}, wire.now_ms).value()));
        wire.attach(address(host), *watchers.back());
        return *watchers.back();
    }
    std::vector<std::pair<PeerId, Packet>> taken() {
        std::vector<std::pair<PeerId, Packet>> all;
        while (const auto packet = door.next_packet())
            all.emplace_back(packet->from, packet_of(packet->bytes));
        return all;
    }
};

} // namespace

TEST_CASE("net: a door exchanges packets with each spectator separately by its place") {
    Watched net;
    for (std::uint8_t i = 0; i < 5; ++i) net.come(static_cast<std::uint8_t>(20 + i));
    net.wire.run(1000);
    CHECK(net.door.counters().connected == 5);
    for (std::size_t i = 0; i < 5; ++i)
        net.watchers[i]->send(0, Packet(40, static_cast<std::byte>(i)), net.wire.now_ms);
    net.wire.run(100);
    const auto taken = net.taken();
    REQUIRE(taken.size() == 5);
    for (const auto& [from, packet] : taken) {
        CHECK(packet == Packet(40, static_cast<std::byte>(from)));
        net.door.send(from, Packet(50, static_cast<std::byte>(from)), net.wire.now_ms);
    }
    net.wire.run(100);
    for (std::size_t i = 0; i < 5; ++i) {
        const auto packet = net.watchers[i]->next_packet();
        REQUIRE(packet);
        CHECK(packet->from == 0);
        CHECK(packet_of(packet->bytes) == Packet(50, static_cast<std::byte>(i)));
        CHECK_FALSE(net.watchers[i]->next_packet());
    }
}

TEST_CASE(
    "net: no sender without a token draws an answer from a door even with a copy of a spectator's packet") {
    Watched net;
    net.come(20);
    net.wire.run(1000);
    net.watchers[0]->send(0, Packet(40), net.wire.now_ms);
    const Packet packet = packet_of(net.watchers[0]->next_outgoing()->bytes);
    Random random = Random::seeded(3);
    const auto before = net.door.counters();
    for (int i = 0; i < 3000; ++i) {
        Packet bytes(random.below(1300));
        for (std::byte& b : bytes) b = static_cast<std::byte>(random.below(256));
        if (!bytes.empty() && i % 2 == 0) bytes[0] = static_cast<std::byte>((1 + random.below(15)) << 4 | 1);
        net.door.receive(address(66), bytes, net.wire.now_ms);
        CHECK_FALSE(net.door.next_outgoing());
    }
    net.door.receive(address(66), packet, net.wire.now_ms); // a copy, from elsewhere
    CHECK_FALSE(net.door.next_outgoing());
    CHECK(net.taken().empty());
    CHECK(net.door.counters().strangers == before.strangers + 3001);
    net.door.receive(address(20), packet, net.wire.now_ms);
    CHECK(net.taken().size() == 1);
    net.door.receive(address(20), packet, net.wire.now_ms); // again
    CHECK(net.taken().empty());
}

TEST_CASE(
    "net: a door limits its places and the place of a spectator that is silent for long becomes free again") {
    Watched net(2);
    net.come(20), net.come(21);
    const auto refused = net.door.let_in(net.wire.now_ms);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message == "all 2 places for those who watch are taken");
    for (int i = 0; i < 12; ++i) {
        net.watchers[0]->send(0, Packet(30), net.wire.now_ms);
        net.wire.run(1000), net.taken();
    }
    CHECK(net.door.counters().let_in == 1);
    Endpoint& third = net.come(22);
    net.wire.run(1000);
    CHECK(third.is_connected(0));
    CHECK(net.watchers[0]->is_connected(0));
    net.watchers[1]->send(0, Packet(30), net.wire.now_ms); // its token is no longer valid
    net.wire.run(200);
    CHECK(net.taken().empty());
}

TEST_CASE(
    "net: a spectator from another address enters again with its token and its old address loses the place") {
    Watched net;
    Endpoint& watcher = net.come(20);
    net.wire.run(1000);
    net.wire.move(address(20), address(40));
    for (int i = 0; i < 80; ++i) {
        watcher.send(0, Packet(30), net.wire.now_ms);
        net.wire.run(100);
    }
    CHECK(net.taken().size() > 10);
    net.door.send(0, Packet(31), net.wire.now_ms);
    net.wire.run(100);
    CHECK(watcher.next_packet());
}

TEST_CASE("net: a door with an invalid definition is rejected") {
    const auto complaint = [](const WatchDoorDef& def) {
        const auto made = WatchDoor::create(def, start_ms);
        return made ? std::string() : made.error().message;
    };
    CHECK(complaint({.address = door_at, .expires_ms = start_ms + 1}).empty());
    CHECK(complaint({.address = {}, .expires_ms = start_ms + 1}) == "WatchDoorDef::address has no port");
    CHECK(complaint({.address = door_at, .expires_ms = start_ms}) == "WatchDoorDef::expires_ms is over");
    CHECK(complaint({.address = door_at, .expires_ms = start_ms + 1, .watchers_max = 0}) ==
          "WatchDoorDef::watchers_max is 0, must be 1..4096");
}
