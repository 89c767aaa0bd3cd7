// Machines that meet over the internet: tokens, encrypted datagrams over UDP, a relay. Needs LOCKSTONE_BUILD_NET (libsodium).
//
//   std::vector<ConnectToken> tokens = make_tokens(plan).value();     // by whoever brings the players together
//   UdpTransport transport = UdpTransport::open(tokens[0], {}, parse_address("0.0.0.0:7777").value(), now_ms).value();
//   auto session = make_rollback_session(session_def(game, /*self=*/0, {0, 1}), transport).value();
//   each frame: transport.poll(now_ms), then the session's frame
//
// Every pair of players has keys of its own: who is in a match can neither read nor forge what others send each other.
// Endpoint and Relay are pure: datagrams and time go in, datagrams come out. Time is in milliseconds since 1970, since
// tokens expire; an earlier time than before counts as the same. src/net/README.md has every byte and its source.
#pragma once

#include "lockstone/result.h"
#include "lockstone/session/transport.h"

#include <array>
#include <compare>
#include <memory>
#include <string>
#include <string_view>

namespace lockstone {

inline constexpr std::uint8_t net_version = 1;       ///< of the datagrams and the passes
inline constexpr std::uint8_t token_version = 2;     ///< of the tokens
inline constexpr std::uint32_t net_players_max = 16; ///< of a match
inline constexpr std::size_t net_overhead_bytes =
    19; ///< what a packet costs above UDP: 1 kind and slot, 2 sequence, 16 tag
inline constexpr std::size_t net_datagram_bytes_max = packet_bytes_max + net_overhead_bytes;
inline constexpr std::size_t replay_window_packets = 1024; ///< older packets are refused unread

// ---- names ---------------------------------------------------------------------------------------------------------

/// An address of IPv6, or of IPv4 as ::ffff:a.b.c.d (RFC 4291, 2.5.5.2). Port 0: none.
struct NetAddress {
    std::array<std::uint8_t, 16> ip{};
    std::uint16_t port = 0;
    friend auto operator<=>(const NetAddress&, const NetAddress&) = default;
};
/// "192.0.2.7:7777" or "[2001:db8::7]:7777". Names are not looked up.
Result<NetAddress> parse_address(std::string_view text);
std::string to_string(const NetAddress& address);

/// Of X25519 (RFC 7748) or of a cipher.
struct NetKey {
    std::array<std::byte, 32> bytes{};
    friend bool operator==(const NetKey&, const NetKey&) = default;
};
NetKey random_key(); ///< from the system's generator
NetKey public_key_of(const NetKey& secret);
/// 64 hexadecimal digits.
Result<NetKey> parse_key(std::string_view text);
std::string to_string(const NetKey& key);

// ---- tokens --------------------------------------------------------------------------------------------------------

/// A relay that waits for a player, as the player's token names it.
struct RelaySeat {
    NetAddress address; ///< no port: there is none
    NetKey key;         ///< known to the player and, in the pass, to the relay
    std::vector<std::byte> pass;
};

/// What a player needs in order to enter one match. It holds a secret: hand it over sealed, or over a channel that is.
struct ConnectToken {
    std::uint64_t match_id = 0;
    std::uint64_t expires_ms = 0; ///< no handshake from then on; who is connected stays so
    PeerId slot = 0;              ///< this player's; PeerId of the transport
    std::uint32_t players = 0;    ///< 2..net_players_max
    NetKey secret;                ///< this player's in this match
    std::array<NetKey, net_players_max> public_keys{};   ///< by slot
    std::array<NetAddress, net_players_max> addresses{}; ///< by slot; not used where there is a relay
    NetAddress relay;            ///< no port: the players send to each other's addresses
    NetKey relay_key;            ///< known to the player and, in the pass, to the relay
    std::vector<std::byte> pass; ///< for the relay, sealed with its key; see seal_pass
    RelaySeat second_relay;      ///< where players look for each other when they miss each other at the first
};

/// What the relay reads of a player.
struct RelayPass {
    std::uint64_t match_id = 0;
    std::uint64_t expires_ms =
        0; ///< a player whose address changes shows it again, so it lives as long as the match may
    PeerId slot = 0;
    std::uint32_t players = 0;
    NetKey key;
};

/// A match to be.
struct MatchPlan {
    std::uint64_t match_id = 0;
    std::uint64_t expires_ms = 0;
    std::vector<NetAddress> addresses; ///< by slot, 2..net_players_max
    NetAddress relay;
    NetKey relay_secret; ///< the relay's, where there is one
    /// When the passes for both relays expire: not before the match may end. Not 0 where there is a relay.
    std::uint64_t relay_expires_ms = 0;
    NetAddress second_relay = {}; ///< no port: there is none; else there is a first one
    NetKey second_relay_secret = {};
};
/// Tokens by slot, with new keys. Errors: too few or too many players; a player without address where there is no relay;
/// a second relay without a first, or at the same address; a relay and no time at which its passes expire.
Result<std::vector<ConnectToken>> make_tokens(const MatchPlan& plan);

/// Sealed with a key that maker and player share (XChaCha20-Poly1305-IETF, a random nonce).
std::vector<std::byte> seal_token(const ConnectToken& token, const NetKey& key);
/// Errors say which: not a token, another version, cut or too long, not made with this key or changed since, expired, or
/// a field out of range.
Result<ConnectToken> open_token(std::span<const std::byte> bytes, const NetKey& key, std::uint64_t now_ms);
std::vector<std::byte> seal_pass(const RelayPass& pass, const NetKey& relay_secret);
Result<RelayPass> open_pass(std::span<const std::byte> bytes, const NetKey& relay_secret,
                            std::uint64_t now_ms);

// ---- one machine of a match ----------------------------------------------------------------------------------------

/// Why a datagram was refused. It has changed nothing but a count, and nothing was answered.
enum class NetFault : std::uint32_t {
    truncated, ///< shorter than its kind is
    oversized, ///< longer than its kind is, or than any may be
    malformed, ///< no such kind, or a fixed field is another
    version,   ///< another version of the handshake
    match,     ///< a handshake of another match
    stranger, ///< from a slot that is not in the match, from itself, or not from the relay where there is one
    cookie,   ///< a handshake whose sender has not proven its address
    spoofed,  ///< not authentic, and not from where the player is
    unauthenticated, ///< from where the player is, but not authentic: damaged or forged
    replayed,        ///< seen before, or older than the window
    expired,         ///< a handshake after the token's or the pass's end
    over_rate,       ///< more than is answered, opened or taken
    unexpected,      ///< an answer that nobody waits for
};
inline constexpr std::uint32_t net_fault_count = 13;
const char* name_of(NetFault fault);

struct NetStats {
    std::uint64_t received = 0, bytes_received = 0; ///< datagrams, and their bytes above UDP
    std::uint64_t sent = 0, bytes_sent = 0;
    std::uint64_t delivered = 0; ///< packets of peers
    std::uint64_t opened = 0;    ///< ciphertexts tried: what floods cost
    std::uint64_t answered = 0;  ///< answers to senders who had not proven their address
    std::uint64_t over_budget =
        0; ///< packets that were not sent: not connected, too long, or more than the budget
    std::uint64_t queue_full = 0; ///< packets dropped since nobody took them
    std::uint64_t paths_changed = 0;
    std::array<std::uint64_t, net_fault_count> refused{}; ///< by NetFault
    std::uint64_t refused_in_all() const;
};

/// Limits. All rates are token buckets that hold a second's worth, but for what is said.
struct EndpointDef {
    std::uint32_t packets_per_second = 480;  ///< taken of each peer
    std::uint32_t opens_per_second = 20'000; ///< ciphertexts tried, of all senders
    std::uint32_t hellos_per_source = 4;     ///< answered a second, of an address (IPv6: of its /64)
    std::uint32_t hellos_per_second =
        200; ///< answered a second, of all addresses that the token does not name
    std::uint32_t bytes_per_second = 96'000; ///< sent to each peer; a packet beyond is dropped
    std::uint32_t keep_alive_ms = 1000;      ///< of silence, after which a few bytes keep the way open
    std::uint32_t silence_ms = 3000;         ///< after which the handshake is tried anew
    /// Of a peer's silence, after which it is looked for at the other relay, where the token names two. More than keep_alive_ms, and
    /// less than half a session's patience.
    std::uint32_t relay_silence_ms = 1500;
    std::uint32_t packets_waiting_max =
        512; ///< in each direction, for one frame, at least 8; memory of so many is taken at the start
};

/// One datagram to be sent; the bytes are valid until the next call.
struct OutgoingDatagram {
    NetAddress to;
    std::span<const std::byte> bytes;
};

/// Everything between a session's packets and datagrams, without socket and clock. Memory is bounded and taken at the start.
class Endpoint {
  public:
    /// Errors: a token with a field out of range, one that has expired, or a public key that no secret belongs to.
    static Result<Endpoint> create(const ConnectToken& token, const EndpointDef& def, std::uint64_t now_ms);
    Endpoint(Endpoint&&) noexcept;
    Endpoint& operator=(Endpoint&&) noexcept;
    ~Endpoint();

