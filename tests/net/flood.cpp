// The cost of floods, printed for readers: 100,000 datagrams of each kind, as a part of a core's second. hostile.cpp
// bounds the work by counts; this file checks no time.
#include "net/wire.h"

#include <doctest/doctest.h>

#include <chrono>

using namespace lockstone;
using namespace lockstone::test;

namespace {

constexpr std::uint32_t flood_packets = 100'000; // in one second

template <class Target>
void measure(const std::string& what, Target& target, const Packet& packet, bool many_sources) {
    const std::uint64_t opened = target.stats().opened, answered = target.stats().answered;
    static std::uint64_t second_ms = start_ms + 10'000; // the buckets are full again at each second
    second_ms += 5000;
    const auto begun = std::chrono::steady_clock::now();
    for (std::uint32_t i = 0; i < flood_packets; ++i) {
        NetAddress from = address(66);
        if (many_sources)
            from.ip[12] = static_cast<std::uint8_t>(i), from.ip[13] = static_cast<std::uint8_t>(i >> 8);
        target.receive(from, packet, second_ms + i / 100);
        while (target.next_outgoing()) {}
    }
    const auto took =
        std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - begun)
            .count();
    MESSAGE("flood of 100,000 a second, ", what, ": ", took / 1000, ".", took / 100 % 10, " ms, ",
            took / 10'000, " % of a core; ", target.stats().opened - opened, " opened, ",
            target.stats().answered - answered, " answered");
}

} // namespace

TEST_CASE("net: a measurement prints the cost of each kind of flood") {
    Players players(2);
    players.wire.keeps = true;
    REQUIRE(players.connect());
    Packet hello, request;
    for (const OnTheWay& d : players.wire.sent) {
        if (d.bytes[0] == std::byte{0x11}) hello = d.bytes;
        if (d.bytes[0] == std::byte{0x31}) request = d.bytes;
    }
    Packet data(60, std::byte{1}), longest(net_datagram_bytes_max, std::byte{1});
    data[0] = longest[0] = std::byte{0x81};
    measure("hellos of many addresses", players[0], hello, true);
    measure("requests with a wrong cookie", players[0], request, true);
    measure("forged data of 60 bytes", players[0], data, false);
    measure("forged data of 1,219 bytes", players[0], longest, false);
    measure("noise", players[0], Packet(200, std::byte{0xf3}), true);
    Relay relay(random_key(), {}, start_ms);
    hello[0] = std::byte{0xc0}, hello[2] = std::byte{0};
    measure("hellos of many addresses at a relay", relay, hello, true);
    measure("data of strangers at a relay", relay, data, true);
    Packet asked(packet_bytes_max, std::byte{1});
    asked[0] = std::byte{0x60};
    measure("lobby requests with a wrong cookie", relay, asked, true);
}
