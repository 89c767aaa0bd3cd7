// A network of addresses in memory, and its players. The wire delivers datagrams late, and may change, lose or keep
// them.
#pragma once

#include "lockstone/math/random.h"
#include "lockstone/net.h"

#include <functional>
#include <map>
#include <memory>

namespace lockstone::test {

inline NetAddress address(std::uint8_t host, std::uint16_t port = 7777) {
    NetAddress made;
    made.ip[10] = made.ip[11] = 0xff;
    made.ip[12] = 192, made.ip[14] = 2, made.ip[15] = host;
    made.port = port;
    return made;
}

using Packet = std::vector<std::byte>;
inline Packet packet_of(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

inline constexpr std::uint64_t start_ms = 1'800'000'000'000;

/// One datagram under way.
struct OnTheWay {
    NetAddress from, to;
    Packet bytes;
    std::uint64_t due_ms;
};

/// The addresses of machines, and the network between them. A node is any type that receives and returns datagrams.
class Wire {
  public:
    std::uint64_t now_ms = start_ms;
    std::uint32_t latency_ms = 20, jitter_ms = 0, loss_permille = 0, duplicate_permille = 0;
    std::vector<OnTheWay> sent; ///< all datagrams, if `keeps` is set
    bool keeps = false;

    template <class Node> void attach(const NetAddress& at, Node& node) {
        nodes[at] = {[&node, this](const OnTheWay& d) { node.receive(d.from, d.bytes, now_ms); },
                     [&node, this] { node.poll(now_ms); }, [&node] { return node.next_outgoing(); }};
    }
    /// A router gives a machine another address.
    void move(const NetAddress& from, const NetAddress& to) {
        nodes[to] = nodes.at(from);
        nodes.erase(from);
    }
    /// A machine is gone: datagrams to it are lost, and it sends none.
    void detach(const NetAddress& at) { nodes.erase(at); }
    /// Returns whether a datagram is lost; null: no loss by rule.
    std::function<bool(const OnTheWay&)> is_cut = nullptr;
    void put(OnTheWay datagram) {
        datagram.due_ms = now_ms + latency_ms + (jitter_ms == 0 ? 0 : random.below(jitter_ms));
        way.push_back(std::move(datagram));
    }
    /// Advances by `by` milliseconds: all nodes poll, and due datagrams arrive.
    void advance(std::uint64_t by = 5) {
        now_ms += by;
        for (auto& [at, node] : nodes) node.poll(), collect(at, node);
        std::vector<OnTheWay> due;
        std::erase_if(way, [&](OnTheWay& d) {
            const bool is_due = d.due_ms <= now_ms;
            if (is_due) due.push_back(std::move(d));
            return is_due;
        });
        for (const OnTheWay& datagram : due)
            if (const auto found = nodes.find(datagram.to); found != nodes.end())
                found->second.receive(datagram), collect(datagram.to, found->second);
    }
    void run(std::uint64_t ms) {
        for (const std::uint64_t end = now_ms + ms; now_ms < end;) advance();
    }

  private:
    struct Node {
        std::function<void(const OnTheWay&)> receive;
        std::function<void()> poll;
        std::function<std::optional<OutgoingDatagram>()> next;
    };
    void collect(const NetAddress& at, Node& node) {
        while (const auto out = node.next()) {
            OnTheWay datagram{at, out->to, packet_of(out->bytes), 0};
            if (keeps) sent.push_back(datagram);
            if (is_cut && is_cut(datagram)) continue;
            if (random.below(1000) < loss_permille) continue;
            if (random.below(1000) < duplicate_permille) put(datagram);
            put(std::move(datagram));
        }
    }
    std::map<NetAddress, Node> nodes;
    std::vector<OnTheWay> way;
    Random random = Random::seeded(7);
};

inline MatchPlan plan_of(std::uint32_t players) {
    MatchPlan plan{.match_id = 77,
                   .expires_ms = start_ms + 60'000,
                   .addresses = {},
                   .relay = {},
                   .relay_secret = {},
                   .relay_expires_ms = 0};
    for (std::uint32_t slot = 0; slot < players; ++slot)
        plan.addresses.push_back(address(static_cast<std::uint8_t>(10 + slot)));
    return plan;
}

/// Players of one match at the addresses of its plan.
struct Players {
    std::vector<ConnectToken> tokens;
    std::vector<std::unique_ptr<Endpoint>> endpoints;
    Wire wire;

    explicit Players(std::uint32_t count, const EndpointDef& def = {}) : Players(plan_of(count), def) {}
    explicit Players(const MatchPlan& plan, const EndpointDef& def = {}) : tokens(make_tokens(plan).value()) {
        for (std::size_t slot = 0; slot < tokens.size(); ++slot) {
            endpoints.push_back(
                std::make_unique<Endpoint>(Endpoint::create(tokens[slot], def, wire.now_ms).value()));
            wire.attach(plan.addresses[slot], *endpoints.back());
        }
    }
    Endpoint& operator[](std::size_t slot) { return *endpoints[slot]; }
    bool all_connected() const {
        for (PeerId a = 0; a < endpoints.size(); ++a)
            for (PeerId b = 0; b < endpoints.size(); ++b)
                if (a != b && !endpoints[a]->is_connected(b)) return false;
        return true;
    }
    /// Runs until all are connected, at most so long.
    bool connect(std::uint64_t ms = 3000) {
        for (const std::uint64_t end = wire.now_ms + ms; wire.now_ms < end && !all_connected();)
            wire.advance();
        return all_connected();
    }
    void send(PeerId from, PeerId to, std::size_t size = 40, std::byte fill = std::byte{7}) {
        endpoints[from]->send(to, Packet(size, fill), wire.now_ms);
    }
    /// The packets that a player has received since the last call.
    std::vector<std::pair<PeerId, Packet>> taken(PeerId at) {
        std::vector<std::pair<PeerId, Packet>> all;
        while (const auto packet = endpoints[at]->next_packet())
            all.emplace_back(packet->from, packet_of(packet->bytes));
        return all;
    }
};

inline std::uint64_t refused(const Endpoint& endpoint, NetFault fault) {
    return endpoint.stats().refused[static_cast<std::uint32_t>(fault)];
}

} // namespace lockstone::test
