// Real sockets on 127.0.0.1: whole matches of rollback-arena, encrypted, directly and through a relay. The tests count
// time in frames, so twenty seconds of a match take a few.
#include "net/net_player.h"
#include "net/wire.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone;
using namespace lockstone::test;

namespace {

constexpr std::uint64_t match_ticks = 1200; // 20 s at 60 Hz
constexpr std::uint64_t never = ~std::uint64_t{0};
const NetAddress any_port = parse_address("127.0.0.1:0").value();

/// A relay with a socket.
struct SocketRelay {
    NetKey secret = random_key();
    UdpSocket socket = UdpSocket::open(any_port).value();
    Relay relay{secret, {}, start_ms};
    void poll(std::uint64_t now_ms) {
        for (auto arrived = socket.receive(); arrived; arrived = socket.receive())
            relay.receive(arrived->from, arrived->bytes, now_ms);
        relay.poll(now_ms);
        while (const auto out = relay.next_outgoing()) socket.send(out->to, out->bytes);
    }
};

/// Ports that are free now. The sockets that had them are closed when the function returns.
std::vector<NetAddress> free_addresses(std::uint32_t count) {
    std::vector<UdpSocket> sockets;
    std::vector<NetAddress> found;
    for (std::uint32_t i = 0; i < count; ++i) {
        sockets.push_back(UdpSocket::open(any_port).value());
        found.push_back(sockets.back().local_address());
    }
    return found;
}

struct Outcome {
    std::vector<std::vector<std::uint64_t>> hashes;
    std::vector<NetStats> wire;
    std::uint64_t rollbacks = 0;
    std::uint64_t leader_first = 0; ///< the first tick that machine 0 confirmed since it came back
    bool good = true;
};

/// `relays`: the relays of the plan; the first one is lost at frame `lost_at`. Machine 0, which opened the match, may
/// be lost too. It may come back with its token and no other data.
Outcome play(const MatchPlan& plan, std::vector<SocketRelay*> relays, std::uint64_t lost_at = never,
             std::uint64_t leader_lost_at = never, std::uint64_t leader_back_at = never) {
    const auto players = static_cast<std::uint32_t>(plan.addresses.size());
    const auto game = make_scene("rollback-arena", {.size = 0, .seed = 1, .players = players}).value();
    const auto tokens = make_tokens(plan).value();
    std::vector<std::unique_ptr<UdpTransport>> transports;
    std::vector<std::unique_ptr<NetPlayer>> machines;
    for (PeerId slot = 0; slot < players; ++slot) {
        transports.push_back(std::make_unique<UdpTransport>(
            UdpTransport::open(tokens[slot], {}, plan.addresses[slot], start_ms).value()));
        machines.push_back(std::make_unique<NetPlayer>(*game, slot, players, *transports.back()));
    }
    const auto done = [&] {
        const std::ptrdiff_t first = leader_lost_at == never || leader_back_at != never ? 0 : 1;
        return std::all_of(machines.begin() + first, machines.end(),
                           [](const auto& m) { return m->end() >= match_ticks; });
    };
    const auto poll_relays = [&](std::uint64_t frame, std::uint64_t now_ms) {
        for (std::size_t r = frame < lost_at ? 0 : 1; r < relays.size(); ++r) relays[r]->poll(now_ms);
    };
    for (std::uint64_t frame = 0; frame < 4 * match_ticks && !done(); ++frame) {
        const std::uint64_t now_ms = start_ms + frame * 1000 / 60;
        if (frame == leader_back_at) {
            machines[0] = nullptr, transports[0] = nullptr;
            transports[0] =
                std::make_unique<UdpTransport>(UdpTransport::open(tokens[0], {}, any_port, now_ms).value());
            machines[0] = std::make_unique<NetPlayer>(*game, 0, players, *transports[0], nullptr, 1);
        }
        for (PeerId slot = 0; slot < players; ++slot) {
            if (slot == 0 && frame >= leader_lost_at && frame < leader_back_at) continue;
            // Each machine reads its packets in one of six frames, so inputs arrive late and are predicted.
            if (frame < 60 || (frame + slot) % 6 == 0) transports[slot]->poll(now_ms);
            poll_relays(frame, now_ms);
            machines[slot]->frame(now_ms, match_ticks);
            poll_relays(frame, now_ms);
        }
    }
    Outcome out;
    out.leader_first = machines[0]->first;
    for (PeerId slot = 0; slot < players; ++slot) {
        out.hashes.push_back(machines[slot]->hashes),
            out.wire.push_back(transports[slot]->endpoint().stats());
        out.good = out.good && !machines[slot]->desynced && !machines[slot]->lost;
        const SessionStats& stats = machines[slot]->stats();
        out.rollbacks += stats.rollbacks;
        MESSAGE("player ", slot, ": ", stats.ticks, " ticks, ", stats.rollbacks, " rollbacks, ",
                out.wire.back().sent, " datagrams, ", out.wire.back().bytes_sent,
                " bytes above UDP, of which the session's ", stats.bytes_sent);
    }
    return out;
}

} // namespace

