// Where and how two recordings part: tick, phase, column, row, field, both values.
#pragma once

#include "replay/player.h"

#include <optional>

namespace lockstone::replay {

/// One side of a comparison: a recording and what it needs to be played (see Player::open).
struct Side {
    const Recording& recording;
    const Game* game = nullptr;
};

struct DiffReport {
    std::uint64_t from = 0, to = 0; ///< times that both recordings hold
    bool states_agree = false;      ///< all recorded hashes of from..to are equal
    /// The first tick after which the recorded hashes differ; none when the states at `from` differ already.
    std::optional<std::uint64_t> tick;

    /// The first tick from `from` on whose inputs or commands differ, if any, and how; only when both are of one mode.
    std::optional<std::uint64_t> input_tick;
    std::string input_difference; ///< "player 1: input 0100 against 0000"

    /// Whether re-simulation gives the recorded hash after `tick`. Where it does not, that side was recorded by
    /// another engine, game or a faulty machine.
    bool left_reproduces = true, right_reproduces = true;
    /// The phase of `tick` after which the states differ first; empty when the re-simulated states never do.
    std::string phase;
    /// Time of the states that `differences` compares: after `tick`, or that of the next keyframe of a side that does not
    /// reproduce (its own words, and the other side's state at that time).
    std::uint64_t compared_at = 0;
    std::vector<Difference> differences;
    bool has_more = false; ///< there are further differences than those

    std::string text; ///< all of this in sentences, one a line
};

/// At most `limit` differences. Errors: recordings that cannot be compared or played.
Result<DiffReport> diff(const Side& left, const Side& right, std::size_t limit = 8);

} // namespace lockstone::replay
