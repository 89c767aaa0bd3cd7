// Sessions over the internet: tokens, encrypted datagrams over UDP, relays. Needs LOCKSTONE_BUILD_NET
// (libsodium).
//
//   std::vector<ConnectToken> tokens = make_tokens(plan).value();     // on the matchmaking server
//   const NetAddress local = parse_address("0.0.0.0:7777").value();
//   UdpTransport transport = UdpTransport::open(tokens[0], {}, local, now_ms).value();
//   auto session = make_rollback_session(session_def(game, /*self=*/0, {0, 1}), transport).value();
//   each frame: transport.poll(now_ms), then the session's frame
//
// Each pair of players has its own keys: a player cannot read or forge packets between two others. Endpoint,
// Relay, LobbyClient and WatchDoor have no socket and no clock: the caller passes datagrams and time, and
// sends the outgoing datagrams. Time is in milliseconds since 1970, because tokens expire; a time before the
// last one counts as the last one. One thread at a time for each object. src/net/README.md has the formats
// and their sources.
#pragma once

#include "lockstone/result.h"
#include "lockstone/session/transport.h"

#include <array>
#include <compare>
#include <memory>
#include <string>
#include <string_view>

namespace lockstone {

inline constexpr std::uint8_t net_version = 1;       ///< of datagrams and passes
inline constexpr std::uint8_t token_version = 2;     ///< of tokens
inline constexpr std::uint32_t net_players_max = 16; ///< players of a match
/// Bytes of a datagram beside the packet: 1 kind and slot, 2 sequence, 16 tag.
inline constexpr std::size_t net_overhead_bytes = 19;
/// Bytes of the longest datagram.
inline constexpr std::size_t net_datagram_bytes_max = packet_bytes_max + net_overhead_bytes;
/// Size of the replay window: older packets are refused.
inline constexpr std::size_t replay_window_packets = 1024;

// ---- addresses and keys -----------------------------------------------------------------------------------

/// An IPv6 address, or an IPv4 address in the form of IPv6 (RFC 4291, 2.5.5.2), with a port.
struct NetAddress {
    std::array<std::uint8_t, 16> ip{}; ///< big-endian
    std::uint16_t port = 0;            ///< 0: no address
    /// By ip, then port.
    friend auto operator<=>(const NetAddress&, const NetAddress&) = default;
};
/// Parses "192.0.2.7:7777" or "[2001:db8::7]:7777". Host names are not resolved. Errors: any other text.
Result<NetAddress> parse_address(std::string_view text);
/// The text that parse_address() reads.
std::string to_string(const NetAddress& address);

/// A key of X25519 (RFC 7748) or of a cipher.
struct NetKey {
    std::array<std::byte, 32> bytes{}; ///< the key
    /// Equal bytes. Not in constant time.
    friend bool operator==(const NetKey&, const NetKey&) = default;
};
NetKey random_key();                        ///< A key from the system's random generator.
NetKey public_key_of(const NetKey& secret); ///< The public key of an X25519 secret.
/// Parses 64 hexadecimal digits. Errors: any other text.
Result<NetKey> parse_key(std::string_view text);
/// The text that parse_key() reads.
std::string to_string(const NetKey& key);

// ---- tokens -----------------------------------------------------------------------------------------------

/// A player's access to a relay.
struct RelaySeat {
    NetAddress address;          ///< of the relay; port 0: no relay
    NetKey key;                  ///< shared by player and relay
    std::vector<std::byte> pass; ///< of seal_pass()
};

/// A player's access to one match. It contains a secret: transfer it sealed or over an encrypted channel.
struct ConnectToken {
    std::uint64_t match_id = 0;                          ///< id of the match
    std::uint64_t expires_ms = 0;                        ///< end of handshakes [ms]; connections continue
    PeerId slot = 0;                                     ///< this player; PeerId of the transport
    std::uint32_t players = 0;                           ///< 2..net_players_max
    NetKey secret;                                       ///< this player's secret for this match
    std::array<NetKey, net_players_max> public_keys{};   ///< [players] by slot
    std::array<NetAddress, net_players_max> addresses{}; ///< [players] by slot; unused with a relay
    NetAddress relay;                                    ///< port 0: players send to each other directly
    NetKey relay_key;                                    ///< shared by player and relay
    std::vector<std::byte> pass;                         ///< for the relay, of seal_pass()
    RelaySeat second_relay;                              ///< used when a peer is silent at the first relay
};

/// Content of a pass: the relay's data about a player.
struct RelayPass {
    std::uint64_t match_id = 0;   ///< id of the match
    std::uint64_t expires_ms = 0; ///< [ms]; after the end of the match, for players whose address changes
    PeerId slot = 0;              ///< the player
    std::uint32_t players = 0;    ///< 2..net_players_max
    NetKey key;                   ///< shared by player and relay
};

/// Definition of a match for make_tokens().
struct MatchPlan {
    std::uint64_t match_id = 0;        ///< id of the match
    std::uint64_t expires_ms = 0;      ///< end of handshakes [ms]
    std::vector<NetAddress> addresses; ///< [2..net_players_max] by slot; may have port 0 with a relay
    NetAddress relay;                  ///< port 0: no relay
    NetKey relay_secret;               ///< secret of the relay
    /// Expiry of the passes for both relays [ms]: after the end of the match. Not 0 with a relay.
    std::uint64_t relay_expires_ms = 0;
    NetAddress second_relay = {};    ///< port 0: none; requires a first relay at another address
    NetKey second_relay_secret = {}; ///< secret of the second relay
};
/// Tokens of all players [players], with new keys. Errors: a wrong number of players; a player without
/// address and no relay; a second relay without a first, or at the same address; a relay without
/// relay_expires_ms.
Result<std::vector<ConnectToken>> make_tokens(const MatchPlan& plan);

/// Encrypts a token with a key that server and player share (XChaCha20-Poly1305-IETF, random nonce).
std::vector<std::byte> seal_token(const ConnectToken& token, const NetKey& key);
/// Decrypts a token. Errors: not a token, another version, a wrong length, a wrong key or changed bytes,
/// expired at `now_ms`, a field out of range.
Result<ConnectToken> open_token(std::span<const std::byte> bytes, const NetKey& key, std::uint64_t now_ms);
/// Encrypts a pass for the relay with this secret.
std::vector<std::byte> seal_pass(const RelayPass& pass, const NetKey& relay_secret);
/// Decrypts a pass. Errors as open_token().
Result<RelayPass> open_pass(std::span<const std::byte> bytes, const NetKey& relay_secret,
                            std::uint64_t now_ms);

// ---- one machine of a match -------------------------------------------------------------------------------

/// Reason why a datagram was refused. It changes only a count and draws no answer.
enum class NetFault : std::uint32_t {
    truncated,       ///< too short for its kind
    oversized,       ///< too long for its kind or for a datagram
    malformed,       ///< unknown kind, or a wrong constant field
    version,         ///< handshake of another version
    match,           ///< handshake of another match
    stranger,        ///< slot not in the match, own slot, or not from the relay in a match with a relay
    cookie,          ///< handshake without proof of the sender's address
    spoofed,         ///< not authentic, from another address than the player's
    unauthenticated, ///< not authentic, from the player's address: damaged or forged
    replayed,        ///< received before, or older than the replay window
    expired,         ///< handshake after the expiry of token or pass
    over_rate,       ///< a rate limit was exceeded
    unexpected,      ///< an answer without a request
};
inline constexpr std::uint32_t net_fault_count = 13; ///< number of reasons
/// "over rate". Any other value ends the program. Static string.
const char* name_of(NetFault fault);

/// Counters since the start.
struct NetStats {
    std::uint64_t received = 0,                           ///< datagrams
        bytes_received = 0;                               ///< without UDP headers
    std::uint64_t sent = 0,                               ///< datagrams
        bytes_sent = 0;                                   ///< without UDP headers
    std::uint64_t delivered = 0;                          ///< packets received from peers
    std::uint64_t opened = 0;                             ///< decryptions tried: the cost of floods
    std::uint64_t answered = 0;                           ///< answers to senders with unproven addresses
    std::uint64_t over_budget = 0;                        ///< packets not sent: no connection, too long, rate
    std::uint64_t queue_full = 0;                         ///< packets dropped because a queue was full
    std::uint64_t paths_changed = 0;                      ///< address changes of peers
    std::array<std::uint64_t, net_fault_count> refused{}; ///< [NetFault] datagrams
    std::uint64_t refused_in_all() const;                 ///< Sum of `refused`.
};

/// Limits of an Endpoint. Rates are token buckets with a capacity of one second.
struct EndpointDef {
    std::uint32_t packets_per_second = 480;  ///< accepted from each peer [1/s]
    std::uint32_t opens_per_second = 20'000; ///< decryptions for all senders [1/s]
    std::uint32_t hellos_per_source = 4;     ///< answers to an address (IPv6: its /64) [1/s]
    std::uint32_t hellos_per_second = 200;   ///< answers to all addresses that are not in the token [1/s]
    std::uint32_t bytes_per_second = 96'000; ///< sent to each peer [1/s]; packets beyond are dropped
    std::uint32_t keep_alive_ms = 1000;      ///< a keep-alive is sent after this silence [ms]
    std::uint32_t silence_ms = 3000;         ///< a new handshake begins after this silence [ms]
    /// With two relays: silence of a peer after which the other relay is tried [ms]. More than keep_alive_ms,
    /// and less than half of SessionDef::disconnect_ms.
    std::uint32_t relay_silence_ms = 1500;
    std::uint32_t packets_waiting_max = 512; ///< capacity of the queue of each direction, at least 8
};

/// A datagram to send.
struct OutgoingDatagram {
    NetAddress to;                    ///< receiver
    std::span<const std::byte> bytes; ///< valid until the next call
};

/// Converts packets of a session to datagrams and back, without socket and clock. Allocates all memory at its
/// start.
class Endpoint {
  public:
    /// Errors: a field of the token out of range, an expired token, an invalid public key,
    /// packets_waiting_max below 8.
    static Result<Endpoint> create(const ConnectToken& token, const EndpointDef& def, std::uint64_t now_ms);
    Endpoint(Endpoint&&) noexcept;            ///< The other endpoint is unusable afterwards.
    Endpoint& operator=(Endpoint&&) noexcept; ///< The other endpoint is unusable afterwards.
    ~Endpoint();

