// Arbitrary datagrams to players and a relay during a match. An input is a list of steps: time passes, or a datagram
// arrives. The datagram has arbitrary bytes, or it was sent before and is changed, cut, lengthened or sent from another
// address. The rules: only packets that a player sent are delivered, each once; no stranger receives more bytes than it
// sends; the players continue afterwards.
#pragma once

#include "fuzz/edits.h"
#include "net/crypto.h"
#include "net/wire.h"

#include <map>

namespace fuzz {

struct NetOutcome {
    std::uint64_t refused = 0, delivered = 0;
};

class SiegedNet {
  public:
    /// `relays`: 0, 1 or 2.
    explicit SiegedNet(std::uint32_t relays)
        : secret(lockstone::random_key()), relay(secret, {}, lockstone::test::start_ms),
          second(secret, {}, lockstone::test::start_ms) {
        auto plan = lockstone::test::plan_of(2);
        if (relays > 1) plan.second_relay = second_at, plan.second_relay_secret = secret;
        if (relays > 0)
            plan.relay = relay_at, plan.relay_secret = secret,
            plan.relay_expires_ms = lockstone::test::start_ms + 3'600'000;
        plan.expires_ms = lockstone::test::start_ms + 3'600'000;
        players = std::make_unique<lockstone::test::Players>(plan);
        players->wire.keeps = true, players->wire.latency_ms = 1;
        players->wire.attach(relay_at, relay), players->wire.attach(second_at, second);
    }

    std::string start() { return players->connect(5000) ? "" : "nobody connects"; }

    /// A frame of both players. Each sends a new packet. Returns an error sentence or an empty string.
    std::string frame(std::uint64_t ms) {
        for (lockstone::PeerId from = 0; from < 2; ++from) {
            lockstone::test::Packet packet(12, static_cast<std::byte>(from));
            for (std::size_t i = 0; i < 8; ++i) packet[4 + i] = static_cast<std::byte>(said >> (8 * i));
            ++said;
            expected[1 - from][packet] = 1;
            (*players)[from].send(1 - from, packet, players->wire.now_ms);
        }
        players->wire.advance(ms);
        return taken();
    }

    /// Delivers one datagram to player 0, player 1 or the relay. Returns an error sentence or an empty string.
    std::string attack(std::uint8_t at, const lockstone::NetAddress& from, std::span<const std::byte> bytes) {
        std::size_t drawn = 0;
        const bool is_known = from == lockstone::test::address(10) || from == lockstone::test::address(11) ||
                              from == relay_at || from == second_at;
        const auto hit = [&](auto& node) {
            while (node.next_outgoing()) {}
            node.receive(from, bytes, players->wire.now_ms);
            while (const auto out = node.next_outgoing()) drawn += out->bytes.size();
        };
        if (at % 3 == 2)
            hit(relay);
        else
            hit((*players)[at % 3]);
        if (!is_known && drawn > bytes.size()) return "a stranger drew more bytes than it sent";
        return taken();
    }

    lockstone::test::Packet sent(std::uint16_t which) const {
        const auto& all = players->wire.sent;
        return all.empty() ? lockstone::test::Packet{}
                           : all[all.size() - 1 - which % std::min<std::size_t>(all.size(), 64)].bytes;
    }

    std::string finish() {
        for (int i = 0; i < 160; ++i) {
            if (i % 16 == 0) {
                if (std::string e = frame(16); !e.empty()) return e;
            } else {
                players->wire.advance(80);
            }
        }
        const std::uint64_t before = outcome.delivered;
        for (int i = 0; i < 20; ++i)
            if (std::string e = frame(16); !e.empty()) return e;
        if (outcome.delivered < before + 30) return "they do not go on";
        for (lockstone::PeerId at = 0; at < 2; ++at)
            outcome.refused += (*players)[at].stats().refused_in_all();
        outcome.refused += relay.stats().refused_in_all();
        return {};
    }
    NetOutcome outcome;

