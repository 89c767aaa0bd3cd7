#include "net/endpoint.h"

#include "base/assert.h"

namespace lockstone {

using namespace net;

namespace {

constexpr std::size_t bytes_of_one_waiting = 640, one_packet_waiting = net_datagram_bytes_max;
constexpr std::size_t bytes_waiting(const EndpointDef& def) {
    return std::max(def.packets_waiting_max * bytes_of_one_waiting, 4 * one_packet_waiting);
}

constexpr std::uint32_t packets_waiting_least = 8;

Status check(const ConnectToken& token, std::uint64_t now_ms) {
    if (token.players < 2 || token.players > net_players_max)
        return Error{
            base::join("ConnectToken::players is ", token.players, ", must be 2..", net_players_max)};
    if (token.slot >= token.players)
        return Error{base::join("ConnectToken::slot is ", token.slot, " of ", token.players, " players")};
    if (public_key_of(token.secret) != token.public_keys[token.slot])
        return Error{"ConnectToken::secret does not belong to this slot's public key"};
    if (token.relay.port != 0 && token.pass.size() != pass_bytes)
        return Error{
            base::join("ConnectToken::pass has ", token.pass.size(), " bytes, a pass has ", pass_bytes)};
    const RelaySeat& second = token.second_relay;
    if (second.address.port != 0 && (token.relay.port == 0 || second.address == token.relay))
        return Error{"ConnectToken::second_relay needs a first one, at another address"};
    if (second.address.port != 0 && second.pass.size() != pass_bytes)
        return Error{base::join("ConnectToken::second_relay has a pass of ", second.pass.size(),
                                " bytes, a pass has ", pass_bytes)};
    if (now_ms >= token.expires_ms) return Error{"the connect token has expired"};
    return {};
}

} // namespace

const char* name_of(NetFault fault) {
    constexpr const char* names[] = {"truncated", "oversized", "malformed", "version",         "match",
                                     "stranger",  "cookie",    "spoofed",   "unauthenticated", "replayed",
                                     "expired",   "over rate", "unexpected"};
    static_assert(std::size(names) == net_fault_count);
    LOCKSTONE_ASSERT(static_cast<std::uint32_t>(fault) < net_fault_count, static_cast<std::uint32_t>(fault));
    return names[static_cast<std::uint32_t>(fault)];
}

std::uint64_t NetStats::refused_in_all() const {
    std::uint64_t all = 0;
    for (const std::uint64_t count : refused) all += count;
    return all;
}

Endpoint::Impl::Impl(const ConnectToken& of, const EndpointDef& limits, std::uint64_t now_ms)
    : token(of), def(limits), now(now_ms), outgoing(limits.packets_waiting_max, bytes_waiting(limits)),
      delivered(limits.packets_waiting_max, bytes_waiting(limits)) {
    relays[0].seat = {token.relay, token.relay_key, token.pass};
    relays[1].seat = token.second_relay;
    for (Peer& peer : peers) peer.heard_ms = peer.relay_changed_ms = now;
}

Result<Endpoint> Endpoint::create(const ConnectToken& token, const EndpointDef& def, std::uint64_t now_ms) {
    if (Status s = check(token, now_ms); !s) return s.error();
    if (def.packets_waiting_max < packets_waiting_least)
        return Error{base::join("EndpointDef::packets_waiting_max is ", def.packets_waiting_max,
                                ", at least ", packets_waiting_least)};
    auto made = std::make_unique<Impl>(token, def, now_ms);
    for (PeerId slot = 0; slot < token.players; ++slot) {
        if (slot == token.slot) continue;
        const Role role = made->initiates(slot) ? Role::initiator : Role::responder;
        const auto pair = agree(role, token.secret, token.public_keys[slot]);
        if (!pair)
            return Error{base::join("the public key of slot ", slot, " is one that no secret belongs to")};
        made->peers[slot].pair = *pair;
        made->peers[slot].listed = made->has_relay() ? token.relay : token.addresses[slot];
    }
    return Endpoint(std::move(made));
}

Endpoint::Endpoint(std::unique_ptr<Impl> made) : impl(std::move(made)) {}
Endpoint::Endpoint(Endpoint&&) noexcept = default;
Endpoint& Endpoint::operator=(Endpoint&&) noexcept = default;
Endpoint::~Endpoint() = default;

bool Endpoint::Impl::may_open() {
    if (!opens.take(1, def.opens_per_second, now)) return false;
    ++stats.opened;
    return true;
}

Endpoint::Impl::Fault Endpoint::Impl::take(const NetAddress& from, Bytes datagram) {
    if (const Fault fault = length_fault(datagram)) return fault;
    const Kind kind = kind_of(datagram[0]);
    const PeerId slot = slot_of(datagram[0]);
    RelayLink* relay = relay_at(from);
    if (has_relay() && relay == nullptr) return NetFault::stranger;
    if (kind == Kind::relay_cookie || kind == Kind::relay_accept)
        return relay ? take_from_relay(*relay, datagram) : Fault(NetFault::stranger);
    if (slot >= token.players || slot == token.slot) return NetFault::stranger;
    if (kind == Kind::punch) return {}; // its only purpose is to open the path through the sender's router
    if (kind <= Kind::accept) return take_handshake(slot, from, datagram);
    if (kind >= Kind::data && kind <= Kind::challenge_answer) return take_sealed(slot, from, datagram);
    return NetFault::unexpected;
}

void Endpoint::receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms) {
    impl->advance(now_ms);
    ++impl->stats.received, impl->stats.bytes_received += datagram.size();
    if (const auto fault = impl->take(from, datagram))
        ++impl->stats.refused[static_cast<std::uint32_t>(*fault)];
}

