// Re-simulates a recording and compares every tick's hash and every keyframe's bytes with what was recorded.
// Threads or shards share the work.
#pragma once

#include "lockstone/tasks.h"
#include "replay/player.h"

#include <atomic>
#include <optional>

namespace lockstone::replay {

struct VerifyOptions {
    /// More than one: that many threads, each from keyframe to keyframe. Then the game is used by several at once. They
    /// share the recording's limit of memory: as many work as fit into it.
    std::uint32_t jobs = 1;
    std::uint32_t threads = 1; ///< of each job, that share the work of a tick: 1 to workers_max
    /// Which of `shards` parts of the segments to verify, 0 .. shards - 1: for spreading one recording over machines.
    std::uint32_t shard = 0, shards = 1;
    /// Restore every keyframe even when one thread verifies all. Without it the run is one, straight from the start.
    bool from_keyframes = false;
    std::atomic<std::uint64_t>* ticks_done = nullptr; ///< counted up while at work, for progress bars
};

enum class Verdict {
    good,       ///< all that was compared agrees, and something was compared
    diverged,   ///< a tick or a keyframe differs
    incomplete, ///< what is there agrees, but the recording was cut or damaged
    vacuous,    ///< there was nothing to compare
    unusable,   ///< this game, this engine or these options cannot play it
};
std::string_view name_of(Verdict verdict);

struct VerifyReport {
    Verdict verdict = Verdict::unusable;
    std::uint64_t ticks = 0;              ///< re-simulated
    std::uint64_t hashes_compared = 0;    ///< of ticks, and of the states that segments start from
    std::uint64_t keyframes_compared = 0; ///< byte by byte
    /// The first tick whose state differs from the recorded one, when diverged; the start tick when the start does.
    std::optional<std::uint64_t> first_bad_tick;
    std::string sentence; ///< names the file, and for anything but good the reason
    bool good() const { return verdict == Verdict::good; }
};

/// The parts that can be verified apart from each other: from a keyframe to the next, or to the end. What they cover
/// together is the whole, since a segment ends by comparing the keyframe that the next one starts from.
std::size_t segment_count(const Recording& recording);

/// `game` as for Player::open.
VerifyReport verify(const Recording& recording, const Game* game, const VerifyOptions& options = {});

} // namespace lockstone::replay