  private:
    std::string taken() {
        for (lockstone::PeerId at = 0; at < 2; ++at)
            for (const auto& [from, packet] : players->taken(at)) {
                const auto found = expected[at].find(packet);
                if (found == expected[at].end()) return "a packet was delivered that nobody sent";
                if (found->second-- == 0) return "a packet was delivered twice";
                if (from != 1 - at) return "a packet was delivered in another's name";
                ++outcome.delivered;
            }
        return {};
    }
    lockstone::NetAddress relay_at = lockstone::test::address(1, 9999);
    lockstone::NetAddress second_at = lockstone::test::address(2, 9999);
    lockstone::NetKey secret;
    lockstone::Relay relay, second;
    std::unique_ptr<lockstone::test::Players> players;
    std::array<std::map<lockstone::test::Packet, int>, 2> expected;
    std::uint64_t said = 0;
};

/// The source address that a hostile datagram claims.
inline lockstone::NetAddress source_of(std::uint8_t which) {
    if (which % 4 == 3) return lockstone::test::address(which < 128 ? 1 : 2, 9999);
    return lockstone::test::address(which % 4 == 2 ? 66 : static_cast<std::uint8_t>(10 + which % 4),
                                    which < 192 ? 7777 : 9);
}

inline std::string net_step(Input& in, SiegedNet& net) {
    const std::uint8_t step = in.take_u8() % 4;
    if (step == 0) return net.frame(1 + in.take_u8());
    const std::uint8_t at = in.take_u8(), from = in.take_u8();
    Buffer packet;
    if (step == 1) {
        const auto bytes = in.take_bytes(in.take_u8());
        packet.assign(bytes.begin(), bytes.end());
    } else {
        packet = net.sent(in.take_u8());
        for (std::uint8_t n = step == 2 ? in.take_u8() % 4 : 0; n > 0; --n) splice(in, packet);
    }
    return net.attack(at, source_of(from), packet);
}

inline std::string check_net(std::span<const std::byte> data, NetOutcome& outcome) {
    Input in(data);
    SiegedNet net(in.take_u8() % 3);
    if (std::string e = net.start(); !e.empty()) return e;
    for (int steps = 0; steps < 200 && !in.empty(); ++steps)
        if (std::string e = net_step(in, net); !e.empty()) return e;
    std::string complaint = net.finish();
    outcome = net.outcome;
    return complaint;
}

/// Arbitrary bytes as a token or a pass, or as the content of one that is sealed with the right key.
inline std::string check_token(std::span<const std::byte> data) {
    Input in(data);
    const std::uint8_t how = in.take_u8();
    const auto rest = in.take_rest();
    const lockstone::NetKey key{};
    Buffer bytes(rest.begin(), rest.end());
    if (how % 2 == 1) bytes = lockstone::net::sealed_file(how % 4 == 1 ? "LSTK" : "LSRP", rest, key);
    if (how % 4 == 1 || how % 4 == 0) {
        const auto token = lockstone::open_token(bytes, key, 0);
        if (!token) return token.error().message.empty() ? "no reason is given" : "";
        if (token->slot >= token->players || token->players > lockstone::net_players_max)
            return "a token of a slot that nobody has";
        const auto again = lockstone::open_token(lockstone::seal_token(*token, key), key, 0);
        if (!again || again->pass != token->pass || again->addresses != token->addresses ||
            again->second_relay.address != token->second_relay.address ||
            again->second_relay.pass != token->second_relay.pass)
            return "a token changes when it is sealed again";
        const auto made = lockstone::Endpoint::create(*token, {}, 0);
        return made || !made.error().message.empty() ? "" : "no reason is given";
    }
    const auto pass = lockstone::open_pass(bytes, lockstone::NetKey{}, 0);
    return pass && pass->slot >= pass->players ? "a pass of a slot that nobody has" : "";
}

inline std::vector<Seed> net_seeds() {
    constexpr std::uint8_t frame = 0, any = 1, changed = 2, again = 3;
    std::vector<Seed> all;
    for (const std::uint8_t relays : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{2}}) {
        const std::string name = relays == 0 ? "direct_" : relays == 1 ? "relayed_" : "twice_relayed_";
        const auto begin = [&] { return Script().u8(relays).u8(frame).u8(16).u8(frame).u8(16); };
        all.push_back({name + "peace", begin().u8(frame).u8(20).done()});
        Script replays = begin(), spoofs = begin(), kinds = begin(), elsewhere = begin();
        const std::byte patch[] = {std::byte{3}};
        for (std::uint8_t which = 0; which < 48; ++which) {
            replays.u8(again).u8(which).u8(which % 2).u8(which).u8(frame).u8(1);
            elsewhere.u8(again).u8(which).u8(2).u8(which);
            spoofs.u8(changed).u8(which).u8(2).u8(which).u8(1).splice(static_cast<std::uint16_t>(which),
                                                                      which % 3, patch);
        }
        for (std::uint8_t kind = 0; kind < 16; ++kind)
            for (const std::uint8_t size : {std::uint8_t{1}, std::uint8_t{24}, std::uint8_t{94}}) {
                Buffer bytes(size, std::byte{1});
                bytes[0] = static_cast<std::byte>(kind * 16);
                kinds.u8(any).u8(kind).u8(1).u8(size).bytes(bytes);
            }
        all.push_back({name + "replays", replays.done()});
        all.push_back({name + "spoofs", spoofs.done()});
        all.push_back({name + "kinds", kinds.done()});
        all.push_back({name + "elsewhere", elsewhere.done()});
    }
    return all;
}

inline std::vector<Seed> token_seeds() {
    const auto seat = [](Buffer& of) { of[15] = std::byte{1}, of[17] = std::byte{3}; };
    Buffer token(19 + 32 + 3 * 50, std::byte{0}), relayed(19 + 32 + 3 * 32, std::byte{0});
    seat(token), seat(relayed);
    relayed[18] = std::byte{2};
    for (int relay = 0; relay < 2; ++relay) {
        Buffer at(18 + 32 + 2 + 95, std::byte{1});
        at[50] = std::byte{95}, at[51] = std::byte{0};
        relayed.insert(relayed.end(), at.begin(), at.end());
    }
    Buffer pass(50, std::byte{0});
    pass[15] = std::byte{1}, pass[17] = std::byte{2};
    return {{"nothing", {}},
            {"token_inside", Script().u8(1).bytes(token).done()},
            {"token_of_two_relays", Script().u8(1).bytes(relayed).done()},
            {"pass_inside", Script().u8(3).bytes(pass).done()},
            {"token_raw", Script().u8(0).bytes(lockstone::net::sealed_file("LSTK", token, {})).done()}};
}

} // namespace fuzz
