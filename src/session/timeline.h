// Access to the confirmed timeline for machines outside the match: spectators, and machines that join late
// or return.
//
// Such a machine, a listener, sends in each poll a request (Wish) with what it lacks. The host answers with
// ticks of its log, with chunks of a state (snapshot.h), and with the hash of a requested tick. A request
// causes at most four packets, so the requests of a listener cannot increase its share of the traffic.
#pragma once

#include "session/inputs/input_queue.h"
#include "session/join/snapshot.h"
#include "session/link/message.h"

namespace lockstone::session {

inline constexpr std::uint64_t no_tick = 0xffff'ffff; ///< marks an omitted tick in a packet

/// A ticket is life * 256 + number: the life of the requesting machine (JoinDef::life), and the number of
/// the request in that life.
inline constexpr std::uint32_t tickets_of_a_life = 256;
inline std::uint32_t life_of(std::uint32_t ticket) { return ticket / tickets_of_a_life; }

/// A request of a listener to a host.
struct Wish {
    bool wants_log = false;
    bool wants_state = false; ///< requests a state: the listener has none, or one of another match
    bool wants_seat = false;  ///< requests its seat: the listener has caught up with the match
    /// Ticket of the request for the seat, greater for each new request; 0: a spectator without a seat.
    std::uint32_t ticket = 0;
    std::uint64_t wanted = 0;        ///< first missing tick of the log
    std::uint64_t asked = no_tick;   ///< requests the hash after this tick
    std::uint64_t offered = no_tick; ///< tick of the state whose chunks the listener collects
    std::uint32_t missing = 0;       ///< first missing chunk of that state
    std::uint64_t have = 0;          ///< bit i: chunk missing + 1 + i has arrived

    friend bool operator==(const Wish&, const Wish&) = default;
};

/// Consecutive ticks of the confirmed timeline, each with the low half of its hash, the players that have
/// left, and all inputs. Without ticks (count 0): the host no longer holds ticks below `first`.
struct Stretch {
    std::uint64_t first = 0;
    std::uint32_t count = 0;
    std::uint64_t end = 0;            ///< listeners may receive ticks below
    std::span<const std::byte> bytes; ///< per tick: u32 hash, u16 bit p: player p has left, inputs [players]
};
/// Maximum length of Stretch::bytes [bytes].
inline constexpr std::size_t stretch_bytes_max = 1100;

/// Message of a host: the hash of the state after a confirmed tick.
struct Word {
    std::uint64_t tick = 0, hash = 0;
};

/// Answer to a request for a seat: the first tick with the machine's inputs, and for each player the tick
/// of its last join (0: the start).
struct Admission {
    std::uint32_t ticket = 0;
    std::uint64_t tick = 0;
    std::array<std::uint64_t, players_max> since{};

