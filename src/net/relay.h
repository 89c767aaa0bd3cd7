// The state of a relay. relay.cpp assigns seats and forwards, lobby.cpp handles rooms.
#pragma once

#include "net/cookie.h"
#include "net/limits.h"
#include "net/packet.h"
#include "net/packet_queue.h"

#include <map>

namespace lockstone::net {

/// The seat of a player: a valid pass has arrived from a proven address.
struct Seat {
    NetAddress address; ///< port 0: the seat is free
    std::uint64_t heard_ms = 0;
    Bucket packets, bytes;
};

/// A match with at least one player at the relay, until the next sweep finds it empty.
struct RelayedMatch {
    std::uint32_t players = 0;
    NetAddress opened_by = {};                 ///< by its first player; counts for the quota of this address
    std::array<Seat, net_players_max> seats{}; ///< [slot]
};

/// A room of the lobby: players meet in it before a match.
struct Room {
    std::uint32_t players = 0;
    std::uint64_t match_id = 0, opened_ms = 0;
    std::uint64_t asked_ms = 0;      ///< time of the last request of a member [ms]
    NetAddress opened_by = {};       ///< counts for the quota of this address
    std::vector<NetKey> members;     ///< [slot] public keys
    std::vector<NetKey> relay_keys;  ///< [slot]
    std::vector<NetKey> second_keys; ///< [slot] for the second relay
};

/// Status of a lobby answer. The other fields of the answer are valid only with `waiting` and `ready`.
enum class LobbyStatus : std::uint8_t {
    waiting,
    ready,
    no_such_code,
    room_full,
    lobby_full,
    bad_request,
    door_full
};

// The formats of the lobby (README.md). Requests and answers have equal lengths: so an answer never
// amplifies a request, and its length reveals nothing.
inline constexpr std::size_t code_letters = 8;
inline constexpr std::size_t lobby_request_head = 18 + 32, lobby_answer_head = 10;
inline constexpr std::size_t lobby_request_plain = packet_bytes_max - lobby_request_head - sealed_extra_bytes;
inline constexpr std::size_t lobby_answer_plain = packet_bytes_max - lobby_answer_head - sealed_extra_bytes;

} // namespace lockstone::net

namespace lockstone {

struct Relay::Impl {
    using Fault = std::optional<NetFault>;
    Impl(const NetKey& own_secret, const RelayDef& limits, std::uint64_t now_ms);

    NetKey secret;
    RelayDef def;
    std::uint64_t now, swept_ms;
    net::CookieJar cookies;
    net::SourceLimit hello_sources, request_sources;
    net::Bucket hellos, opens;
    std::map<std::uint64_t, net::RelayedMatch> matches;           ///< by match id
    std::map<NetAddress, std::pair<std::uint64_t, PeerId>> seats; ///< match and slot by address
    std::map<std::string, net::Room> rooms;                       ///< by code
    std::map<std::array<std::byte, 32>, std::string> room_of;     ///< by a member's public key
    WatchDoor* door = nullptr; ///< door for spectators, not owned; null: none
    std::string door_code;     ///< code of the door
    net::PacketQueue<NetAddress> outgoing;
    std::uint64_t forwarded = 0;
    NetStats stats;

    net::Space push(const NetAddress& to, std::size_t size) {
        return net::push_counted(outgoing, stats, to, size);
    }
    Fault take(const NetAddress& from, net::Bytes datagram);
    Fault take_hello(const NetAddress& from, net::Bytes datagram);
    /// Checks of a request before any decryption: cookie and rates. Empty: passed.
    Fault request_fault(const NetAddress& from, net::Bytes datagram);
    Fault take_request(const NetAddress& from, net::Bytes datagram);
    Fault sit_down(const RelayPass& pass, const NetAddress& from);
    void stand_up(std::map<NetAddress, std::pair<std::uint64_t, PeerId>>::iterator seat);
    Fault forward(const NetAddress& from, net::Bytes datagram);
    void sweep();

    // lobby.cpp
    Fault take_lobby_request(const NetAddress& from, net::Bytes datagram);
    /// Content of a lobby answer.
    struct Said {
        net::LobbyStatus status;
        std::uint32_t members;
        std::vector<std::byte> token;
    };
    /// A lobby request.
    struct Asked {
        NetAddress from;
        NetKey who;
        std::uint32_t players;
    };
    Said say(const Asked& asked, std::string& code, const NetKey& key);
    net::LobbyStatus enter(const Asked& asked, std::string& code);
    net::LobbyStatus open_room(const Asked& asked, std::string& code);
    std::vector<std::byte> token_for(const NetKey& who, const net::Room& room, const NetKey& key) const;
    void close_old_rooms();
};

} // namespace lockstone