    /// A datagram has arrived, whatever is in it.
    void receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms);
    /// Handshakes, keep-alives, challenges. Call each frame.
    void poll(std::uint64_t now_ms);
    /// A packet for a peer, at most packet_bytes_max. May be dropped, see NetStats::over_budget.
    void send(PeerId to, std::span<const std::byte> packet, std::uint64_t now_ms);
    /// The next packet of a peer, authentic and not seen before; the bytes are valid until the next call.
    std::optional<Datagram> next_packet();
    /// The next datagram to send.
    std::optional<OutgoingDatagram> next_outgoing();

    bool is_connected(PeerId peer) const;
    bool is_relayed() const; ///< a relay, if there is one, has let this player in
    /// Where a peer is, proven; no port: not connected.
    NetAddress address_of(PeerId peer) const;
    const NetStats& stats() const;

  private:
    struct Impl;
    explicit Endpoint(std::unique_ptr<Impl> made);
    std::unique_ptr<Impl> impl;
};

// ---- the relay and the lobby ---------------------------------------------------------------------------------------

struct RelayDef {
    std::uint32_t matches_max = 1024;
    /// Matches whose first player came from one address (IPv6: one /64), and from one network (IPv4: /24, IPv6: /48). The last quarter of
    /// matches_max is kept for addresses that have opened none.
    std::uint32_t matches_per_source = 64, matches_per_network = 256;
    std::uint32_t packets_per_second = 2000;  ///< of each player, to all others
    std::uint32_t bytes_per_second = 200'000; ///< of each player
    std::uint32_t hellos_per_source = 16;     ///< answered a second, of an address (IPv6: of its /64)
    std::uint32_t hellos_per_second = 2000;   ///< answered a second, in all
    std::uint32_t opens_per_second = 2000;    ///< passes and lobby requests read a second
    std::uint32_t idle_ms = 30'000;           ///< after which a silent player is forgotten
    std::uint32_t rooms_max = 1024;           ///< of the lobby
    /// Rooms opened from one address and from one network, as for matches, and still good. The last quarter of rooms_max is kept
    /// for addresses that have opened none.
    std::uint32_t rooms_per_source = 16, rooms_per_network = 64;
    std::uint32_t room_ms = 300'000;          ///< how long a code is good at most
    std::uint32_t room_idle_ms = 30'000;      ///< after which a room closes whose members send no requests
    std::uint32_t match_ms = 4 * 3600 * 1000; ///< how long a token and a pass that the lobby makes are good
    /// The relay that the lobby names as the second in every token, and its secret, which makes passes; no port: none.
    NetAddress second = {};
    NetKey second_secret = {};
};