TEST_CASE("net: two machines play rollback-arena over UDP on 127.0.0.1 and agree on every confirmed hash") {
    MatchPlan plan = plan_of(2);
    plan.addresses = free_addresses(2);
    const Outcome out = play(plan, {});
    CHECK(out.good);
    REQUIRE(out.hashes[0].size() == match_ticks);
    CHECK(out.hashes[0] == out.hashes[1]);
    CHECK(out.rollbacks > 20);
    for (const NetStats& stats : out.wire) {
        CHECK(stats.refused_in_all() == 0);
        CHECK(stats.over_budget < 60); // while they connect
    }
}

TEST_CASE("net: four machines play through a relay on 127.0.0.1 and agree on every confirmed hash") {
    SocketRelay relay;
    MatchPlan plan = plan_of(4);
    plan.addresses = free_addresses(4);
    plan.relay = relay.socket.local_address(), plan.relay_secret = relay.secret;
    plan.relay_expires_ms = start_ms + 3'600'000;
    const Outcome out = play(plan, {&relay});
    CHECK(out.good);
    for (PeerId slot = 0; slot < 4; ++slot) {
        REQUIRE(out.hashes[slot].size() == match_ticks);
        CHECK(out.hashes[slot] == out.hashes[0]);
    }
    CHECK(relay.relay.counters().forwarded > match_ticks);
    CHECK(relay.relay.stats().refused_in_all() == 0);
}

/// Three machines that know two relays.
static MatchPlan plan_through(const SocketRelay& first, const SocketRelay& second) {
    MatchPlan plan = plan_of(3);
    plan.addresses = free_addresses(3);
    plan.relay = first.socket.local_address(), plan.relay_secret = first.secret;
    plan.second_relay = second.socket.local_address(), plan.second_relay_secret = second.secret;
    plan.relay_expires_ms = start_ms + 3'600'000;
    return plan;
}

TEST_CASE("net: three machines continue through the second relay when the first one fails during a match") {
    SocketRelay first, second;
    MatchPlan plan = plan_through(first, second);
    const Outcome out = play(plan, {&first, &second}, 400);
    CHECK(out.good); // no machine has left, no hash differs
    for (PeerId slot = 0; slot < 3; ++slot) {
        REQUIRE(out.hashes[slot].size() == match_ticks);
        CHECK(out.hashes[slot] == out.hashes[0]);
    }
    CHECK(second.relay.counters().forwarded > match_ticks / 2);

    plan.second_relay = {}; // planted fault: without a second relay the match ends there
    plan.addresses = free_addresses(3);
    const Outcome lost = play(plan, {&first, &second}, 400);
    CHECK_FALSE(lost.good);
    CHECK(lost.hashes[0] != lost.hashes[1]); // each continued alone
}