    /// Handles a received datagram with any content.
    void receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms);
    /// Handshakes, keep-alives, challenges. Call it in each frame.
    void poll(std::uint64_t now_ms);
    /// Sends a packet of at most packet_bytes_max bytes. Best effort: see NetStats::over_budget.
    void send(PeerId to, std::span<const std::byte> packet, std::uint64_t now_ms);
    /// The next packet of a peer, authentic and not a duplicate; empty: none. Bytes are valid until the next
    /// call.
    std::optional<Datagram> next_packet();
    /// The next datagram to send; empty: none. Bytes are valid until the next call.
    std::optional<OutgoingDatagram> next_outgoing();

    bool is_connected(PeerId peer) const; ///< True after the handshake with a peer.
    bool is_relayed() const;              ///< True if a relay has accepted this player.
    /// Proven address of a peer; port 0: not connected.
    NetAddress address_of(PeerId peer) const;
    const NetStats& stats() const; ///< Valid as long as the endpoint.

  private:
    struct Impl;
    explicit Endpoint(std::unique_ptr<Impl> made);
    std::unique_ptr<Impl> impl;
};

// ---- the relay and the lobby ------------------------------------------------------------------------------

/// Limits of a Relay with its lobby. The last quarter of matches_max and of rooms_max is reserved for
/// addresses without a match or room.
struct RelayDef {
    std::uint32_t matches_max = 1024;         ///< matches at a time
    std::uint32_t matches_per_source = 64,    ///< matches opened from one address (IPv6: one /64)
        matches_per_network = 256;            ///< matches opened from one network (IPv4: /24, IPv6: /48)
    std::uint32_t packets_per_second = 2000;  ///< of each player to all others [1/s]
    std::uint32_t bytes_per_second = 200'000; ///< of each player [1/s]
    std::uint32_t hellos_per_source = 16;     ///< answers to an address (IPv6: its /64) [1/s]
    std::uint32_t hellos_per_second = 2000;   ///< answers to all addresses [1/s]
    std::uint32_t opens_per_second = 2000;    ///< decryptions of passes and lobby requests [1/s]
    std::uint32_t idle_ms = 30'000;           ///< a player is removed after this silence [ms]
    std::uint32_t rooms_max = 1024;           ///< rooms of the lobby at a time
    std::uint32_t rooms_per_source = 16,      ///< rooms opened from one address (IPv6: one /64)
        rooms_per_network = 64;               ///< rooms opened from one network (IPv4: /24, IPv6: /48)
    std::uint32_t room_ms = 300'000;          ///< maximum lifetime of a room and its code [ms]
    std::uint32_t room_idle_ms = 30'000;      ///< a room closes after this time without requests [ms]
    std::uint32_t match_ms = 4 * 3600 * 1000; ///< lifetime of tokens and passes of the lobby [ms]
    NetAddress second = {};                   ///< second relay of all tokens of the lobby; port 0: none
    NetKey second_secret = {};                ///< secret of the second relay, for its passes
};

