// WatchDoor: one address for many spectators, with an endpoint for each.
//
// A hello or request belongs to the place whose token has its match id; another datagram belongs to the
// place with the proven address of its sender. All others are dropped without decryption, so a sender
// without a token gets no answer.
#include "net/endpoint.h"

#include "base/text.h"

#include <map>

namespace lockstone {

using namespace net;

namespace {

constexpr std::uint32_t places_max = 4096, packets_waiting = 24;
constexpr PeerId door_slot = 0, watcher_slot = 1;
constexpr std::uint64_t sweep_every_ms = 1000;

struct Place {
    std::optional<Endpoint> endpoint = {}; ///< none: the place is free
    std::uint64_t match_id = 0;            ///< of the token
    NetKey own = {}, theirs = {};          ///< public keys of the door and the spectator
    std::uint32_t match = 0;               ///< low half of the token's match id; unique
    std::uint64_t heard_ms = 0, delivered = 0;
    NetAddress address = {}; ///< last proven address of the spectator; port 0: none
    bool sends = false;      ///< the place is in `sending`
    bool gives = false;      ///< the place is in `giving`
};

} // namespace

struct WatchDoor::Impl {
    WatchDoorDef def;
    std::uint64_t now, swept_ms;
    std::vector<Place> places;
    std::map<std::uint32_t, PeerId> by_match;
    std::map<NetAddress, PeerId> by_address;
    std::vector<PeerId> sending, giving;
    std::uint64_t strangers = 0;

    ConnectToken token_of(const Place& place) const;
    PeerId place_of(const NetAddress& from, Bytes datagram) const;
    void set_address(PeerId at, const NetAddress& proven);
    void ask(PeerId at);
    void clear(Place& place);
    void sweep();
};

WatchDoor::WatchDoor(std::unique_ptr<Impl> made) : impl(std::move(made)) {}
WatchDoor::WatchDoor(WatchDoor&&) noexcept = default;
WatchDoor& WatchDoor::operator=(WatchDoor&&) noexcept = default;
WatchDoor::~WatchDoor() = default;

Result<WatchDoor> WatchDoor::create(const WatchDoorDef& def, std::uint64_t now_ms) {
    if (def.address.port == 0) return Error{"WatchDoorDef::address has no port"};
    if (def.watchers_max == 0 || def.watchers_max > places_max)
        return Error{
            base::join("WatchDoorDef::watchers_max is ", def.watchers_max, ", must be 1..", places_max)};
    if (now_ms >= def.expires_ms) return Error{"WatchDoorDef::expires_ms is over"};
    auto made = std::make_unique<Impl>();
    made->def = def, made->now = made->swept_ms = now_ms;
    made->places.resize(def.watchers_max);
    return WatchDoor(std::move(made));
}

Result<ConnectToken> WatchDoor::let_in(std::uint64_t now_ms) {
    const NetKey secret = random_key();
    Result<ConnectToken> token = let_in(public_key_of(secret), now_ms);
    if (token) token->secret = secret;
    return token;
}

Result<ConnectToken> WatchDoor::let_in(const NetKey& public_key, std::uint64_t now_ms) {
    Impl& all = *impl;
    all.now = std::max(all.now, now_ms);
    const auto known = std::ranges::find_if(
        all.places, [&](const Place& place) { return place.endpoint && place.theirs == public_key; });
    if (known != all.places.end()) return all.token_of(*known);
    const auto free = std::ranges::find_if(all.places, [](const Place& place) { return !place.endpoint; });
    if (free == all.places.end())
        return Error{base::join("all ", all.places.size(), " places for those who watch are taken")};
    ConnectToken token;
    do token.match_id = random_u64();
    while (all.by_match.contains(static_cast<std::uint32_t>(token.match_id)));
    const NetKey own = random_key();
    token = all.token_of({.match_id = token.match_id, .own = public_key_of(own), .theirs = public_key});
    token.slot = door_slot, token.secret = own;
    Result<Endpoint> made = Endpoint::create(token,
                                             {.packets_per_second = all.def.packets_per_second,
                                              .bytes_per_second = all.def.bytes_per_second,
                                              .packets_waiting_max = packets_waiting},
                                             all.now);
    if (!made) return made.error();
    free->endpoint.emplace(std::move(*made));
    free->match_id = token.match_id, free->own = token.public_keys[door_slot], free->theirs = public_key;
    free->match = static_cast<std::uint32_t>(token.match_id);
    free->heard_ms = all.now;
    all.by_match[free->match] = static_cast<PeerId>(free - all.places.begin());
    return all.token_of(*free);
}

/// The spectator's token, without the secret.
ConnectToken WatchDoor::Impl::token_of(const Place& place) const {
    ConnectToken token;
    token.match_id = place.match_id, token.expires_ms = def.expires_ms, token.players = 2;
    token.public_keys[door_slot] = place.own, token.public_keys[watcher_slot] = place.theirs;
    token.addresses[door_slot] = def.address;
    token.slot = watcher_slot;
    return token;
}

/// The place of a datagram; places.size(): none.
PeerId WatchDoor::Impl::place_of(const NetAddress& from, Bytes datagram) const {
    const auto nobody = static_cast<PeerId>(places.size());
    if (length_fault(datagram) || slot_of(datagram[0]) != watcher_slot) return nobody;
    const Kind kind = kind_of(datagram[0]);
    if (kind == Kind::hello || kind == Kind::request) {
        const auto found = by_match.find(read_hello(datagram).match);
        return found == by_match.end() ? nobody : found->second;
    }
    const auto found = by_address.find(from);
    return found == by_address.end() ? nobody : found->second;
}

/// Sets the proven address of a place. Another place with this address loses it.
void WatchDoor::Impl::set_address(PeerId at, const NetAddress& proven) {
    Place& place = places[at];
    if (proven == place.address) return;
    if (place.address.port != 0) by_address.erase(place.address);
    if (const auto other = by_address.find(proven); other != by_address.end())
        places[other->second].address = {};
    place.address = proven;
    by_address[proven] = at;
}

void WatchDoor::Impl::ask(PeerId at) {
    Place& place = places[at];
    if (!std::exchange(place.sends, true)) sending.push_back(at);
    const std::uint64_t delivered = place.endpoint->stats().delivered;
    if (std::exchange(place.delivered, delivered) == delivered) return;
    place.heard_ms = now;
    if (!std::exchange(place.gives, true)) giving.push_back(at);
}

void WatchDoor::Impl::clear(Place& place) {
    by_match.erase(place.match);
    if (place.address.port != 0) by_address.erase(place.address);
    const bool sends = place.sends, gives = place.gives;
    place = {};
    place.sends = sends, place.gives = gives; // the place is still in these lists
}

void WatchDoor::Impl::sweep() {
    if (now - swept_ms < sweep_every_ms) return;
    swept_ms = now;
    for (Place& place : places)
        if (place.endpoint && now - place.heard_ms > def.idle_ms) clear(place);
}

void WatchDoor::receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms) {
    Impl& all = *impl;
    all.now = std::max(all.now, now_ms);
    const PeerId at = all.place_of(from, datagram);
    if (at == all.places.size()) {
        ++all.strangers;
        return;
    }
    Endpoint& endpoint = *all.places[at].endpoint;
    const std::uint64_t refused = endpoint.stats().refused_in_all();
    endpoint.receive(from, datagram, all.now);
    // An accepted request has proven the token's key and, by its cookie, the address.
    if (kind_of(datagram[0]) == Kind::request && endpoint.stats().refused_in_all() == refused)
        all.set_address(at, from);
    all.ask(at);
}

