#include "net/relay.h"

#include "base/bytes.h"

namespace lockstone {

using namespace net;

namespace {

constexpr std::size_t packets_waiting_max = 2048;
constexpr std::size_t bytes_waiting_max = packets_waiting_max * 640;
constexpr std::uint64_t sweep_every_ms = 1000;

} // namespace

Relay::Impl::Impl(const NetKey& own_secret, const RelayDef& limits, std::uint64_t now_ms)
    : secret(own_secret), def(limits), now(now_ms), swept_ms(now_ms),
      outgoing(packets_waiting_max, bytes_waiting_max) {}

Relay::Relay(const NetKey& secret, const RelayDef& def, std::uint64_t now_ms)
    : impl(std::make_unique<Impl>(secret, def, now_ms)) {}
Relay::Relay(Relay&&) noexcept = default;
Relay& Relay::operator=(Relay&&) noexcept = default;
Relay::~Relay() = default;

Relay::Impl::Fault Relay::Impl::take(const NetAddress& from, Bytes datagram) {
    if (const Fault fault = length_fault(datagram)) return fault;
    const Kind kind = kind_of(datagram[0]);
    if (kind <= Kind::punch || (kind >= Kind::data && kind <= Kind::challenge_answer))
        return forward(from, datagram);
    if (std::to_integer<std::uint8_t>(datagram[1]) != net_version) return NetFault::version;
    switch (kind) {
    case Kind::relay_hello:
        return take_hello(from, datagram);
    case Kind::relay_request:
        return take_request(from, datagram);
    case Kind::lobby_request:
        return take_lobby_request(from, datagram);
    default:
        return NetFault::unexpected;
    }
}

Relay::Impl::Fault Relay::Impl::take_hello(const NetAddress& from, Bytes datagram) {
    if (!hello_sources.take(from, def.hellos_per_source, now) || !hellos.take(1, def.hellos_per_second, now))
        return NetFault::over_rate;
    const std::uint64_t nonce = read_hello(datagram).nonce;
    const PeerId slot = slot_of(datagram[0]);
    if (const Space to = push(from, cookie_bytes); !to.empty()) {
        write_cookie(to, first_byte(Kind::relay_cookie, slot), nonce,
                     cookies.bake(from, static_cast<std::uint8_t>(slot), nonce, now));
        ++stats.answered;
    }
    return {};
}

Relay::Impl::Fault Relay::Impl::request_fault(const NetAddress& from, Bytes datagram) {
    const Cookie shown = read_cookie(datagram);
    const auto slot = static_cast<std::uint8_t>(slot_of(datagram[0]));
    if (!cookies.is_good(shown.cookie, from, slot, shown.nonce, now)) return NetFault::cookie;
    if (!request_sources.take(from, def.hellos_per_source, now) || !opens.take(1, def.opens_per_second, now))
        return NetFault::over_rate;
    ++stats.opened;
    return {};
}

Relay::Impl::Fault Relay::Impl::take_request(const NetAddress& from, Bytes datagram) {
    if (const Fault fault = request_fault(from, datagram)) return fault;
    // Opened without a check of its expiry, which follows below: so an expired pass counts as `expired`.
    const auto pass = open_pass(datagram.subspan(cookie_bytes, pass_bytes), secret, 0);
    if (!pass || pass->slot != slot_of(datagram[0])) return NetFault::unauthenticated;
    if (!same(authenticator(pass->key, datagram.first(relay_request_bytes - tag_bytes)),
              datagram.last(tag_bytes)))
        return NetFault::unauthenticated;
    if (now >= pass->expires_ms) return NetFault::expired;
    if (const Fault fault = sit_down(*pass, from)) return fault;
    const Space to = push(from, relay_accept_bytes);
    if (to.empty()) return {};
    write_cookie(to, first_byte(Kind::relay_accept, pass->slot), read_cookie(datagram).nonce, 0);
    std::ranges::copy(authenticator(pass->key, to.first(relay_accept_bytes - tag_bytes)),
                      to.end() - tag_bytes);
    return {};
}

Relay::Impl::Fault Relay::Impl::sit_down(const RelayPass& pass, const NetAddress& from) {
    if (!matches.contains(pass.match_id)) {
        const Taken taken = count_taken(
            matches, from, [](const auto& entry) -> const NetAddress& { return entry.second.opened_by; });
        if (!has_place(taken, {def.matches_max, def.matches_per_source, def.matches_per_network}))
            return NetFault::over_rate;
    }
    if (const auto other = seats.find(from); other != seats.end()) {
        if (other->second == std::pair(pass.match_id, pass.slot)) return {};
        stand_up(other);
    }
    RelayedMatch& match = matches[pass.match_id];
    if (match.players == 0) match.players = pass.players, match.opened_by = from;
    if (match.players != pass.players) return NetFault::match;
    Seat& seat = match.seats[pass.slot];
    if (seat.address.port != 0) seats.erase(seat.address);
    seat.address = from, seat.heard_ms = now;
    seats[from] = {pass.match_id, pass.slot};
    return {};
}

/// Frees the seat. The next sweep removes a match without players.
void Relay::Impl::stand_up(std::map<NetAddress, std::pair<std::uint64_t, PeerId>>::iterator seat) {
    const auto [match, slot] = seat->second;
    matches[match].seats[slot] = {};
    seats.erase(seat);
}

Relay::Impl::Fault Relay::Impl::forward(const NetAddress& from, Bytes datagram) {
    const auto found = seats.find(from);
    if (found == seats.end()) return NetFault::stranger;
    const auto [id, slot] = found->second;
    RelayedMatch& match = matches.find(id)->second;
    const PeerId to_slot = slot_of(datagram[0]);
    if (to_slot >= match.players || to_slot == slot) return NetFault::malformed;
    Seat &sender = match.seats[slot], &receiver = match.seats[to_slot];
    sender.heard_ms = now;
    if (!sender.packets.take(1, def.packets_per_second, now) ||
        !sender.bytes.take(datagram.size(), def.bytes_per_second, now))
        return NetFault::over_rate;
    if (receiver.address.port == 0) return NetFault::unexpected;
    const Space to = push(receiver.address, datagram.size());
    if (to.empty()) return {};
    std::ranges::copy(datagram, to.begin());
    to[0] = first_byte(kind_of(datagram[0]), slot);
    ++forwarded;
    return {};
}

void Relay::Impl::sweep() {
    if (now - swept_ms < sweep_every_ms) return;
    swept_ms = now;
    for (auto seat = seats.begin(); seat != seats.end();) {
        const auto next = std::next(seat);
        if (now - matches[seat->second.first].seats[seat->second.second].heard_ms > def.idle_ms)
            stand_up(seat);
        seat = next;
    }
    std::erase_if(matches, [](const auto& entry) {
        return std::ranges::all_of(entry.second.seats,
                                   [](const Seat& seat) { return seat.address.port == 0; });
    });
    close_old_rooms();
}

void Relay::receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms) {
    impl->now = std::max(impl->now, now_ms);
    ++impl->stats.received, impl->stats.bytes_received += datagram.size();
    if (const auto fault = impl->take(from, datagram))
        ++impl->stats.refused[static_cast<std::uint32_t>(*fault)];
}

void Relay::poll(std::uint64_t now_ms) {
    impl->now = std::max(impl->now, now_ms);
    impl->sweep();
}

std::optional<OutgoingDatagram> Relay::next_outgoing() {
    const auto* entry = impl->outgoing.pop();
    if (!entry) return {};
    return OutgoingDatagram{entry->label, impl->outgoing.bytes_of(*entry)};
}

Relay::Counters Relay::counters() const {
    return {impl->forwarded, impl->matches.size(), impl->seats.size(), impl->rooms.size()};
}
const NetStats& Relay::stats() const { return impl->stats; }

} // namespace lockstone
