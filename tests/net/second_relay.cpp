// Two relays: the match continues through the second one when the first is lost, for all players or for one.
#include "net/wire.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

const NetAddress first_at = address(1, 9999), second_at = address(2, 9999);
const NetKey first_secret = random_key(), second_secret = random_key();

/// The longest allowed silence of a match: a session's timeout, less its last wait.
constexpr std::uint64_t patience_ms = 2500;

MatchPlan twice_relayed(std::uint32_t players) {
    MatchPlan plan = plan_of(players);
    plan.relay = first_at, plan.relay_secret = first_secret;
    plan.second_relay = second_at, plan.second_relay_secret = second_secret;
    plan.relay_expires_ms = start_ms + 3'600'000;
    return plan;
}

struct TwoRelays : Players {
    Relay first{first_secret, {}, start_ms}, second{second_secret, {}, start_ms};
    explicit TwoRelays(std::uint32_t players = 3) : TwoRelays(twice_relayed(players)) {}
    explicit TwoRelays(const MatchPlan& plan) : Players(plan) {
        wire.attach(first_at, first), wire.attach(second_at, second);
    }
    /// Each pair sends a packet every 15 ms for so long. Returns the longest silence of one player at another [ms].
    std::uint64_t longest_silence(std::uint64_t ms) {
        const auto count = static_cast<PeerId>(endpoints.size());
        std::map<std::pair<PeerId, PeerId>, std::uint64_t> heard;
        std::uint64_t longest = 0;
        const std::uint64_t begun = wire.now_ms;
        for (; wire.now_ms < begun + ms; wire.run(15)) {
            for (PeerId a = 0; a < count; ++a)
                for (PeerId b = 0; b < count; ++b)
                    if (a != b) send(a, b);
            for (PeerId at = 0; at < count; ++at) {
                for (const auto& [from, packet] : taken(at)) heard[{from, at}] = wire.now_ms;
                for (PeerId from = 0; from < count; ++from)
                    if (from != at)
                        longest = std::max(longest, wire.now_ms - std::max(begun, heard[{from, at}]));
            }
        }
        return longest;
    }
};

} // namespace

TEST_CASE("net: players do not use the second relay while the first one works") {
    TwoRelays match;
    REQUIRE(match.connect());
    CHECK(match.longest_silence(10'000) <= 100);
    CHECK(match.second.counters().players == 0);
    for (PeerId slot = 0; slot < 3; ++slot) CHECK(match[slot].stats().paths_changed == 0);
}

TEST_CASE("net: when the relay is lost all players meet at the second one within a session's timeout and "
          "stay there") {
    TwoRelays match;
    REQUIRE(match.connect());
    match.longest_silence(2000);
    match.wire.detach(first_at);
    const std::uint64_t silence = match.longest_silence(10'000);
    CHECK(silence <= patience_ms);
    MESSAGE("silent for ", silence, " ms");
    CHECK(match.longest_silence(10'000) <= 100);
    CHECK(match.second.counters().players == 3);
    for (PeerId slot = 0; slot < 3; ++slot) CHECK(match[slot].address_of((slot + 1) % 3) == second_at);
}

TEST_CASE("net: without a second relay the players lose each other when the only relay fails") {
    // The planted fault of the test above.
    MatchPlan plan = twice_relayed(3);
    plan.second_relay = {};
    TwoRelays match(plan);
    REQUIRE(match.connect());
    match.longest_silence(2000);
    match.wire.detach(first_at);
    CHECK(match.longest_silence(10'000) > 9000);
}

TEST_CASE("net: a single player that loses its path to the relay meets the others at the second one") {
    TwoRelays match;
    REQUIRE(match.connect());
    match.longest_silence(2000);
    match.wire.is_cut = [](const OnTheWay& d) {
        return (d.from == address(11) && d.to == first_at) || (d.from == first_at && d.to == address(11));
    };
    CHECK(match.longest_silence(10'000) <= patience_ms);
    CHECK(match.longest_silence(10'000) <= 100);
    CHECK(match[0].address_of(2) == first_at); // these two have lost nothing
    CHECK(match[0].address_of(1) == second_at);
}

TEST_CASE("net: a match begins at the second relay if the first is down and moves to the first if the second "
          "fails") {
    TwoRelays match(2);
    match.wire.detach(first_at);
    REQUIRE(match.connect(6000));
    CHECK(match.longest_silence(3000) <= 100);
    match.wire.attach(first_at, match.first);
    match.wire.detach(second_at);
    CHECK(match.longest_silence(10'000) <= patience_ms + 1000); // no player has a seat at the first relay yet
    CHECK(match[0].address_of(1) == first_at);
}

TEST_CASE("net: players with a latency of two seconds there and back connect and stay at the first relay") {
    TwoRelays match(2);
    match.wire.latency_ms = 500; // from a player to the relay, and from there to the other
    REQUIRE(match.connect(20'000));
    match.longest_silence(3000);
    CHECK(match.longest_silence(10'000) <= 100);
    for (PeerId slot = 0; slot < 2; ++slot) {
        CHECK(match[slot].address_of(1 - slot) == first_at);
        CHECK(match[slot].stats().paths_changed == 0);
    }
}

TEST_CASE(
    "net: an endpoint counts a packet that comes past both relays as a stranger's even if it is a copy") {
    TwoRelays match(2);
    match.wire.keeps = true;
    REQUIRE(match.connect());
    match.send(0, 1);
    match.wire.advance();
    Packet copy;
    for (const OnTheWay& d : match.wire.sent)
        if (d.from == first_at && d.to == address(11)) copy = d.bytes;
    const std::uint64_t before = refused(match[1], NetFault::stranger);
    match[1].receive(address(66), copy, match.wire.now_ms);
    CHECK(refused(match[1], NetFault::stranger) == before + 1);
    CHECK(match[1].address_of(0) == first_at);
}

TEST_CASE("net: a lobby names the second relay in its tokens and their passes are valid there") {
    Wire wire;
    Relay first(first_secret, {.second = second_at, .second_secret = second_secret}, start_ms),
        second(second_secret, {}, start_ms);
    wire.attach(first_at, first), wire.attach(second_at, second);
    LobbyClient host(first_at, public_key_of(first_secret), "", 2);
    wire.attach(address(50), host);
    wire.run(2000);
    LobbyClient guest(first_at, public_key_of(first_secret), host.code(), 2);
    wire.attach(address(51), guest);
    wire.run(2000);
    REQUIRE(host.token());
    REQUIRE(guest.token());
    CHECK(host.token()->second_relay.address == second_at);
    Endpoint a = Endpoint::create(*host.token(), {}, wire.now_ms).value(),
             b = Endpoint::create(*guest.token(), {}, wire.now_ms).value();
    wire.attach(address(50), a), wire.attach(address(51), b);
    wire.detach(first_at); // before any player was there
    wire.run(6000);
    CHECK(a.is_connected(1));
    CHECK(b.is_connected(0));
    CHECK(second.counters().players == 2);
}
