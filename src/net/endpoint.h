// The state of an endpoint. handshake.cpp agrees on keys, sealed.cpp uses them, relay_link.cpp connects to
// relays.
#pragma once

#include "net/cookie.h"
#include "net/limits.h"
#include "net/packet.h"
#include "net/packet_queue.h"
#include "net/replay_window.h"

namespace lockstone::net {

/// The keys of a pair of players after a handshake, with the packet numbers in use.
struct Channel {
    DirectedKeys keys;
    std::uint64_t sent = 0; ///< number of the next packet
    ReplayWindow window;
};

/// An attempt of the initiator at a handshake. It repeats its hello and request with one nonce.
struct Attempt {
    std::uint64_t nonce = 0, started_ms = 0, tried_ms = 0, cookie = 0, cookie_ms = 0;
    NetKey secret; ///< of this attempt only
    bool runs = false, has_cookie = false;
};

/// The responder's answer to an authentic request. It becomes the channel when a packet proves that the
/// initiator has the keys.
struct Pending {
    Channel channel;
    std::uint64_t nonce, since_ms;
    NetAddress from;
    std::array<std::byte, accept_bytes> accept;
};

/// The connection to another player.
struct Peer {
    DirectedKeys pair;  ///< from the keys in the token; for handshakes only
    NetAddress listed;  ///< address in the token, or of the relay where the peer is expected
    NetAddress address; ///< proven address; port 0: no handshake yet
    std::optional<Channel> channel;
    std::optional<Pending> pending;
    std::uint64_t channel_nonce = 0; ///< nonce of the request that led to the channel
    Attempt attempt;
    std::uint64_t sent_ms = 0, heard_ms = 0, punched_ms = 0, relay_changed_ms = 0;
    /// Another address that authentic packets come from, while a challenge to it is open.
    NetAddress candidate;
    std::uint64_t challenge = 0, challenged_ms = 0;
    Bucket hellos, requests, packets, bytes;
};

/// The connection to a relay.
struct RelayLink {
    RelaySeat seat;
    Attempt attempt;
    bool is_in = false;
    std::uint64_t heard_ms = 0;
};

} // namespace lockstone::net

namespace lockstone {

struct Endpoint::Impl {
    using Fault = std::optional<NetFault>;
    Impl(const ConnectToken& token, const EndpointDef& def, std::uint64_t now_ms);

    ConnectToken token;
    EndpointDef def;
    std::uint64_t now;
    std::array<net::Peer, net_players_max> peers;
    std::array<net::RelayLink, 2> relays; ///< the second one only together with a first
    net::CookieJar cookies;
    net::SourceLimit hello_sources;
    net::Bucket hellos, opens;
    net::PacketQueue<NetAddress> outgoing;
    net::PacketQueue<PeerId> delivered;
    NetStats stats;

    void advance(std::uint64_t now_ms) { now = std::max(now, now_ms); }
    bool has_relay() const { return token.relay.port != 0; }
    bool initiates(PeerId slot) const { return token.slot > slot; }
    std::uint32_t match_low() const { return static_cast<std::uint32_t>(token.match_id); }
    /// The first byte of a datagram to a player. To a relay it holds the receiver's slot, which the relay
    /// replaces by the sender's.
    std::byte first_to(net::Kind kind, PeerId slot) const {
        return net::first_byte(kind, has_relay() ? slot : token.slot);
    }
    /// Counts a decryption; false: the rate limit is exceeded.
    bool may_open();
    net::Space push(const NetAddress& to, std::size_t size) {
        return net::push_counted(outgoing, stats, to, size);
    }
    Fault take(const NetAddress& from, net::Bytes datagram);

    // handshake.cpp
    Fault take_handshake(PeerId slot, const NetAddress& from, net::Bytes datagram);
    Fault handshake_fault(net::Bytes datagram) const;
    Fault take_hello(PeerId slot, const NetAddress& from, net::Bytes datagram);
    Fault take_cookie(PeerId slot, const NetAddress& from, net::Bytes datagram);
    Fault take_request(PeerId slot, const NetAddress& from, net::Bytes datagram);
    Fault take_accept(PeerId slot, const NetAddress& from, net::Bytes datagram);
    void answer_request(PeerId slot, const NetAddress& from, std::uint64_t nonce, const NetKey& theirs);
    void poll_handshake(PeerId slot);
    void send_request(PeerId slot);

    // sealed.cpp
    Fault take_sealed(PeerId slot, const NetAddress& from, net::Bytes datagram);
    Fault open(net::Channel& channel, net::Bytes datagram, net::Space plain, std::uint64_t& number);
    Fault open_any(net::Peer& peer, net::Bytes datagram, net::Space plain, std::uint64_t& number);
    Fault apply(PeerId slot, const NetAddress& from, net::Kind kind, net::Bytes plain);
    void judge_path(PeerId slot, const NetAddress& from, std::size_t size);
    Fault prove_path(PeerId slot, const NetAddress& from, std::uint64_t answer);
    void send_sealed(PeerId slot, const NetAddress& to, net::Kind kind, net::Bytes plain);
    void send_control(PeerId slot, const NetAddress& to, net::Kind kind, std::uint64_t value);
    void poll_keep_alive(PeerId slot);

    // relay_link.cpp
    net::RelayLink* relay_at(const NetAddress& address);
    Fault take_from_relay(net::RelayLink& relay, net::Bytes datagram);
    void poll_relay(net::RelayLink& relay);
    void send_relay_request(const net::RelayLink& relay);
    bool is_missed(net::RelayLink& relay);
    void poll_path(PeerId slot);
};

} // namespace lockstone
