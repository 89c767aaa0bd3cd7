// Encrypted packets between two players: first byte, low 16 bits of the number, ciphertext, tag. And
// address changes: if an authentic packet, newer than all others, comes from a new address, a challenge
// goes to that address, and its answer must come from there.
#include "net/endpoint.h"

#include "base/bytes.h"

namespace lockstone {

using namespace net;

namespace {

constexpr std::uint64_t challenge_every_ms = 250, challenge_good_ms = 4000;

} // namespace

void Endpoint::Impl::send_sealed(PeerId slot, const NetAddress& to, Kind kind, Bytes plain) {
    Peer& peer = peers[slot];
    const Space datagram = push(to, plain.size() + net_overhead_bytes);
    if (datagram.empty()) return;
    const std::byte header = first_byte(kind, token.slot);
    const std::uint64_t number = peer.channel->sent++;
    datagram[0] = first_to(kind, slot);
    base::store_little_endian(static_cast<std::uint16_t>(number), &datagram[1]);
    seal(datagram.subspan(data_head_bytes), plain, Bytes(&header, 1), number, peer.channel->keys.send);
    peer.sent_ms = now;
}

void Endpoint::Impl::send_control(PeerId slot, const NetAddress& to, Kind kind, std::uint64_t value) {
    std::array<std::byte, control_bytes> plain;
    base::store_little_endian(value, plain.data());
    send_sealed(slot, to, kind, plain);
}

Endpoint::Impl::Fault Endpoint::Impl::open(Channel& channel, Bytes datagram, Space plain,
                                           std::uint64_t& number) {
    number = channel.window.restored(base::load_little_endian<std::uint16_t>(&datagram[1]));
    if (!channel.window.is_fresh(number)) return NetFault::replayed;
    if (!may_open()) return NetFault::over_rate;
    if (!net::open(plain, datagram.subspan(data_head_bytes), datagram.first(1), number, channel.keys.receive))
        return NetFault::unauthenticated;
    channel.window.mark(number);
    return {};
}

/// Decrypts with the present keys, else with those of a handshake that waits for its first packet.
Endpoint::Impl::Fault Endpoint::Impl::open_any(Peer& peer, Bytes datagram, Space plain,
                                               std::uint64_t& number) {
    Fault fault = NetFault::unexpected; // no keys yet
    if (peer.channel) fault = open(*peer.channel, datagram, plain, number);
    if (!fault || !peer.pending) return fault;
    if (const Fault other = open(peer.pending->channel, datagram, plain, number))
        return peer.channel ? fault : other;
    peer.channel = peer.pending->channel, peer.channel_nonce = peer.pending->nonce;
    // The cookie has proven the address of the request, and no other one.
    peer.address = peer.pending->from;
    if (has_relay()) peer.listed = peer.address;
    peer.pending.reset();
    return {};
}

Endpoint::Impl::Fault Endpoint::Impl::take_sealed(PeerId slot, const NetAddress& from, Bytes datagram) {
    Peer& peer = peers[slot];
    std::array<std::byte, packet_bytes_max> space;
    const Space plain = Space(space).first(datagram.size() - net_overhead_bytes);
    std::uint64_t number = 0;
    if (const Fault fault = open_any(peer, datagram, plain, number))
        return fault == NetFault::unauthenticated && from != peer.address ? NetFault::spoofed : fault;
    peer.heard_ms = now;
    if (RelayLink* relay = relay_at(from)) relay->heard_ms = now;
    const bool is_newest = number + 1 == peer.channel->window.next();
    if (!peer.packets.take(1, def.packets_per_second, now)) return NetFault::over_rate;
    if (is_newest && from != peer.address) judge_path(slot, from, datagram.size());
    return apply(slot, from, kind_of(datagram[0]), plain);
}

Endpoint::Impl::Fault Endpoint::Impl::apply(PeerId slot, const NetAddress& from, Kind kind, Bytes plain) {
    if (kind == Kind::data) {
        ++(delivered.push_copy(slot, plain) ? stats.delivered : stats.queue_full);
        return {};
    }
    const auto value = base::load_little_endian<std::uint64_t>(plain.data());
    if (kind == Kind::challenge) send_control(slot, peers[slot].address, Kind::challenge_answer, value);
    if (kind == Kind::challenge_answer) return prove_path(slot, from, value);
    return {};
}

/// Sends a challenge, never longer than the packet that causes it: so a replayed packet causes no
/// amplification.
void Endpoint::Impl::judge_path(PeerId slot, const NetAddress& from, std::size_t size) {
    Peer& peer = peers[slot];
    if (size < net_overhead_bytes + control_bytes) return;
    if (peer.challenged_ms != 0 && now - peer.challenged_ms < challenge_every_ms) return;
    peer.candidate = from, peer.challenge = random_u64(), peer.challenged_ms = now;
    send_control(slot, from, Kind::challenge, peer.challenge);
}

Endpoint::Impl::Fault Endpoint::Impl::prove_path(PeerId slot, const NetAddress& from, std::uint64_t answer) {
    Peer& peer = peers[slot];
    const bool is_waited_for = peer.candidate.port != 0 && now - peer.challenged_ms <= challenge_good_ms;
    if (!is_waited_for || from != peer.candidate || answer != peer.challenge) return NetFault::unexpected;
    peer.address = from, peer.candidate = {};
    if (has_relay()) peer.listed = from;
    ++stats.paths_changed;
    return {};
}

void Endpoint::Impl::poll_keep_alive(PeerId slot) {
    Peer& peer = peers[slot];
    if (peer.channel && now - peer.sent_ms >= def.keep_alive_ms)
        send_control(slot, peer.address, Kind::keep_alive, 0);
}

} // namespace lockstone