class WatchDoor;
/// A relay: forwards encrypted packets between the players of a match, and has a lobby where players meet by
/// a code. It has none of their keys: it can drop and delay packets, but not read or forge them. RelayDef
/// bounds its memory.
class Relay {
  public:
    /// A relay with its X25519 secret.
    Relay(const NetKey& secret, const RelayDef& def, std::uint64_t now_ms);
    Relay(Relay&&) noexcept;            ///< The other relay is unusable afterwards.
    Relay& operator=(Relay&&) noexcept; ///< The other relay is unusable afterwards.
    ~Relay();

    /// Handles a received datagram with any content.
    void receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms);
    void poll(std::uint64_t now_ms); ///< Removes silent players. Call it in each frame.
    /// The next datagram to send; empty: none. Bytes are valid until the next call.
    std::optional<OutgoingDatagram> next_outgoing();
    /// Opens a door for spectators and returns its code: the lobby gives each client with this code a place
    /// at `door`. The door must be reachable at the relay's address. Not owned: it must outlive the relay.
    /// The code is valid as long as the relay.
    const std::string& show(WatchDoor& door);
    /// Numbers of a relay.
    struct Counters {
        std::uint64_t forwarded = 0, ///< packets since the start
            matches = 0,             ///< at present
            players = 0,             ///< at present
            rooms = 0;               ///< at present
    };
    Counters counters() const;     ///< The present numbers.
    const NetStats& stats() const; ///< Valid as long as the relay.

  private:
    struct Impl;
    std::unique_ptr<Impl> impl;
};

