// Compares a mode with the reference mode, tick by tick, and names the first difference.
#pragma once

#include "modes.h"

namespace worlds {

/// The result of a run of a story: hashes of the whole state and of the outputs, after each tick.
struct Course {
    std::vector<std::uint64_t> states, outputs;
    testing::PathSet paths; ///< of all ticks
    /// Hash of all of it.
    std::uint64_t digest() const;
};
Course run(const Story& story, const Mode& mode);

struct Departure {
    std::uint64_t tick; ///< the first tick after which the two differ
    std::string about;  ///< phase, column, row and field, or the output that differs
};
/// Compares a mode with the expected course. Returns nothing if they are equal. Runs the mode to its first difference,
/// and both again to find the place of the difference. Adds the execution paths of the mode to `paths`.
std::optional<Departure> departure(const Story& story, const Course& expected, const Mode& mode,
                                   testing::PathSet* paths = nullptr);
/// Returns the first tick after which a mode differs from the reference, or nothing.
std::optional<std::uint64_t> first_tick_apart(const Story& story, const Mode& mode);

} // namespace worlds