/// Forwards sealed packets between the players of a match by slot, and brings players together by a code. It holds no keys
/// of theirs: what they send each other it can drop or delay, not read and not forge. All state is bounded by RelayDef.
class WatchDoor;
class Relay {
  public:
    Relay(const NetKey& secret, const RelayDef& def, std::uint64_t now_ms);
    Relay(Relay&&) noexcept;
    Relay& operator=(Relay&&) noexcept;
    ~Relay();

    void receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms);
    void poll(std::uint64_t now_ms); ///< forgets who is silent
    std::optional<OutgoingDatagram> next_outgoing();
    /// A new code, for as many as come: its lobby answers each with a place at `door`, which has to be reached at the relay's own address.
    /// Not owned: the door, which has to live as long.
    const std::string& show(WatchDoor& door);
    struct Counters {
        std::uint64_t forwarded = 0, matches = 0, players = 0, rooms = 0;
    };
    Counters counters() const;
    const NetStats& stats() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl;
};

/// Asks a relay's lobby for a match. Pure as Endpoint is.
class LobbyClient {
  public:
    /// `code` empty: opens a room for `players` machines (2..net_players_max); else enters that one.
    LobbyClient(const NetAddress& lobby, const NetKey& lobby_public_key, std::string_view code,
                std::uint32_t players);
    LobbyClient(LobbyClient&&) noexcept;
    LobbyClient& operator=(LobbyClient&&) noexcept;
    ~LobbyClient();