void Endpoint::poll(std::uint64_t now_ms) {
    impl->advance(now_ms);
    for (RelayLink& relay : impl->relays)
        if (impl->is_missed(relay)) impl->poll_relay(relay);
    for (PeerId slot = 0; slot < impl->token.players; ++slot) {
        if (slot == impl->token.slot) continue;
        impl->poll_path(slot);
        if (const RelayLink* relay = impl->relay_at(impl->peers[slot].listed); relay && !relay->is_in)
            continue;
        impl->poll_handshake(slot);
        impl->poll_keep_alive(slot);
    }
}

void Endpoint::send(PeerId to, std::span<const std::byte> packet, std::uint64_t now_ms) {
    impl->advance(now_ms);
    Peer* peer = to < impl->token.players ? &impl->peers[to] : nullptr;
    const bool fits =
        peer && peer->channel && packet.size() <= packet_bytes_max &&
        peer->bytes.take(packet.size() + net_overhead_bytes, impl->def.bytes_per_second, impl->now);
    if (!fits)
        ++impl->stats.over_budget;
    else
        impl->send_sealed(to, peer->address, Kind::data, packet);
}

std::optional<Datagram> Endpoint::next_packet() {
    const auto* entry = impl->delivered.pop();
    if (!entry) return {};
    return Datagram{entry->label, impl->delivered.bytes_of(*entry)};
}

std::optional<OutgoingDatagram> Endpoint::next_outgoing() {
    const auto* entry = impl->outgoing.pop();
    if (!entry) return {};
    return OutgoingDatagram{entry->label, impl->outgoing.bytes_of(*entry)};
}

bool Endpoint::is_connected(PeerId peer) const {
    return peer < impl->token.players && impl->peers[peer].channel;
}
bool Endpoint::is_relayed() const { return impl->relays[0].is_in || impl->relays[1].is_in; }
NetAddress Endpoint::address_of(PeerId peer) const {
    return peer < impl->token.players ? impl->peers[peer].address : NetAddress{};
}
const NetStats& Endpoint::stats() const { return impl->stats; }

} // namespace lockstone
