// Transport of packets: the interface of sessions, and a simulated network for tests, demos and soak runs.
//
//   SimulatedNetwork network(2, {.latency_ms = 60, .jitter_ms = 20, .loss_permille = 100}, /*seed=*/7);
//   each frame: network.advance_to(now_ms); the sessions on network.endpoint(0) and endpoint(1) poll
//
// A transport may lose, duplicate, reorder and damage packets; sessions handle all of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lockstone {

/// Id of a machine of a match, equal on every machine.
using PeerId = std::uint32_t;

/// Length of the longest packet of a session [bytes]. It fits into an Ethernet frame through any tunnel,
/// without fragmentation.
inline constexpr std::size_t packet_bytes_max = 1200;

/// A received packet.
struct Datagram {
    PeerId from;                      ///< sender
    std::span<const std::byte> bytes; ///< valid until the next call of receive()
};

/// A machine's connection to the others. Implementations: SimulatedNetwork, UdpTransport (lockstone/net.h),
/// or the game's own.
class Transport {
  public:
    virtual ~Transport() = default;
    /// Sends a packet of at most packet_bytes_max bytes. Best effort: failures are not reported.
    virtual void send(PeerId to, std::span<const std::byte> bytes) = 0;
    /// The next received packet, with any sender and content; empty: none.
    virtual std::optional<Datagram> receive() = 0;
    /// True if the transport guarantees sender, match and content of received packets. Sessions then omit
    /// their checksum. Must be equal on both machines. Default: false.
    virtual bool authenticated() const { return false; }
};

/// Behaviour of one direction between two endpoints. Probabilities are in 1/1000, independent for each
/// packet.
struct LinkDef {
    std::uint32_t latency_ms = 0; ///< delay [ms]
    /// Additional delay, uniform in 0..jitter_ms [ms]; reorders packets.
    std::uint32_t jitter_ms = 0;
    std::uint32_t loss_permille = 0;      ///< probability of loss
    std::uint32_t duplicate_permille = 0; ///< probability of a second copy, with its own jitter
    std::uint32_t reorder_permille = 0;   ///< probability of an additional delay of reorder_ms
    std::uint32_t reorder_ms = 50;        ///< [ms]
    std::uint32_t damage_permille = 0;    ///< probability of a changed byte
};

/// A network in memory. Equal seeds and calls deliver equal packets in equal order. One thread at a time.
class SimulatedNetwork {
  public:
    /// `endpoints` endpoints with a link in both directions between each two.
    SimulatedNetwork(std::uint32_t endpoints, const LinkDef& every_link, std::uint64_t seed);
    SimulatedNetwork(const SimulatedNetwork&) = delete;
    SimulatedNetwork& operator=(const SimulatedNetwork&) = delete;
    ~SimulatedNetwork();

    /// The transport of an endpoint, valid as long as the network. A wrong id here and below ends the
    /// program.
    Transport& endpoint(PeerId peer);
    /// Replaces the behaviour of one direction for later packets.
    void set_link(PeerId from, PeerId to, const LinkDef& def);
    /// Loses all packets to and from an endpoint, until set_link().
    void unplug(PeerId peer);
    /// Sets the time [ms]; receive() then returns packets due by now. An earlier time ends the program.
    void advance_to(std::uint64_t now_ms);

    /// Packets since the start.
    struct Counters {
        std::uint64_t sent, ///< calls of send()
            lost,           ///< lost
            duplicated,     ///< sent twice
            damaged,        ///< with a changed byte
            delivered;      ///< received
    };
    const Counters& counters() const { return counts; } ///< Valid as long as the network.

  private:
    struct Endpoint;
    struct Link {
        LinkDef def;
        std::uint64_t random_state; ///< a separate stream for each link
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