    void receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms);
    void poll(std::uint64_t now_ms);
    std::optional<OutgoingDatagram> next_outgoing();
    const std::string& code() const; ///< empty until the room is there
    /// When all are there. The secret in it was made here and is known to nobody else.
    const std::optional<ConnectToken>& token() const;
    /// The time of the lobby's last answer that its key opened [ms], as receive() was given it; 0 before the first. A lobby that lives answers
    /// twice a second while players wait.
    std::uint64_t answered_ms() const;
    /// A sentence when the lobby has refused: no such code, the room is full, the lobby is full, no place to watch is free.
    const std::string& refusal() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl;
};

// ---- many who watch ------------------------------------------------------------------------------------------------

struct WatchDoorDef {
    NetAddress address = {};           ///< where watchers reach the door; with a port
    std::uint64_t expires_ms = 0;      ///< of the tokens; who is connected stays so
    std::uint32_t watchers_max = 1024; ///< 1..4096; each takes 75 kB while it is there
    std::uint32_t idle_ms =
        60'000; ///< of a watcher's silence, since its token at the earliest: its place is free again
    std::uint32_t bytes_per_second = 200'000; ///< sent to each watcher
    std::uint32_t packets_per_second = 120;   ///< taken of each watcher
};

/// Lets many machines in that watch through a SpectatorRelay: each is alone with the door, with keys of its own, behind one address.
/// Pure as Endpoint is. To the watching machine it is the other one of a match of two, slot 0.
class WatchDoor {
  public:
    /// Errors: a field out of range.
    static Result<WatchDoor> create(const WatchDoorDef& def, std::uint64_t now_ms);
    WatchDoor(WatchDoor&&) noexcept;
    WatchDoor& operator=(WatchDoor&&) noexcept;
    ~WatchDoor();

    /// A token for one more watcher. Errors, with a sentence: every place is taken.
    Result<ConnectToken> let_in(std::uint64_t now_ms);
    /// The same for one that has made its keys itself: the token lacks the secret. Asked again it is the same place.
    Result<ConnectToken> let_in(const NetKey& public_key, std::uint64_t now_ms);

