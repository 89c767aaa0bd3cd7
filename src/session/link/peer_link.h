// The record of one remote machine: acknowledgements, reported hashes, votes, joins, quality of the
// connection.
#pragma once

#include "session/desync/inspection.h"
#include "session/inputs/input_queue.h"
#include "session/link/message.h"
#include "session/timeline.h"

#include <algorithm>

namespace lockstone::session {

/// Low halves of the root hashes of consecutive confirmed ticks from both sides of a link, compared in
/// order.
class HashLedger {
  public:
    /// `first`: the first tick with hashes.
    explicit HashLedger(std::uint64_t first = 0)
        : remote(history_ticks), wanted(first), compared(first), agreed_end(first), acked(first),
          sent(first) {}

    /// Stores a hash of the peer. A tick outside the window is ignored; the peer sends it again.
    void receive(std::uint64_t tick, std::uint32_t hash);
    std::uint64_t next_wanted() const { return wanted; }

    /// Compares the hashes that both sides have. `local(tick)`: this machine's hash of a tick below
    /// `local_end`. Returns the first different tick, exactly once.
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
    /// Both sides have received the other's hashes of ticks below.
    std::uint64_t exchanged_through() const { return std::min(acked, wanted); }
    std::uint64_t agreed_through() const { return differs ? agreed_end : compared; }
    std::uint32_t remote_hash(std::uint64_t tick) const { return remote[tick % history_ticks].hash; }

    // ---- sending: each hash once; without progress, again from the first unacknowledged one on ----
    void acknowledge(std::uint64_t next_hash);
    std::uint64_t acknowledged() const { return acked; }
    /// The ticks [first, first + count) to send now, all below `local_end`.
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
    std::uint64_t wanted;   ///< first tick without a hash of the peer
    std::uint64_t compared; ///< ticks below are compared
    std::uint64_t agreed_end;
    bool differs = false;
    std::uint64_t acked; ///< the peer has the local hashes of ticks below
    std::uint64_t sent;  ///< first tick to send next
    std::uint32_t polls_without_progress = 0;
};

/// The lead of this machine over the peer [ticks]. Both sides measure in the same way and exchange their
/// values: half of the difference is the true lead, independent of the latency, if the latency is equal in
/// both directions.
class TimeSync {
  public:
    void sample(std::int32_t local_ahead, std::int32_t remote_ahead);
    std::int32_t ticks_ahead() const;

  private:
    static constexpr std::int32_t window = 32; ///< [polls]
    std::array<std::int32_t, window> leads{};
    std::int32_t sum = 0;
    std::uint32_t count = 0;
};

struct PeerLink {
    /// `begin`: the first tick that both machines run.
    PeerLink(PeerId id, PacketContext packets, std::uint64_t begin = 0)
        : peer(id), context(packets), hashes(begin) {
        cut.fill(never);
        next_input.fill(begin);
    }

    enum class State { connecting, connected, gone };

    PeerId peer;
    PacketContext context; ///< of packets between the two machines; changes when one of them joins
    State state = State::connecting;
    bool told_incompatible = false;
    bool has_heard_us = false;  ///< as the peer reported: it knows the match, so short packets are enough
    std::uint64_t heard_ms = 0; ///< time of the newest valid packet [ms]
    std::uint64_t sequence_sent = 0, sequence_heard = 0; ///< numbers of the newest packets
    std::uint32_t packets_read = 0;                      ///< in this poll
    std::uint64_t tick = 0;                              ///< the peer's newest reported tick
    /// [player] first tick whose input the peer lacks; not for its own players.
    std::array<std::uint64_t, players_max> next_input{};

    // ---- departure.cpp: delays by this peer, and its votes and cuts ----
    std::uint64_t waited_ms = 0; ///< time that the match waited for it, less a credit for each tick [ms]
    /// This machine votes for the peer to leave: it was silent or late for too long. Final.
    bool unwanted = false;
    /// Bit p, as Message::unwanted and gone. Final.
    std::uint32_t says_unwanted = 0, says_gone = 0;
    std::array<std::uint64_t, players_max> cut{}; ///< [player] the lowest announced cut; `never`: none

    // ---- admission.cpp: joins of this peer, and its messages about joins of others ----
    struct Seat {
        /// Ticket of the last join or of the last failed request; requests up to it are void.
        std::uint32_t ticket = 0;
        /// The last ticket that this machine refused and knew only from others; void as well.
        std::uint32_t refused = 0;
        std::uint32_t wish = 0;        ///< newest ticket that this machine received from the peer itself
        std::uint64_t wish_ms = 0;     ///< time of the last request with it [ms]
        std::optional<JoinWord> stand; ///< this machine's answer
        /// Time of the first message of others about it, and time of this machine's answer [ms].
        std::uint64_t told_ms = 0, stand_ms = 0;
        bool is_settled = false;         ///< all have agreed
        bool asks = false;               ///< requested in this poll
        Admission admission;             ///< the agreement
        std::uint64_t entered_ms = 0;    ///< time of the last join [ms]; 0: present from the start
        std::uint64_t not_before_ms = 0; ///< no new join before this time [ms]
    } seat;
    /// [first player of a joining machine] the peer's answer to its request; ticket 0: none.
    std::array<JoinWord, players_max> words{};

    HashLedger hashes;
    std::unique_ptr<Inspection> inspection; ///< not null after a desync with this peer
    /// Exchange of hashes has ended, because this peer, voted against, was too late with them.
    bool hashes_are_lost = false;
    TimeSync time_sync;
    std::int32_t remote_ahead = 0; ///< the peer's tick minus the newest tick of this machine that it knew
    bool has_echo = false;
    std::uint16_t echo_ms = 0; ///< the peer's newest clock reading
    std::uint64_t echo_received_ms = 0;
    std::uint32_t ping_ms = 0;
    std::uint32_t packets_until_quality = 0;
};

} // namespace lockstone::session