void WatchDoor::poll(std::uint64_t now_ms) {
    Impl& all = *impl;
    all.now = std::max(all.now, now_ms);
    all.sweep();
    for (PeerId at = 0; at < all.places.size(); ++at) {
        if (!all.places[at].endpoint) continue;
        all.places[at].endpoint->poll(all.now);
        all.ask(at);
    }
}

void WatchDoor::send(PeerId watcher, std::span<const std::byte> packet, std::uint64_t now_ms) {
    Impl& all = *impl;
    all.now = std::max(all.now, now_ms);
    if (watcher >= all.places.size() || !all.places[watcher].endpoint) return;
    all.places[watcher].endpoint->send(watcher_slot, packet, all.now);
    all.ask(watcher);
}

std::optional<Datagram> WatchDoor::next_packet() {
    for (std::vector<PeerId>& all = impl->giving; !all.empty(); all.pop_back()) {
        Place& place = impl->places[all.back()];
        if (place.endpoint)
            if (const auto packet = place.endpoint->next_packet()) return Datagram{all.back(), packet->bytes};
        place.gives = false;
    }
    return {};
}

std::optional<OutgoingDatagram> WatchDoor::next_outgoing() {
    for (std::vector<PeerId>& all = impl->sending; !all.empty(); all.pop_back()) {
        Place& place = impl->places[all.back()];
        if (place.endpoint)
            if (const auto out = place.endpoint->next_outgoing()) return out;
        place.sends = false;
    }
    return {};
}

WatchDoor::Counters WatchDoor::counters() const {
    Counters counters;
    for (const Place& place : impl->places) {
        counters.let_in += place.endpoint ? 1u : 0u;
        counters.connected += place.endpoint && place.endpoint->is_connected(watcher_slot) ? 1u : 0u;
    }
    counters.strangers = impl->strangers;
    return counters;
}

} // namespace lockstone