    void receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms);
    void poll(std::uint64_t now_ms);
    /// `watcher`: a place, below watchers_max, as packets name it.
    void send(PeerId watcher, std::span<const std::byte> packet, std::uint64_t now_ms);
    std::optional<Datagram> next_packet();
    std::optional<OutgoingDatagram> next_outgoing();

    struct Counters {
        std::uint32_t let_in = 0, connected = 0; ///< places that are taken, and those whose watcher is there
        std::uint64_t strangers = 0;             ///< datagrams that belong to no place; none is answered
    };
    Counters counters() const;

  private:
    struct Impl;
    explicit WatchDoor(std::unique_ptr<Impl> made);
    std::unique_ptr<Impl> impl;
};

// ---- sockets -------------------------------------------------------------------------------------------------------

/// A UDP socket that never waits. POSIX and Windows; IPv6 and IPv4 at once where the system has both.
class UdpSocket {
  public:
    /// Port 0: any. Errors: the system's sentence.
    static Result<UdpSocket> open(const NetAddress& local);
    UdpSocket(UdpSocket&& other) noexcept;
    UdpSocket& operator=(UdpSocket&& other) noexcept;
    ~UdpSocket();

    NetAddress local_address() const;
    /// Sent or lost; nobody tells.
    void send(const NetAddress& to, std::span<const std::byte> bytes);
    struct Arrived {
        NetAddress from;
        std::span<const std::byte> bytes; ///< valid until the next call
    };
    std::optional<Arrived> receive();
    /// Waits until something has arrived, at most so long.
    void wait(std::uint32_t milliseconds);

  private:
    explicit UdpSocket(std::intptr_t made);
    std::intptr_t handle = -1; ///< of the system; -1: none
    bool is_ipv6 = false;
    std::unique_ptr<std::array<std::byte, 2048>> buffer;
};

/// A session's transport over UDP. PeerId is the slot.
class UdpTransport final : public Transport {
  public:
    static Result<UdpTransport> open(const ConnectToken& token, const EndpointDef& def,
                                     const NetAddress& local, std::uint64_t now_ms);
    /// Reads at most datagrams_per_poll from the socket, then keeps connections alive. Call before the session's frame.
    void poll(std::uint64_t now_ms);
    void send(PeerId to, std::span<const std::byte> bytes) override;
    std::optional<Datagram> receive() override;
    bool authenticated() const override {
        return true;
    } ///< keys are of this match, and each packet has a tag
    const Endpoint& endpoint() const { return peer; }
    UdpSocket& socket() { return wire; }
    static constexpr std::uint32_t datagrams_per_poll = 4096;

  private:
    UdpTransport(Endpoint made, UdpSocket opened, std::uint64_t now_ms);
    void flush();
    Endpoint peer;
    UdpSocket wire;
    std::uint64_t now;
};

/// A relay's transport to its watchers: a door with a socket.
class UdpWatchDoor final : public Transport {
  public:
    /// `def.address` with port 0: the socket's own address, as at 127.0.0.1.
    static Result<UdpWatchDoor> open(const WatchDoorDef& def, const NetAddress& local, std::uint64_t now_ms);
    /// From now on a LobbyClient that asks at this socket with the code that is returned, and the public key of `secret`, is let in.
    const std::string& open_lobby(const NetKey& secret, std::uint64_t now_ms);
    /// Call before SpectatorRelay::poll.
    void poll(std::uint64_t now_ms);
    void send(PeerId to, std::span<const std::byte> bytes) override;
    std::optional<Datagram> receive() override;
    bool authenticated() const override { return true; }
    WatchDoor& door() { return *watchers; }
    UdpSocket& socket() { return wire; }
    static constexpr std::uint32_t datagrams_per_poll = 4096;

  private:
    UdpWatchDoor(WatchDoor made, UdpSocket opened, std::uint64_t now_ms);
    void flush();
    std::unique_ptr<WatchDoor> watchers; ///< where it stays: the lobby names it
    std::unique_ptr<Relay> lobby;        ///< null: none
    UdpSocket wire;
    std::uint64_t now;
};

} // namespace lockstone
