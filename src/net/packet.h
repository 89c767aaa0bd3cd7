// The formats of datagrams (README.md): the first byte, the length of each kind, the fields of handshakes.
#pragma once

#include "net/crypto.h"

namespace lockstone::net {

/// The high half of the first byte. The low half is a slot: the sender's, or on the way to a relay the
/// receiver's.
enum class Kind : std::uint8_t {
    hello = 1,
    cookie,
    request,
    accept,
    punch, // between players without keys
    lobby_request = 6,
    lobby_answer, // to and from the lobby of a relay
    data = 8,
    keep_alive,
    challenge,
    challenge_answer, // between players, encrypted
    relay_hello = 12,
    relay_cookie,
    relay_request,
    relay_accept,
};
constexpr std::byte first_byte(Kind kind, PeerId slot) {
    return static_cast<std::byte>(static_cast<std::uint32_t>(kind) << 4 | (slot & 15u));
}
constexpr Kind kind_of(std::byte first) {
    return static_cast<Kind>(std::to_integer<std::uint8_t>(first) >> 4);
}
constexpr PeerId slot_of(std::byte first) { return std::to_integer<std::uint32_t>(first) & 15u; }

inline constexpr std::size_t data_head_bytes = 3; // first byte, low 16 bits of the number
inline constexpr std::size_t control_bytes = 8;   // content of keep-alives, challenges and challenge answers
inline constexpr std::size_t hello_bytes = 24;    // u8 first, u8 version, u32 match, u64 nonce, ten zeros
inline constexpr std::size_t cookie_bytes = 18;   // u8 first, u8 version, u64 nonce, u64 cookie
// As hello without the zeros, then u64 cookie, sealed key.
inline constexpr std::size_t request_bytes = 22 + 32 + sealed_extra_bytes;
// u8 first, u8 version, u64 nonce, sealed key.
inline constexpr std::size_t accept_bytes = 10 + 32 + sealed_extra_bytes;
inline constexpr std::size_t pass_bytes = 5 + 50 + sealed_extra_bytes; // of seal_pass()
// As cookie, then the pass, authenticator.
inline constexpr std::size_t relay_request_bytes = 18 + pass_bytes + tag_bytes;
// u8 first, u8 version, u64 nonce, authenticator.
inline constexpr std::size_t relay_accept_bytes = 10 + tag_bytes;
static_assert(cookie_bytes <= hello_bytes && accept_bytes <= request_bytes &&
              relay_accept_bytes <= relay_request_bytes);

/// Minimum and maximum length of a kind [bytes]; {0, 0}: an unknown kind.
struct Lengths {
    std::size_t least, most;
};
constexpr Lengths lengths_of(Kind kind) {
    switch (kind) {
    case Kind::hello:
    case Kind::relay_hello:
        return {hello_bytes, hello_bytes};
    case Kind::cookie:
    case Kind::relay_cookie:
        return {cookie_bytes, cookie_bytes};
    case Kind::request:
        return {request_bytes, request_bytes};
    case Kind::accept:
        return {accept_bytes, accept_bytes};
    case Kind::punch:
        return {1, 1};
    case Kind::data:
        return {net_overhead_bytes, net_datagram_bytes_max};
    case Kind::keep_alive:
    case Kind::challenge:
    case Kind::challenge_answer:
        return {net_overhead_bytes + control_bytes, net_overhead_bytes + control_bytes};
    case Kind::relay_request:
        return {relay_request_bytes, relay_request_bytes};
    case Kind::relay_accept:
        return {relay_accept_bytes, relay_accept_bytes};
    case Kind::lobby_request:
    case Kind::lobby_answer:
        return {packet_bytes_max, packet_bytes_max};
    }
    return {0, 0};
}
/// Checks the length and the kind. Empty: both are valid.
std::optional<NetFault> length_fault(Bytes datagram);

/// Hello to a player or a relay. `match`: low half of the match id, 0 to a relay.
struct Hello {
    std::uint8_t version;
    std::uint32_t match;
    std::uint64_t nonce;
};
Hello read_hello(Bytes datagram);
void write_hello(Space to, std::byte first, std::uint32_t match, std::uint64_t nonce);

/// Version, nonce and cookie: the fields after the first byte of a cookie, a relay request and a lobby
/// request. Accepts and lobby answers have the first two only.
struct Cookie {
    std::uint8_t version;
    std::uint64_t nonce, cookie;
};
Cookie read_cookie(Bytes datagram);
void write_cookie(Space to, std::byte first, std::uint64_t nonce, std::uint64_t cookie);

} // namespace lockstone::net
