// SimulatedNetwork (lockstone/session/transport.h).
#include "lockstone/math/random.h"
#include "lockstone/session/transport.h"

#include "base/assert.h"

#include <algorithm>

namespace lockstone {

namespace {

/// Packets under way to one endpoint; a larger number allocates once.
constexpr std::size_t usual_flights = 32;

bool happens(std::uint64_t& state, std::uint32_t permille) { return split_mix(state) % 1000 < permille; }

} // namespace

struct SimulatedNetwork::Endpoint final : Transport {
    struct Flight {
        std::uint64_t due_ms;
        std::uint64_t sequence;
        PeerId from;
        std::vector<std::byte> bytes;
    };
    SimulatedNetwork* network = nullptr;
    PeerId self = 0;
    /// Packets under way to this endpoint, by (due_ms, sequence), the first to arrive last.
    std::vector<Flight> inbox;
    std::vector<std::vector<std::byte>> buffers; ///< of received packets, for reuse
    std::vector<std::byte> arrived;              ///< the packet that receive() returned last

    void send(PeerId to, std::span<const std::byte> bytes) override { network->send(self, to, bytes); }

    std::optional<Datagram> receive() override {
        if (inbox.empty() || inbox.back().due_ms > network->now) return std::nullopt;
        Flight flight = std::move(inbox.back());
        inbox.pop_back();
        buffers.push_back(std::move(arrived));
        arrived = std::move(flight.bytes);
        ++network->counts.delivered;
        return Datagram{flight.from, arrived};
    }

    void accept(std::uint64_t due_ms, std::uint64_t number, PeerId from, std::span<const std::byte> bytes) {
        std::vector<std::byte> buffer;
        if (!buffers.empty()) {
            buffer = std::move(buffers.back());
            buffers.pop_back();
        }
        buffer.reserve(packet_bytes_max);
        buffer.assign(bytes.begin(), bytes.end());
        const auto later = [](const Flight& a, std::uint64_t due) { return a.due_ms > due; };
        // Before packets with an equal time, so that it is received after them.
        const auto place = std::lower_bound(inbox.begin(), inbox.end(), due_ms, later);
        inbox.insert(place, Flight{due_ms, number, from, std::move(buffer)});
    }
};

SimulatedNetwork::SimulatedNetwork(std::uint32_t endpoint_count, const LinkDef& every_link,
                                   std::uint64_t seed) {
    endpoints.resize(endpoint_count);
    for (PeerId id = 0; id < endpoint_count; ++id) {
        endpoints[id].network = this;
        endpoints[id].self = id;
        endpoints[id].inbox.reserve(usual_flights);
        endpoints[id].buffers.resize(usual_flights);
        for (std::vector<std::byte>& buffer : endpoints[id].buffers) buffer.reserve(packet_bytes_max);
    }
    for (std::uint64_t i = 0; i < std::uint64_t{endpoint_count} * endpoint_count; ++i)
        links.push_back({every_link, split_mix(seed)});
}

SimulatedNetwork::~SimulatedNetwork() = default;

Transport& SimulatedNetwork::endpoint(PeerId peer) {
    LOCKSTONE_ASSERT(peer < endpoints.size(), "endpoint ", peer, " of ", endpoints.size());
    return endpoints[peer];
}

SimulatedNetwork::Link& SimulatedNetwork::link(PeerId from, PeerId to) {
    LOCKSTONE_ASSERT(from < endpoints.size() && to < endpoints.size(), from, " to ", to, " of ",
                     endpoints.size());
    return links[std::size_t{from} * endpoints.size() + to];
}

void SimulatedNetwork::set_link(PeerId from, PeerId to, const LinkDef& def) { link(from, to).def = def; }

void SimulatedNetwork::unplug(PeerId peer) {
    for (PeerId other = 0; other < endpoints.size(); ++other) {
        link(peer, other).def.loss_permille = 1000;
        link(other, peer).def.loss_permille = 1000;
    }
}

void SimulatedNetwork::advance_to(std::uint64_t now_ms) {
    LOCKSTONE_ASSERT(now_ms >= now, now_ms, " after ", now);
    now = now_ms;
}

void SimulatedNetwork::send(PeerId from, PeerId to, std::span<const std::byte> bytes) {
    Link& way = link(from, to);
    ++counts.sent;
    if (happens(way.random_state, way.def.loss_permille)) {
        ++counts.lost;
        return;
    }
    put_on_the_way(way, from, to, bytes);
    if (happens(way.random_state, way.def.duplicate_permille)) {
        ++counts.duplicated;
        put_on_the_way(way, from, to, bytes);
    }
}

void SimulatedNetwork::put_on_the_way(Link& way, PeerId from, PeerId to, std::span<const std::byte> bytes) {
    std::uint64_t due =
        now + way.def.latency_ms + split_mix(way.random_state) % (std::uint64_t{way.def.jitter_ms} + 1);
    if (happens(way.random_state, way.def.reorder_permille)) due += way.def.reorder_ms;
    Endpoint& target = endpoints[to];
    target.accept(due, sequence++, from, bytes);
    if (bytes.empty() || !happens(way.random_state, way.def.damage_permille)) return;
    ++counts.damaged;
    for (Endpoint::Flight& flight : target.inbox) {
        if (flight.sequence + 1 != sequence) continue;
        const std::uint64_t bits = split_mix(way.random_state);
        flight.bytes[bits % bytes.size()] ^= static_cast<std::byte>(1 + (bits >> 32) % 255);
    }
}

} // namespace lockstone