/// A client of a relay's lobby: opens or enters a room and receives a token. Without socket and clock, as
/// Endpoint.
class LobbyClient {
  public:
    /// Opens a room for `players` machines (2..net_players_max) if `code` is empty; else enters the room of
    /// the code.
    LobbyClient(const NetAddress& lobby, const NetKey& lobby_public_key, std::string_view code,
                std::uint32_t players);
    LobbyClient(LobbyClient&&) noexcept;            ///< The other client is unusable afterwards.
    LobbyClient& operator=(LobbyClient&&) noexcept; ///< The other client is unusable afterwards.
    ~LobbyClient();

    /// Handles a received datagram with any content.
    void receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms);
    void poll(std::uint64_t now_ms); ///< Sends requests. Call it in each frame.
    /// The next datagram to send; empty: none. Bytes are valid until the next call.
    std::optional<OutgoingDatagram> next_outgoing();
    const std::string& code() const; ///< Code of the room; empty: no answer yet. Valid as long as the client.
    /// The token; empty until all players have entered. Its secret was created here and never sent.
    const std::optional<ConnectToken>& token() const;
    /// Time of the last authentic answer [ms], as passed to receive(); 0: none. While players wait, a lobby
    /// answers twice a second.
    std::uint64_t answered_ms() const;
    /// A sentence if the lobby or this client has refused (no such code, the room is full, the lobby is full,
    /// no free place, an invalid code or key); else empty. The client then stops.
    const std::string& refusal() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl;
};