TEST_CASE(
    "net: when the opener of a match fails the others continue from the confirmed ticks through the relay") {
    SocketRelay relay;
    MatchPlan plan = plan_of(3);
    plan.addresses = free_addresses(3);
    plan.relay = relay.socket.local_address(), plan.relay_secret = relay.secret;
    plan.relay_expires_ms = start_ms + 3'600'000;
    const Outcome out = play(plan, {&relay}, never, 400);
    REQUIRE(out.hashes[1].size() == match_ticks);
    CHECK(out.hashes[1] == out.hashes[2]);
    REQUIRE(out.hashes[0].size() > 300);
    CHECK(out.hashes[0].size() < 500);
    CHECK(std::ranges::equal(out.hashes[0], std::span(out.hashes[1]).first(out.hashes[0].size())));
}

TEST_CASE("net: when the opener fails with its own relay the others continue at the second one and it "
          "rejoins there") {
    SocketRelay first, second;
    MatchPlan plan = plan_through(first, second);
    const Outcome out = play(plan, {&first, &second}, 400, 400, 1000);
    REQUIRE(out.hashes[1].size() == match_ticks);
    CHECK(out.hashes[1] == out.hashes[2]);
    CHECK(out.leader_first > 400);
    REQUIRE(out.leader_first + out.hashes[0].size() == match_ticks);
    CHECK(std::ranges::equal(out.hashes[0], std::span(out.hashes[1]).subspan(out.leader_first)));

    plan.second_relay = {}; // planted fault: without a second relay the machines never connect again
    plan.addresses = free_addresses(3);
    const Outcome lost = play(plan, {&first, &second}, 400, 400, 1000);
    CHECK(lost.hashes[1] != lost.hashes[2]);
    CHECK(lost.hashes[0].empty());
}

TEST_CASE("net: the comparison of hashes can fail because another game has other hashes") {
    // The negative control of the two tests above: the comparison can fail.
    const auto game = make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 2}).value();
    const auto other = make_scene("rollback-arena", {.size = 0, .seed = 2, .players = 2}).value();
    SimulatedNetwork network(2, {}, 1);
    NetPlayer a(*game, 0, 2, network.endpoint(0)), b(*game, 1, 2, network.endpoint(1));
    SimulatedNetwork elsewhere(2, {}, 1);
    NetPlayer c(*other, 0, 2, elsewhere.endpoint(0)), d(*other, 1, 2, elsewhere.endpoint(1));
    for (std::uint64_t frame = 0; frame < 300; ++frame) {
        network.advance_to(frame * 16), elsewhere.advance_to(frame * 16);
        for (NetPlayer* player : {&a, &b, &c, &d}) player->frame(frame * 16, 100);
    }
    CHECK(a.hashes == b.hashes);
    CHECK(a.hashes.size() == 100);
    CHECK(a.hashes != c.hashes);
}

TEST_CASE("net: a socket supports IPv4 and IPv6, returns nothing when it is empty and reports why it cannot "
          "be opened") {
    UdpSocket a = UdpSocket::open(any_port).value(), b = UdpSocket::open(any_port).value();
    CHECK_FALSE(a.receive());
    const Packet bytes(30, std::byte{5});
    b.send(a.local_address(), bytes);
    a.wait(1000);
    const auto arrived = a.receive();
    REQUIRE(arrived);
    CHECK(arrived->from == b.local_address());
    CHECK(packet_of(arrived->bytes) == bytes);
    const auto taken = UdpSocket::open(a.local_address());
    REQUIRE_FALSE(taken);
    CHECK(taken.error().message.find("cannot listen at 127.0.0.1:") == 0);
    // No interface has this address. Its last four bytes are zero, as those of 0.0.0.0 are.
    const auto foreign = UdpSocket::open(parse_address("[2001:db8:1:2:3:4::]:0").value());
    REQUIRE_FALSE(foreign);
    CHECK(foreign.error().message.find("cannot listen at [2001:db8:1:2:3:4::]:0") == 0);
    if (auto six = UdpSocket::open(parse_address("[::1]:0").value())) {
        six->send(six->local_address(), bytes);
        six->wait(1000);
        CHECK(six->receive());
    } else {
        MESSAGE("this machine has no IPv6");
    }
}
