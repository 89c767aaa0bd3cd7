// The handshake: two players with each other's public keys agree on keys of a connection.
//
//   initiator (the higher slot)                     responder
//   hello    nonce                             ->   stores nothing
//                                              <-   cookie   bound to address, slot and nonce; shorter than the hello
//   request  cookie, sealed ephemeral key      ->   checks the cookie, then decrypts: pending
//                                              <-   accept   sealed ephemeral key; shorter than the request
//   any packet with the new keys               ->   the pending channel becomes the channel
//
// Sources: the cookie: RFC 2522 and RFC 6347, 4.2.1. The two Diffie-Hellman agreements, one of static keys for
// authentication and one of ephemeral keys for each attempt: the pattern KK of the Noise protocol framework,
// revision 34.
#include "net/endpoint.h"

#include "base/bytes.h"

namespace lockstone {

using namespace net;

namespace {

constexpr std::uint64_t retry_ms = 250, attempt_ms = 10'000, cookie_kept_ms = 3000, pending_ms = 10'000,
                        punch_ms = 500;
constexpr std::uint32_t requests_per_second = 4;

/// Derives the key of each direction from both agreements, the match and the version.
DirectedKeys session_keys(const DirectedKeys& ephemeral, const DirectedKeys& pair, std::uint64_t match_id) {
    const auto mixed = [&](const NetKey& one, const NetKey& other) {
        std::vector<std::byte> context;
        base::ByteWriter to(context);
        to.bytes(other.bytes);
        to.u64(match_id);
        to.u8(net_version);
        return derived(one, context);
    };
    return {mixed(ephemeral.send, pair.send), mixed(ephemeral.receive, pair.receive)};
}

/// The data that is authenticated with the sealed key: the head as the receiver gets it, and in an accept
/// the initiator's key.
std::vector<std::byte> header_of(std::byte first, Bytes head, Bytes initiator_key = {}) {
    std::vector<std::byte> header;
    base::ByteWriter to(header);
    to.bytes(Bytes(&first, 1));
    to.bytes(head.subspan(1));
    to.bytes(initiator_key);
    return header;
}

constexpr std::size_t request_head = request_bytes - 32 - sealed_extra_bytes;
constexpr std::size_t accept_head = accept_bytes - 32 - sealed_extra_bytes;

} // namespace

Endpoint::Impl::Fault Endpoint::Impl::handshake_fault(Bytes datagram) const {
    const Kind kind = kind_of(datagram[0]);
    const Hello hello = read_hello(datagram);
    if (hello.version != net_version) return NetFault::version;
    const bool names_match = kind == Kind::hello || kind == Kind::request;
    if (names_match && hello.match != match_low()) return NetFault::match;
    if (names_match == initiates(slot_of(datagram[0]))) return NetFault::unexpected;
    if (now >= token.expires_ms) return NetFault::expired;
    return {};
}

Endpoint::Impl::Fault Endpoint::Impl::take_handshake(PeerId slot, const NetAddress& from, Bytes datagram) {
    if (datagram.size() < cookie_bytes) return NetFault::truncated;
    if (const Fault fault = handshake_fault(datagram)) return fault;
    switch (kind_of(datagram[0])) {
    case Kind::hello:
        return take_hello(slot, from, datagram);
    case Kind::cookie:
        return take_cookie(slot, from, datagram);
    case Kind::request:
        return take_request(slot, from, datagram);
    default:
        return take_accept(slot, from, datagram);
    }
}

Endpoint::Impl::Fault Endpoint::Impl::take_hello(PeerId slot, const NetAddress& from, Bytes datagram) {
    // A sender at the address in the token has its own rate, which strangers cannot exhaust.
    const bool may = from == peers[slot].listed || relay_at(from)
                         ? peers[slot].hellos.take(1, def.hellos_per_source, now)
                         : hello_sources.take(from, def.hellos_per_source, now) &&
                               hellos.take(1, def.hellos_per_second, now);
    if (!may) return NetFault::over_rate;
    if (!peers[slot].channel && relay_at(from))
        peers[slot].relay_changed_ms = now; // a handshake begins at this relay
    const std::uint64_t nonce = read_hello(datagram).nonce;
    if (const Space to = push(from, cookie_bytes); !to.empty()) {
        write_cookie(to, first_to(Kind::cookie, slot), nonce,
                     cookies.bake(from, static_cast<std::uint8_t>(slot), nonce, now));
        ++stats.answered;
    }
    return {};
}

Endpoint::Impl::Fault Endpoint::Impl::take_cookie(PeerId slot, const NetAddress& from, Bytes datagram) {
    Attempt& attempt = peers[slot].attempt;
    const Cookie cookie = read_cookie(datagram);
    if (!attempt.runs || cookie.nonce != attempt.nonce || from != peers[slot].listed)
        return NetFault::unexpected;
    const bool is_first = !attempt.has_cookie;
    if (is_first) peers[slot].relay_changed_ms = now; // the path through this relay works
    attempt.cookie = cookie.cookie, attempt.cookie_ms = now, attempt.has_cookie = true;
    if (is_first) send_request(slot);
    return {};
}

void Endpoint::Impl::send_request(PeerId slot) {
    Peer& peer = peers[slot];
    const Space to = push(peer.listed, request_bytes);
    if (to.empty()) return;
    write_hello(to.first(request_head), first_to(Kind::request, slot), match_low(), peer.attempt.nonce);
    base::store_little_endian(peer.attempt.cookie, &to[request_head - 8]);
    const auto header = header_of(first_byte(Kind::request, token.slot), to.first(request_head));
    seal_with_nonce(to.subspan(request_head), public_key_of(peer.attempt.secret).bytes, header,
                    peer.pair.send);
}

Endpoint::Impl::Fault Endpoint::Impl::take_request(PeerId slot, const NetAddress& from, Bytes datagram) {
    Peer& peer = peers[slot];
    const std::uint64_t nonce = read_hello(datagram).nonce;
    const auto cookie = base::load_little_endian<std::uint64_t>(&datagram[request_head - 8]);
    if (!cookies.is_good(cookie, from, static_cast<std::uint8_t>(slot), nonce, now)) return NetFault::cookie;
    if (!may_open()) return NetFault::over_rate;
    NetKey theirs;
    if (!open_with_nonce(theirs.bytes, datagram.subspan(request_head),
                         header_of(datagram[0], datagram.first(request_head)), peer.pair.receive))
        return from == peer.listed ? NetFault::unauthenticated : NetFault::spoofed;
    if (peer.channel && peer.channel_nonce == nonce) return NetFault::replayed;
    if (!peer.requests.take(1, requests_per_second, now)) return NetFault::over_rate;
    answer_request(slot, from, nonce, theirs);
    return {};
}

void Endpoint::Impl::answer_request(PeerId slot, const NetAddress& from, std::uint64_t nonce,
                                    const NetKey& theirs) {
    Peer& peer = peers[slot];
    // A repeated request gets the same answer again, because the first answer may still arrive.
    if (!peer.pending || peer.pending->nonce != nonce) {
        const NetKey secret = random_key();
        const auto ephemeral = agree(Role::responder, secret, theirs);
        if (!ephemeral) return;
        Pending made{{session_keys(*ephemeral, peer.pair, token.match_id), 0, {}}, nonce, now, from, {}};
        base::store_little_endian(nonce, &made.accept[2]);
        made.accept[0] = first_to(Kind::accept, slot), made.accept[1] = std::byte{net_version};
        const Space accept(made.accept);
        seal_with_nonce(
            accept.subspan(accept_head), public_key_of(secret).bytes,
            header_of(first_byte(Kind::accept, token.slot), accept.first(accept_head), theirs.bytes),
            peer.pair.send);
        peer.pending = made;
    }
    peer.pending->from = from;
    if (const Space to = push(from, accept_bytes); !to.empty())
        std::ranges::copy(peer.pending->accept, to.begin());
}

Endpoint::Impl::Fault Endpoint::Impl::take_accept(PeerId slot, const NetAddress& from, Bytes datagram) {
    Peer& peer = peers[slot];
    Attempt& attempt = peer.attempt;
    if (!attempt.runs || read_cookie(datagram).nonce != attempt.nonce || from != peer.listed)
        return NetFault::unexpected;
    if (!may_open()) return NetFault::over_rate;
    NetKey theirs;
    const NetKey own_public = public_key_of(attempt.secret);
    if (!open_with_nonce(theirs.bytes, datagram.subspan(accept_head),
                         header_of(datagram[0], datagram.first(accept_head), own_public.bytes),
                         peer.pair.receive))
        return NetFault::unauthenticated;
    const auto ephemeral = agree(Role::initiator, attempt.secret, theirs);
    if (!ephemeral) return NetFault::malformed;
    peer.channel = Channel{session_keys(*ephemeral, peer.pair, token.match_id), 0, {}};
    peer.address = from, peer.heard_ms = now, attempt = {};
    send_control(slot, from, Kind::keep_alive, 0); // proves that this player has the keys
    return {};
}

void Endpoint::Impl::poll_handshake(PeerId slot) {
    Peer& peer = peers[slot];
    if (peer.pending && now - peer.pending->since_ms > pending_ms) peer.pending.reset();
    const bool is_wanted = !peer.channel || now - peer.heard_ms > def.silence_ms;
    if (!is_wanted || now >= token.expires_ms || peer.listed.port == 0) return;
    if (!initiates(slot)) {
        if (has_relay() || now - peer.punched_ms < punch_ms) return;
        peer.punched_ms = now;
        if (const Space to = push(peer.listed, 1); !to.empty()) to[0] = first_to(Kind::punch, slot);
        return;
    }
    Attempt& attempt = peer.attempt;
    if (!attempt.runs || now - attempt.started_ms > attempt_ms)
        attempt = {.nonce = random_u64(), .started_ms = now, .secret = random_key(), .runs = true};
    else if (now - attempt.tried_ms < retry_ms)
        return;
    attempt.tried_ms = now;
    if (attempt.has_cookie && now - attempt.cookie_ms < cookie_kept_ms) return send_request(slot);
    if (const Space to = push(peer.listed, hello_bytes); !to.empty())
        write_hello(to, first_to(Kind::hello, slot), match_low(), attempt.nonce);
}

} // namespace lockstone