    friend bool operator==(const Admission&, const Admission&) = default;
};

/// The writers fill `buffer` with a packet in the format of README.md and return it. The view is valid
/// until the buffer changes.
std::span<const std::byte> write_wish(std::vector<std::byte>& buffer, std::uint32_t match, const Wish& wish);
std::span<const std::byte> write_stretch(std::vector<std::byte>& buffer, std::uint32_t match,
                                         const Stretch& stretch);
std::span<const std::byte> write_offer(std::vector<std::byte>& buffer, std::uint32_t match,
                                       const Offer& offer);
std::span<const std::byte> write_chunk(std::vector<std::byte>& buffer, std::uint32_t match,
                                       const Chunk& chunk);
std::span<const std::byte> write_word(std::vector<std::byte>& buffer, std::uint32_t match, const Word& word);
std::span<const std::byte> write_admission(std::vector<std::byte>& buffer, std::uint32_t match,
                                           std::uint32_t players, const Admission& admission);
/// The readers return the content of a packet; empty: another kind, another match, a wrong checksum or a
/// field out of range. Views point into `packet`.
std::optional<Wish> read_wish(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Stretch> read_stretch(std::span<const std::byte> packet, std::uint32_t match,
                                    std::size_t tick_bytes);
std::optional<Offer> read_offer(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Chunk> read_chunk(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Word> read_word(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Admission> read_admission(std::span<const std::byte> packet, std::uint32_t match,
                                        std::uint32_t players);
/// True if the first byte is that of a request.
bool is_wish(std::span<const std::byte> packet);
/// True if the first byte is that of an answer to a request.
bool is_answer_to_wish(std::span<const std::byte> packet);

/// Length of a tick in the log [bytes].
inline std::size_t tick_bytes_of(const SessionDef& def) { return 6 + def.players.size() * def.input_size; }

/// Settings of a TimelineHost.
struct TimelineDef {
    /// Capacity of the log [ticks]. A full log drops its older half. Without `keeps_unheard` it keeps the
    /// ticks that a listener still needs, up to eight times the capacity.
    std::uint64_t log_ticks_max;
    std::uint32_t delay_ticks; ///< delay of the listeners behind the newest tick [ticks]
    /// Limit of listeners; requests of others are ignored.
    std::uint32_t listeners_max;
    std::uint64_t silence_polls; ///< a listener is removed after this silence [polls]
    bool keeps_unheard;          ///< false: without listeners the log holds only the newest 256 to 512 ticks
};

/// Stores confirmed ticks in a log and sends them, and states, to listeners. One thread at a time.
class TimelineHost {
  public:
    TimelineHost(const SessionDef& def, TimelineDef how);

    /// Adds the next confirmed tick; a gap ends the program.
    void add(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash);
    /// Adds the next tick as another host sent it [tick_bytes_of()]: only the low half of its hash is
    /// known.
    void add_told(std::uint64_t tick, std::span<const std::byte> told);
    /// Stores a state that another host has sent.
    void set_snapshot(const Offer& offer, std::span<const std::byte> image);
    /// True if a listener collects the stored state, and the time for it has not expired.
    bool is_snapshot_taken() const;
    /// Low half of the hash after a tick; empty: the log does not hold the tick.
    std::optional<std::uint32_t> told_hash(std::uint64_t tick) const;
    /// Handles a request. It ignores a request for ticks after those that listeners may receive: the sender
    /// cannot have the ticks before.
    void hear(PeerId peer, const Wish& wish);
    /// Sends each listener the answers to its request. `states`: source of states; null: none.
    void serve(Transport& transport, StateInspector* states);
    std::uint32_t listeners() const { return static_cast<std::uint32_t>(all.size()); }
    std::uint64_t packets_sent() const { return packets; }
    std::uint64_t bytes_sent() const { return bytes; }
    std::uint64_t states_made() const { return made; }
    std::uint64_t log_begin() const { return log_first; }
    std::uint64_t log_end() const { return log_first + log.size() / tick_bytes; }
    std::size_t log_bytes() const { return log.size(); }

  private:
    struct Listener {
        PeerId peer;
        Wish wish;
        bool was_heard = false;             ///< a request arrived since the last serve()
        std::uint64_t wanted = 0, sent = 0; ///< ticks
        std::uint64_t silent_polls = 0, polls_without_progress = 0;
        std::uint64_t chunks_of = no_tick; ///< tick of the state that the listener collects
        std::uint32_t chunk_next = 0, chunk_missing = 0, wishes_without_chunk = 0;
        std::uint64_t chunks_sent = 0; ///< chunks of that state sent so far
    };
    std::uint64_t shown_end() const;
    void make_room();
    std::uint64_t first_awaited() const;
    bool make_snapshot(StateInspector* states);
    void serve_word(Listener& listener, Transport& transport);
    void serve_state(Listener& listener, Transport& transport);
    void serve_log(Listener& listener, Transport& transport);
    void tell_begin(Listener& listener, Transport& transport);
    void send(Transport& transport, PeerId to, std::span<const std::byte> packet);

    TimelineDef def;
    std::uint32_t match;
    std::size_t tick_bytes;
    std::uint64_t log_first = 0;
    std::vector<std::byte> log; ///< ticks in the format of Stretch::bytes
    /// [history_ticks] by tick modulo history_ticks; unused if the ticks come from another host.
    std::vector<std::uint64_t> hashes;
    bool is_told = false; ///< the ticks come from another host
    bool has_begun = false;
    std::uint64_t first = 0; ///< the first added tick
    std::optional<Snapshot> snapshot;
    std::uint64_t polls = 0, snapshot_at_poll = 0, made = 0;
    std::vector<Listener> all; ///< ordered by peer
    std::vector<std::byte> packet;
    Chunk chunk;
    std::uint64_t packets = 0, bytes = 0;
};

} // namespace lockstone::session
