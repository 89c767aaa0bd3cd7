// Finds where and how two recordings differ: tick, phase, column, row, field, both values.
#pragma once

#include "replay/player.h"

#include <optional>

namespace lockstone::replay {

/// One side of a comparison: a recording, and the game that it needs (see Player::open).
struct Side {
    const Recording& recording;
    const Game* game = nullptr;
};

struct DiffReport {
    std::uint64_t from = 0, to = 0; ///< times that both recordings contain
    bool states_agree = false;      ///< all recorded hashes of from..to are equal
    /// The first tick after which the recorded hashes differ; none if the states at `from` differ already.
    std::optional<std::uint64_t> tick;

    /// The first tick from `from` on whose inputs or commands differ, if any; only if both recordings have the same
    /// mode.
    std::optional<std::uint64_t> input_tick;
    std::string input_difference; ///< "player 1: input 0100 against 0000"

    /// True if re-simulation gives the recorded hash after `tick`. If false, another engine, another game or a faulty
    /// machine recorded that side.
    bool left_reproduces = true, right_reproduces = true;
    /// The phase of `tick` after which the states first differ; empty if the re-simulated states are equal.
    std::string phase;
    /// The time of the states that `differences` compares: after `tick`, or the time of the next keyframe of a side
    /// that re-simulation does not reproduce. In that case the keyframe is compared with the other side's state at
    /// that time.
    std::uint64_t compared_at = 0;
    std::vector<Difference> differences;
    bool has_more = false; ///< there are more differences than these

    std::string text; ///< the whole report in sentences, one per line
};

/// Reports at most `limit` differences. Errors: recordings that cannot be compared or played.
Result<DiffReport> diff(const Side& left, const Side& right, std::size_t limit = 8);

} // namespace lockstone::replay