// ---- many who watch ---------------------------------------------------------------------------------------

/// Definition of a WatchDoor.
struct WatchDoorDef {
    NetAddress address = {};                  ///< address for spectators, with a port
    std::uint64_t expires_ms = 0;             ///< end of handshakes [ms]; connections continue
    std::uint32_t watchers_max = 1024;        ///< places, 1..4096; an occupied one takes 75 kB
    std::uint32_t idle_ms = 60'000;           ///< a place is freed after this silence [ms]
    std::uint32_t bytes_per_second = 200'000; ///< sent to each spectator [1/s]
    std::uint32_t packets_per_second = 120;   ///< accepted from each spectator [1/s]
};

/// The spectators' side of a SpectatorRelay: many encrypted connections at one address, each with its own
/// keys. For a spectator it is the peer of slot 0 in a match of two. Without socket and clock, as Endpoint.
class WatchDoor {
  public:
    /// Errors: an address without port, watchers_max out of range, expires_ms is over.
    static Result<WatchDoor> create(const WatchDoorDef& def, std::uint64_t now_ms);
    WatchDoor(WatchDoor&&) noexcept;            ///< The other door is unusable afterwards.
    WatchDoor& operator=(WatchDoor&&) noexcept; ///< The other door is unusable afterwards.
    ~WatchDoor();

    /// Reserves a place and returns the spectator's token. Errors: all places are taken.
    Result<ConnectToken> let_in(std::uint64_t now_ms);
    /// Reserves a place for the owner of a public key; the token has no secret. A repeated key has one place
    /// only. Errors: all places are taken, an invalid key.
    Result<ConnectToken> let_in(const NetKey& public_key, std::uint64_t now_ms);

    /// Handles a received datagram with any content.
    void receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms);
    /// Keep-alives, and removal of silent spectators. Call it in each frame.
    void poll(std::uint64_t now_ms);
    /// Sends a packet to the spectator of a place. Best effort.
    void send(PeerId watcher, std::span<const std::byte> packet, std::uint64_t now_ms);
    /// The next packet of a spectator; `from` is its place; empty: none. Bytes are valid until the next call.
    std::optional<Datagram> next_packet();
    /// The next datagram to send; empty: none. Bytes are valid until the next call.
    std::optional<OutgoingDatagram> next_outgoing();

    /// Numbers of a door.
    struct Counters {
        std::uint32_t let_in = 0,    ///< places taken
            connected = 0;           ///< spectators connected
        std::uint64_t strangers = 0; ///< datagrams without a place, since the start; not answered
    };
    Counters counters() const; ///< The present numbers.

  private:
    struct Impl;
    explicit WatchDoor(std::unique_ptr<Impl> made);
    std::unique_ptr<Impl> impl;
};

// ---- sockets ----------------------------------------------------------------------------------------------

/// A non-blocking UDP socket for POSIX and Windows; IPv6 and IPv4 together if the system has both.
class UdpSocket {
  public:
    /// Binds a socket; port 0: any free port. Errors: the message of the system.
    static Result<UdpSocket> open(const NetAddress& local);
    UdpSocket(UdpSocket&& other) noexcept;            ///< The other socket is unusable afterwards.
    UdpSocket& operator=(UdpSocket&& other) noexcept; ///< Exchanges the sockets.
    ~UdpSocket();

