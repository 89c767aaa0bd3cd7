// What a machine shows of the confirmed timeline to those who are not in it: watchers, and who comes late or back.
//
// A listener says each poll what it lacks (a wish); it is answered from the log, or with a state in chunks (snapshot.h), and told
// the hash of the tick that it asks for. A wish is worth at most four packets, and a listener costs no more than its share of
// them, whatever it asks.
#pragma once

#include "session/inputs/input_queue.h"
#include "session/join/snapshot.h"
#include "session/link/message.h"

namespace lockstone::session {

inline constexpr std::uint64_t no_tick = 0xffff'ffff; ///< where a packet may leave a tick out

/// A ticket holds the life of the requesting machine; its low bits count the requests of that life with a new ticket.
inline constexpr std::uint32_t tickets_of_a_life = 256;
inline std::uint32_t life_of(std::uint32_t ticket) { return ticket / tickets_of_a_life; }

struct Wish {
    bool wants_log = false;
    bool wants_state = false; ///< it has none, or one of another match
    bool wants_seat = false;  ///< it is level with the match
    std::uint32_t ticket =
        0; ///< of one that comes to play: greater each time that it asks; 0: it only watches
    std::uint64_t wanted = 0;        ///< first tick of the log that is not here
    std::uint64_t asked = no_tick;   ///< whose hash it wants to hear
    std::uint64_t offered = no_tick; ///< tick of the state whose chunks it takes
    std::uint32_t missing = 0;       ///< its first chunk that is not here
    std::uint64_t have = 0;          ///< bit i: chunk missing + 1 + i is here

    friend bool operator==(const Wish&, const Wish&) = default;
};

/// Ticks of the confirmed timeline: of each the status of each player, the low half of the hash, and the inputs. Of no tick: what lies before
/// `first` is forgotten.
struct Stretch {
    std::uint64_t first = 0;
    std::uint32_t count = 0;
    std::uint64_t end = 0;            ///< ticks below may be watched by now
    std::span<const std::byte> bytes; ///< per tick: u32 hash, u16 bit p: player p has left, then inputs
};
inline constexpr std::size_t stretch_bytes_max = 1100;

/// The hash after a confirmed tick.
struct Word {
    std::uint64_t tick = 0, hash = 0;
};

/// From which tick on a machine's inputs count again, and since when everybody's do (0: from the start).
struct Admission {
    std::uint32_t ticket = 0;
    std::uint64_t tick = 0;
    std::array<std::uint64_t, players_max> since{};

    friend bool operator==(const Admission&, const Admission&) = default;
};

/// The packets, as README.md specifies them.
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
/// Nothing of a packet that is not one of this match, to the bit.
std::optional<Wish> read_wish(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Stretch> read_stretch(std::span<const std::byte> packet, std::uint32_t match,
                                    std::size_t tick_bytes);
std::optional<Offer> read_offer(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Chunk> read_chunk(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Word> read_word(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Admission> read_admission(std::span<const std::byte> packet, std::uint32_t match,
                                        std::uint32_t players);
bool is_wish(std::span<const std::byte> packet);
/// One of those that answer wishes, by its first byte.
bool is_answer_to_wish(std::span<const std::byte> packet);

/// How long a tick is in the log [bytes].
inline std::size_t tick_bytes_of(const SessionDef& def) { return 6 + def.players.size() * def.input_size; }

struct TimelineDef {
    /// When the log has so many, the older half of them is forgotten. Without `keeps_unheard`: but for what a listener is on the way to,
    /// until it has eight times as many.
    std::uint64_t log_ticks_max;
    std::uint32_t delay_ticks; ///< so much later listeners see a tick
    std::uint32_t listeners_max;
    std::uint64_t silence_polls; ///< then a listener is forgotten
    bool keeps_unheard;          ///< the log is kept also while nobody listens
};

class TimelineHost {
  public:
    TimelineHost(const SessionDef& def, TimelineDef how);

    /// The confirmed ticks, one after the other (asserted).
    void add(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash);
    /// The next tick, as another host told it: of its hash the low half is known only.
    void add_told(std::uint64_t tick, std::span<const std::byte> told);
    /// A state that another host has sent.
    void set_snapshot(const Offer& offer, std::span<const std::byte> image);
    /// Whether a listener takes the state that there is, and has not done so for too long.
    bool is_snapshot_taken() const;
    /// The low half of the hash after a tick in the log; nothing of others.
    std::optional<std::uint32_t> told_hash(std::uint64_t tick) const;
    /// A listener's word. Whoever claims to have what it was not sent yet has its word ignored.
    void hear(PeerId peer, const Wish& wish);
    /// Sends each listener what is due. `states`: where states come from; null: nowhere.
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
        bool was_heard = false;             ///< since it was served last
        std::uint64_t wanted = 0, sent = 0; ///< ticks
        std::uint64_t silent_polls = 0, polls_without_progress = 0;
        std::uint64_t chunks_of = no_tick; ///< the tick of the state that it takes
        std::uint32_t chunk_next = 0, chunk_missing = 0, wishes_without_chunk = 0;
        std::uint64_t chunks_sent = 0; ///< of that state, in all
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
    std::vector<std::byte> log; ///< as Stretch tells
    /// By tick modulo history_ticks; unused where another host tells the ticks
    std::vector<std::uint64_t> hashes;
    bool is_told = false; ///< by another host
    bool has_begun = false;
    std::uint64_t first = 0; ///< tick that was added first
    std::optional<Snapshot> snapshot;
    std::uint64_t polls = 0, snapshot_at_poll = 0, made = 0;
    std::vector<Listener> all; ///< by peer
    std::vector<std::byte> packet;
    Chunk chunk;
    std::uint64_t packets = 0, bytes = 0;
};

} // namespace lockstone::session
