// The connection of an endpoint to its relays: hello, cookie, request with the pass, accept; again after silence. And
// the change from one relay to the other:
//
//   a peer is silent for two thirds of relay_silence_ms: the endpoint requests a seat at both relays
//   ... for all of it: datagrams for this peer go through the other relay; after as much silence there, the first again
//   an authentic packet of it comes through the other relay: challenge and proof as for any new address (sealed.cpp)
//
// So a match continues when a relay fails, or when a single player loses the connection to it: an endpoint searches
// for a silent peer at both relays.
#include "net/endpoint.h"

#include "base/bytes.h"

namespace lockstone {

using namespace net;

namespace {

constexpr std::uint64_t retry_ms = 250, attempt_ms = 10'000, cookie_kept_ms = 3000;

} // namespace

RelayLink* Endpoint::Impl::relay_at(const NetAddress& address) {
    if (address.port == 0) return nullptr;
    for (RelayLink& relay : relays)
        if (relay.seat.address == address) return &relay;
    return nullptr;
}

/// True if a peer is expected at this relay, or if a peer elsewhere has been silent for long.
bool Endpoint::Impl::is_missed(RelayLink& relay) {
    if (relay.seat.address.port == 0) return false;
    for (PeerId slot = 0; slot < token.players; ++slot) {
        const Peer& peer = peers[slot];
        if (slot == token.slot) continue;
        if (peer.listed == relay.seat.address ||
            3 * (now - peer.heard_ms) > 2 * std::uint64_t{def.relay_silence_ms})
            return true;
    }
    return false;
}

void Endpoint::Impl::poll_relay(RelayLink& relay) {
    if (relay.is_in && now - relay.heard_ms <= def.silence_ms) return;
    Attempt& attempt = relay.attempt;
    if (!attempt.runs || now - attempt.started_ms > attempt_ms)
        attempt = {.nonce = random_u64(), .started_ms = now, .secret = {}, .runs = true};
    else if (now - attempt.tried_ms < retry_ms)
        return;
    attempt.tried_ms = now;
    if (attempt.has_cookie && now - attempt.cookie_ms < cookie_kept_ms) return send_relay_request(relay);
    if (const Space to = push(relay.seat.address, hello_bytes); !to.empty())
        write_hello(to, first_byte(Kind::relay_hello, token.slot), 0, attempt.nonce);
}

void Endpoint::Impl::send_relay_request(const RelayLink& relay) {
    const Space to = push(relay.seat.address, relay_request_bytes);
    if (to.empty()) return;
    write_cookie(to, first_byte(Kind::relay_request, token.slot), relay.attempt.nonce, relay.attempt.cookie);
    std::ranges::copy(relay.seat.pass, to.begin() + cookie_bytes);
    std::ranges::copy(authenticator(relay.seat.key, to.first(relay_request_bytes - tag_bytes)),
                      to.end() - tag_bytes);
}

Endpoint::Impl::Fault Endpoint::Impl::take_from_relay(RelayLink& relay, Bytes datagram) {
    const Cookie answer = read_cookie(datagram);
    if (answer.version != net_version) return NetFault::version;
    Attempt& attempt = relay.attempt;
    if (!attempt.runs || answer.nonce != attempt.nonce) return NetFault::unexpected;
    if (kind_of(datagram[0]) == Kind::relay_cookie) {
        const bool is_first = !attempt.has_cookie;
        attempt.cookie = answer.cookie, attempt.cookie_ms = now, attempt.has_cookie = true;
        if (is_first) send_relay_request(relay);
        return {};
    }
    const Bytes head = datagram.first(relay_accept_bytes - tag_bytes);
    if (!same(authenticator(relay.seat.key, head), datagram.last(tag_bytes)))
        return NetFault::unauthenticated;
    if (!relay.is_in) // before this, no peer could be heard through this relay
        for (Peer& peer : peers)
            if (peer.listed == relay.seat.address) peer.relay_changed_ms = now;
    relay.is_in = true, relay.heard_ms = now, attempt = {};
    return {};
}

/// Changes to the other relay after silence of the peer, if this player has a seat there. A peer that is
/// silent at both is searched for at each in turn.
void Endpoint::Impl::poll_path(PeerId slot) {
    Peer& peer = peers[slot];
    // A handshake takes longer than a packet, and starts again at the other relay.
    const bool is_heard = peer.channel && peer.channel->window.next() > 0;
    const std::uint64_t patience = std::uint64_t{def.relay_silence_ms} * (is_heard ? 1 : 2);
    if (now - std::max(peer.heard_ms, peer.relay_changed_ms) <= patience) return;
    for (const RelayLink& other : relays) {
        if (!other.is_in || other.seat.address == peer.listed) continue;
        peer.listed = other.seat.address, peer.relay_changed_ms = now, peer.attempt = {};
        if (peer.channel) peer.address = peer.listed;
        ++stats.paths_changed;
        return;
    }
}

} // namespace lockstone
