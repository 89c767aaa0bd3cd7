// What this machine knows of one remote machine: how far it has received, the hashes it reported, how it is doing.
#pragma once

#include "session/desync/inspection.h"
#include "session/inputs/input_queue.h"
#include "session/link/message.h"
#include "session/timeline.h"

#include <algorithm>

namespace lockstone::session {

/// Low halves of the root hashes of consecutive confirmed ticks, from both sides of a link, compared in order.
class HashLedger {
  public:
    /// Of ticks from `first` on.
    explicit HashLedger(std::uint64_t first = 0)
        : remote(history_ticks), wanted(first), compared(first), agreed_end(first), acked(first),
          sent(first) {}

    /// A report from the peer. Ticks outside the window are ignored: they come again.
    void receive(std::uint64_t tick, std::uint32_t hash);
    std::uint64_t next_wanted() const { return wanted; }

    /// Compares what both sides know; `local(tick)` gives this machine's hash of a tick below `local_end`.
    /// Returns the first tick that differs, once.
    template <class LocalHash>
    std::optional<std::uint64_t> compare(std::uint64_t local_end, LocalHash&& local) {
        std::optional<std::uint64_t> found;
        for (; compared < std::min(local_end, wanted); ++compared) {
            if (differs || local(compared) == remote[compared % history_ticks].hash) continue;
            differs = true;
            agreed_end = compared;
            found = compared;
        }
        return found;
    }
    std::uint64_t compared_through() const { return compared; }
    /// Both sides have told each other the hashes of ticks below.
    std::uint64_t exchanged_through() const { return std::min(acked, wanted); }
    std::uint64_t agreed_through() const { return differs ? agreed_end : compared; }
    std::uint32_t remote_hash(std::uint64_t tick) const { return remote[tick % history_ticks].hash; }

    // ---- sending: every hash once, then again from the first that the peer lacks when it stays silent about it ----
    void acknowledge(std::uint64_t next_hash);
    std::uint64_t acknowledged() const { return acked; }
    /// The ticks [first, first + count) to send now, of those below `local_end`.
    struct Range {
        std::uint64_t first;
        std::uint32_t count;
    };
    Range to_send(std::uint64_t local_end);

  private:
    struct Slot {
        std::uint64_t tick = never;
        std::uint32_t hash = 0;
    };
    std::vector<Slot> remote;
    std::uint64_t wanted;   ///< first tick whose remote hash is missing
    std::uint64_t compared; ///< ticks below have been compared
    std::uint64_t agreed_end;
    bool differs = false;
    std::uint64_t acked; ///< the peer has the local hashes of ticks below
    std::uint64_t sent;  ///< cursor
    std::uint32_t polls_without_progress = 0;
};

/// How far ahead of the peer this machine runs. Both sides count the same way and exchange their counts: half the
/// difference is the true lead, whatever the latency, as long as it is alike both ways.
class TimeSync {
  public:
    void sample(std::int32_t local_ahead, std::int32_t remote_ahead);
    std::int32_t ticks_ahead() const;

  private:
    static constexpr std::int32_t window = 32; ///< polls
    std::array<std::int32_t, window> leads{};
    std::int32_t sum = 0;
    std::uint32_t count = 0;
};

struct PeerLink {
    /// `begin`: the first tick that both run.
    PeerLink(PeerId id, PacketContext packets, std::uint64_t begin = 0)
        : peer(id), context(packets), hashes(begin) {
        cut.fill(never);
        next_input.fill(begin);
    }

    enum class State { connecting, connected, gone };

    PeerId peer;
    PacketContext context; ///< of packets between the two: another one since either came back
    State state = State::connecting;
    bool told_incompatible = false;
    bool has_heard_us = false;  ///< by its own word: it knows the match, short packets do
    std::uint64_t heard_ms = 0; ///< when the last good packet came that was new
    std::uint64_t sequence_sent = 0, sequence_heard = 0; ///< newest packets
    std::uint32_t packets_read = 0;                      ///< in this poll
    std::uint64_t tick = 0;                              ///< newest tick the peer told of
    /// By player: first tick whose input the peer lacks; not its own
    std::array<std::uint64_t, players_max> next_input{};

    // ---- departure.cpp: what it did to this machine's patience, and what it says of others ----
    std::uint64_t waited_ms = 0; ///< how long the match has waited for it, less what ticks made up for
    bool unwanted =
        false; ///< this machine wants it to leave: it was silent or late for too long; never taken back
    std::uint32_t says_unwanted = 0,
                  says_gone = 0;                  ///< bit p, as Message::unwanted and gone; never taken back
    std::array<std::uint64_t, players_max> cut{}; ///< by player, the lowest it told; `never`: none

    // ---- admission.cpp: how it comes (back), and what it says of others that do ----
    struct Seat {
        std::uint32_t ticket = 0; ///< that it came in with, or that nothing came of; older wishes are void
        std::uint32_t refused =
            0; ///< the last that only others spoke of and this machine said no to: void as well
        std::uint32_t wish = 0;        ///< newest ticket that this machine itself has heard it ask with
        std::uint64_t wish_ms = 0;     ///< when it did last
        std::optional<JoinWord> stand; ///< what this machine says to that
        std::uint64_t told_ms = 0,
                      stand_ms =
                          0;     ///< since when others have told of it; since when this machine has its stand
        bool is_settled = false; ///< all have agreed
        bool asks = false;       ///< in this poll
        Admission admission;     ///< what it was told
        std::uint64_t entered_ms = 0;    ///< 0: it has been there from the start
        std::uint64_t not_before_ms = 0; ///< it may ask again
    } seat;
    std::array<JoinWord, players_max> words{}; ///< by first player of the machine that comes; ticket 0: none

    HashLedger hashes;
    std::unique_ptr<Inspection> inspection; ///< once their states have parted
    bool hashes_are_lost =
        false; ///< an unwanted peer did not exchange them in time: no more are sent or compared
    TimeSync time_sync;
    std::int32_t remote_ahead = 0; ///< the peer's own count
    bool has_echo = false;
    std::uint16_t echo_ms = 0; ///< its newest clock reading
    std::uint64_t echo_received_ms = 0;
    std::uint32_t ping_ms = 0;
    std::uint32_t packets_until_quality = 0;
};

} // namespace lockstone::session
