// A contact of two shapes in one tick, as events tell it, and whether the two touch.
#pragma once

#include "base/paths.h"
#include "lockstone/tasks.h"
#include "model/contact_rows.h"

#include <span>

namespace lockstone::sim {

/// What a tick finds out about a pair that has contact points, or touched until now.
struct ContactResult {
    ContactResult() {
    } ///< `key` is not set; the rest number by number, which a value of zeros would be once more

    ContactKey key;
    std::uint32_t flags = 0;                    ///< solve::ContactFlags of the pair
    std::uint32_t old_first = 0, old_count = 0; ///< its rows in the contact table of the last tick
    /// In that of this tick; none: it has no points, or there was no room
    std::uint32_t first_row = 0, row_count = 0;
    bool is_kept = false;      ///< its rows are those of the last tick
    bool was_touching = false; ///< when the last tick ended
    /// From collide() on: whether it is near enough. From settle_touching() on: whether it touches, which it also does when the
    /// solver had to stop it.
    bool is_touching = false;
    std::uint32_t deepest_row = 0; ///< of the pair's rows, the one with the deepest point
    // Of the deepest point, unless the pair was touching:
    UnitVec3 normal{}; ///< key a to key b
    Vec3 point{};      ///< world
    Speed approach{};  ///< [m/s], positive when closing
};

/// Of the first row of a pair: whether the pair touched when the last tick ended. False of its other rows. Nothing but this and
/// settle_touching() knows where the state has that.
inline bool touched(const ContactMemory& first_row) {
    return (first_row.flags & solve::contact_touching) != 0;
}

/// Settles which pairs touch, after the solver, and puts it into the table for the next tick. Which points the solver had to stop is
/// forgotten.
void settle_touching(std::span<ContactResult> results, ContactList& table, const base::Paths& paths,
                     Tasks* tasks = nullptr);

} // namespace lockstone::sim