    NetAddress local_address() const; ///< The bound address; port 0 after a system error.
    /// Sends a datagram. Best effort: failures are not reported.
    void send(const NetAddress& to, std::span<const std::byte> bytes);
    /// A received datagram.
    struct Arrived {
        NetAddress from;                  ///< sender
        std::span<const std::byte> bytes; ///< at most 2048; valid until the next call of receive()
    };
    std::optional<Arrived> receive(); ///< The next datagram; empty: none.
    /// Blocks until a datagram has arrived, at most this time [ms].
    void wait(std::uint32_t milliseconds);

  private:
    explicit UdpSocket(std::intptr_t made);
    std::intptr_t handle = -1; ///< system handle; -1: none
    bool is_ipv6 = false;
    std::unique_ptr<std::array<std::byte, 2048>> buffer;
};

/// A session's transport over UDP. PeerId is the slot.
class UdpTransport final : public Transport {
  public:
    /// Opens a socket and an endpoint. Errors: those of Endpoint::create() and UdpSocket::open().
    static Result<UdpTransport> open(const ConnectToken& token, const EndpointDef& def,
                                     const NetAddress& local, std::uint64_t now_ms);
    /// Reads at most datagrams_per_poll datagrams, then sends handshakes and keep-alives. Call it before the
    /// session's frame.
    void poll(std::uint64_t now_ms);
    /// Endpoint::send() at the time of poll().
    void send(PeerId to, std::span<const std::byte> bytes) override;
    std::optional<Datagram> receive() override; ///< Endpoint::next_packet()
    /// True: the keys belong to this match, and each packet has a tag.
    bool authenticated() const override { return true; }
    const Endpoint& endpoint() const { return peer; }         ///< Connections and statistics.
    UdpSocket& socket() { return wire; }                      ///< The socket.
    static constexpr std::uint32_t datagrams_per_poll = 4096; ///< datagrams that a poll reads

  private:
    UdpTransport(Endpoint made, UdpSocket opened, std::uint64_t now_ms);
    void flush();
    Endpoint peer;
    UdpSocket wire;
    std::uint64_t now;
};

/// A WatchDoor with a socket: a spectator relay's transport to its spectators. PeerId is the place.
class UdpWatchDoor final : public Transport {
  public:
    /// Opens a socket and a door. `def.address` with port 0: the socket's address, for tests at 127.0.0.1.
    /// Errors: those of WatchDoor::create() and UdpSocket::open().
    static Result<UdpWatchDoor> open(const WatchDoorDef& def, const NetAddress& local, std::uint64_t now_ms);
    /// Opens a lobby at this socket and returns its code: a LobbyClient with this code and the public key of
    /// `secret` gets a place. The code is valid as long as the door, until the next call.
    const std::string& open_lobby(const NetKey& secret, std::uint64_t now_ms);
    /// Reads at most datagrams_per_poll datagrams and sends what is due. Call it before
    /// SpectatorRelay::poll().
    void poll(std::uint64_t now_ms);
    /// WatchDoor::send() at the time of poll().
    void send(PeerId to, std::span<const std::byte> bytes) override;
    std::optional<Datagram> receive() override;               ///< WatchDoor::next_packet()
    bool authenticated() const override { return true; }      ///< True.
    WatchDoor& door() { return *watchers; }                   ///< Places and tokens.
    UdpSocket& socket() { return wire; }                      ///< The socket.
    static constexpr std::uint32_t datagrams_per_poll = 4096; ///< datagrams that a poll reads

  private:
    UdpWatchDoor(WatchDoor made, UdpSocket opened, std::uint64_t now_ms);
    void flush();
    std::unique_ptr<WatchDoor> watchers; ///< on the heap: the lobby refers to it
    std::unique_ptr<Relay> lobby;        ///< null: no lobby
    UdpSocket wire;
    std::uint64_t now;
};

} // namespace lockstone
