// Re-simulates a recording, and compares every tick's hash and every keyframe's bytes with the recorded ones. Threads
// or shards share the work.
#pragma once

#include "lockstone/tasks.h"
#include "replay/player.h"

#include <atomic>
#include <optional>

namespace lockstone::replay {

struct VerifyOptions {
    /// If more than 1: the number of threads. Each thread verifies from one keyframe to the next. Several threads
    /// then use the game at the same time. They share the recording's memory limit, so no more of them run than fit
    /// into it.
    std::uint32_t jobs = 1;
    std::uint32_t threads = 1; ///< threads of each job that share the work of a tick: 1 to workers_max
    /// Index of the part to verify, 0 .. shards - 1, of `shards` parts of the segments: to distribute one recording
    /// over machines.
    std::uint32_t shard = 0, shards = 1;
    /// Restores every keyframe even if one thread verifies everything. If false, that thread runs from the start to
    /// the end without a restore.
    bool from_keyframes = false;
    std::atomic<std::uint64_t>* ticks_done = nullptr; ///< incremented during the work, for progress bars
};

enum class Verdict {
    good,       ///< everything that was compared agrees, and at least one tick was compared
    diverged,   ///< a tick or a keyframe differs
    incomplete, ///< the ticks that exist agree, but the recording was cut or damaged
    vacuous,    ///< no tick was compared
    unusable,   ///< this game, engine or set of options cannot play it
};
std::string_view name_of(Verdict verdict);

struct VerifyReport {
    Verdict verdict = Verdict::unusable;
    std::uint64_t ticks = 0;              ///< re-simulated
    std::uint64_t hashes_compared = 0;    ///< of ticks, and of the states from which segments start
    std::uint64_t keyframes_compared = 0; ///< byte by byte
    /// If diverged: the first tick whose state differs from the recorded one, or the start tick if the start differs.
    std::optional<std::uint64_t> first_bad_tick;
    std::string sentence; ///< contains the file's name and, unless the verdict is good, the reason
    bool good() const { return verdict == Verdict::good; }
};

/// The number of segments, which can be verified independently: from a keyframe to the next, or to the end. Together
/// they cover the whole recording, as a segment ends with a comparison of the keyframe from which the next one
/// starts.
std::size_t segment_count(const Recording& recording);

/// `game`: as for Player::open.
VerifyReport verify(const Recording& recording, const Game* game, const VerifyOptions& options = {});

} // namespace lockstone::replay
