// The lobby: the first player opens a room, the others enter it by its code, and each gets the public keys
// of all. A player is identified by a public key for this match. Clients repeat requests until they have
// the token, and a repeated request has the same effect.
#include "net/relay.h"

#include "base/bytes.h"

namespace lockstone {

using namespace net;

namespace {

// Without letters and digits that look alike.
constexpr std::string_view letters = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789";
static_assert(letters.size() == 32);

// The largest token (maximum number of players, two relays) must fit into an answer: head and seal, seat,
// keys, relays, and the fields of the answer before the token.
constexpr std::size_t token_bytes_max =
    5 + sealed_extra_bytes + 18 + 1 + 32 + 32 * net_players_max + 2 * (18 + 32 + 2 + pass_bytes);
static_assert(token_bytes_max + 2 + code_letters + 2 <= lobby_answer_plain);

std::string random_code() {
    std::string code;
    for (std::uint64_t chance = random_u64(); code.size() < code_letters; chance >>= 5)
        code += letters[chance % letters.size()];
    return code;
}

} // namespace

Relay::Impl::Fault Relay::Impl::take_lobby_request(const NetAddress& from, Bytes datagram) {
    if (const Fault fault = request_fault(from, datagram)) return fault;
    NetKey who;
    std::ranges::copy(datagram.subspan(cookie_bytes, 32), who.bytes.begin());
    const auto keys = agree(Role::responder, secret, who);
    std::array<std::byte, lobby_request_plain> plain;
    if (!keys || !open_with_nonce(plain, datagram.subspan(lobby_request_head),
                                  datagram.first(lobby_request_head), keys->receive))
        return NetFault::unauthenticated;
    base::ByteReader in(plain, "lobby request");
    const std::uint32_t players = in.u8("players");
    const Bytes asked = in.bytes(code_letters, "code");
    std::string code(reinterpret_cast<const char*>(asked.data()), asked.size());
    if (code[0] == 0) code.clear();
    const Said said = say({from, who, players}, code, keys->send);

    std::vector<std::byte> answer;
    base::ByteWriter out(answer);
    out.u8(static_cast<std::uint8_t>(said.status));
    out.u8(static_cast<std::uint8_t>(said.members));
    code.resize(code_letters);
    out.bytes(std::as_bytes(std::span(code)));
    out.u16(static_cast<std::uint16_t>(said.token.size()));
    out.bytes(said.token);
    answer.resize(lobby_answer_plain);
    const Space to = push(from, packet_bytes_max);
    if (to.empty()) return {};
    write_cookie(to, first_byte(Kind::lobby_answer, 0), read_cookie(datagram).nonce, 0);
    seal_with_nonce(to.subspan(lobby_answer_head), answer, to.first(lobby_answer_head), keys->send);
    return {};
}

Relay::Impl::Said Relay::Impl::say(const Asked& asked, std::string& code, const NetKey& key) {
    if (door != nullptr && code == door_code) {
        const Result<ConnectToken> place = door->let_in(asked.who, now);
        if (!place) return {LobbyStatus::door_full, 0, {}};
        return {LobbyStatus::ready, place->players, seal_token(*place, key)};
    }
    const LobbyStatus status = enter(asked, code);
    if (status > LobbyStatus::ready) return {status, 0, {}};
    const Room& room = rooms[code];
    return {status, static_cast<std::uint32_t>(room.members.size()),
            status == LobbyStatus::ready ? token_for(asked.who, room, key) : std::vector<std::byte>{}};
}

/// Enters the room of `code`. With an empty code it opens a room and sets `code`.
LobbyStatus Relay::Impl::enter(const Asked& asked, std::string& code) {
    const NetKey& who = asked.who;
    if (const auto known = room_of.find(who.bytes); known != room_of.end())
        code = known->second;
    else if (code.empty())
        return open_room(asked, code);
    const auto found = rooms.find(code);
    if (found == rooms.end()) return LobbyStatus::no_such_code;
    Room& room = found->second;
    if (room_of.contains(who.bytes)) room.asked_ms = now; // the request is from a member
    if (std::ranges::find(room.members, who) == room.members.end()) {
        if (room.members.size() == room.players) return LobbyStatus::room_full;
        room.members.push_back(who), room.relay_keys.push_back(random_key());
        room.second_keys.push_back(random_key());
        room_of[who.bytes] = code;
        room.asked_ms = now;
    }
    return room.members.size() == room.players ? LobbyStatus::ready : LobbyStatus::waiting;
}

LobbyStatus Relay::Impl::open_room(const Asked& asked, std::string& code) {
    if (asked.players < 2 || asked.players > net_players_max) return LobbyStatus::bad_request;
    const Taken taken = count_taken(
        rooms, asked.from, [](const auto& entry) -> const NetAddress& { return entry.second.opened_by; });
    if (!has_place(taken, {def.rooms_max, def.rooms_per_source, def.rooms_per_network}))
        return LobbyStatus::lobby_full;
    do code = random_code();
    while (rooms.contains(code) || code == door_code);
    rooms[code] = {asked.players, random_u64(),   now,           now, asked.from,
                   {asked.who},   {random_key()}, {random_key()}};
    room_of[asked.who.bytes] = code;
    return LobbyStatus::waiting;
}

/// The token has neither the secret nor the relay's address: the player has the secret, and sends its
/// requests to that address.
std::vector<std::byte> Relay::Impl::token_for(const NetKey& who, const Room& room, const NetKey& key) const {
    ConnectToken token;
    token.match_id = room.match_id, token.expires_ms = room.opened_ms + def.match_ms;
    token.players = room.players;
    token.slot = static_cast<PeerId>(std::ranges::find(room.members, who) - room.members.begin());
    std::ranges::copy(room.members, token.public_keys.begin());
    token.relay_key = room.relay_keys[token.slot];
    token.pass = seal_pass(
        {token.match_id, room.opened_ms + def.match_ms, token.slot, token.players, token.relay_key}, secret);
    if (def.second.port != 0) {
        token.second_relay.address = def.second, token.second_relay.key = room.second_keys[token.slot];
        token.second_relay.pass = seal_pass({token.match_id, room.opened_ms + def.match_ms, token.slot,
                                             token.players, token.second_relay.key},
                                            def.second_secret);
    }
    return seal_token(token, key);
}

const std::string& Relay::show(WatchDoor& door) {
    impl->door = &door;
    do impl->door_code = random_code();
    while (impl->rooms.contains(impl->door_code));
    return impl->door_code;
}

void Relay::Impl::close_old_rooms() {
    const auto is_old = [&](const Room& room) {
        return now - room.opened_ms > def.room_ms || now - room.asked_ms > def.room_idle_ms;
    };
    std::erase_if(room_of, [&](const auto& entry) { return is_old(rooms.find(entry.second)->second); });
    std::erase_if(rooms, [&](const auto& entry) { return is_old(entry.second); });
}

} // namespace lockstone
