// How packets travel: the interface that sessions use, and a network in memory for tests, demos and soak runs.
//
//   SimulatedNetwork network(2, {.latency_ms = 60, .jitter_ms = 20, .loss_permille = 100}, /*seed=*/7);
//   each frame: network.advance_to(now_ms); the sessions on network.endpoint(0) and endpoint(1) poll
//
// A transport may lose, repeat, reorder and damage packets: sessions expect nothing better.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lockstone {

/// Names one machine of a match; the same number on every machine.
using PeerId = std::uint32_t;

/// No packet of a session is longer: fits an Ethernet frame through any tunnel, so it is never split on the way.
inline constexpr std::size_t packet_bytes_max = 1200;

/// A packet that has arrived.
struct Datagram {
    PeerId from;
    std::span<const std::byte> bytes; ///< valid until the next call of receive
};

/// One machine's access to the others. Implemented by SimulatedNetwork, or by the game over what carries its packets;
/// lockstone/net.h has one over UDP.
class Transport {
  public:
    virtual ~Transport() = default;
    /// Hands over one packet, at most packet_bytes_max long. It may never arrive; nobody tells.
    virtual void send(PeerId to, std::span<const std::byte> bytes) = 0;
    /// The next packet that has arrived, whoever sent it, whatever is in it; nothing when there is none.
    virtual std::optional<Datagram> receive() = 0;
    /// Whether what `receive` hands over is what the machine it names has sent, to the bit, and to this match. Then packets
    /// carry no checksum of their own. The same at both ends.
    virtual bool authenticated() const { return false; }
};

/// How one direction between two endpoints behaves. Chances are in 1/1000, each packet on its own.
struct LinkDef {
    std::uint32_t latency_ms = 0;
    std::uint32_t jitter_ms = 0; ///< added to the latency, uniform in 0..jitter_ms; reorders by itself
    std::uint32_t loss_permille = 0;
    std::uint32_t duplicate_permille = 0; ///< arrives twice, with independent jitter
    std::uint32_t reorder_permille = 0;   ///< held back by reorder_ms, so that later packets overtake it
    std::uint32_t reorder_ms = 50;
    std::uint32_t damage_permille = 0; ///< one byte is changed on the way
};

/// N endpoints in memory. The same seed and the same calls deliver the same packets in the same order, always.
class SimulatedNetwork {
  public:
    SimulatedNetwork(std::uint32_t endpoints, const LinkDef& every_link, std::uint64_t seed);
    SimulatedNetwork(const SimulatedNetwork&) = delete;
    SimulatedNetwork& operator=(const SimulatedNetwork&) = delete;
    ~SimulatedNetwork();

    Transport& endpoint(PeerId peer);
    /// One direction; packets on their way keep the old behaviour.
    void set_link(PeerId from, PeerId to, const LinkDef& def);
    /// Both directions of every link of an endpoint: pulls its plug, until set_link puts it back.
    void unplug(PeerId peer);
    /// Time never goes backwards. Packets due by now can be received.
    void advance_to(std::uint64_t now_ms);

    struct Counters {
        std::uint64_t sent, lost, duplicated, damaged, delivered;
    };
    const Counters& counters() const { return counts; }

  private:
    struct Endpoint;
    struct Link {
        LinkDef def;
        std::uint64_t random_state; ///< its own stream: what one link draws does not depend on the others
    };
    void send(PeerId from, PeerId to, std::span<const std::byte> bytes);
    void put_on_the_way(Link& link, PeerId from, PeerId to, std::span<const std::byte> bytes);
    Link& link(PeerId from, PeerId to);

    std::vector<Endpoint> endpoints;
    std::vector<Link> links; ///< from * endpoints + to
    std::uint64_t now = 0;
    std::uint64_t sequence = 0;
    Counters counts{};
};

} // namespace lockstone
