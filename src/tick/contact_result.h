// The result of a tick for a pair of shapes, as events report it, and the flag that says if the two touch.
#pragma once

#include "base/paths.h"
#include "lockstone/tasks.h"
#include "model/contact_rows.h"

#include <span>

namespace lockstone::sim {

/// The result of a tick for a pair that has contact points, or that touched at the end of the last tick.
struct ContactResult {
    ContactResult() {
    } ///< leaves `key` unset; `ContactResult() = default` would zero the whole object before the members are set

    ContactKey key;
    std::uint32_t flags = 0;                    ///< solve::ContactFlags of the pair
    std::uint32_t old_first = 0, old_count = 0; ///< its rows in the contact table of the last tick
    /// Its rows in the table of this tick. row_count is 0 if the pair has no points or the table had no room.
    std::uint32_t first_row = 0, row_count = 0;
    bool is_kept = false;      ///< its rows are those of the last tick
    bool was_touching = false; ///< when the last tick ended
    /// After collide(): the deepest point is near enough to count as touching. After settle_touching(): the pair
    /// touches, which is also true if the solver had to stop one of its points.
    bool is_touching = false;
    std::uint32_t deepest_row = 0; ///< the index, among the pair's rows, of the row with the deepest point
    // The next three describe the deepest point; they are not set if the pair was touching:
    UnitVec3 normal{}; ///< key a to key b
    Vec3 point{};      ///< world
    Speed approach{};  ///< [m/s], positive when closing
};

/// Returns true if the pair touched when the last tick ended. `first_row` is the pair's first row; other rows give
/// false. Only this function and settle_touching() access the flag in which the state stores this.
inline bool touched(const ContactMemory& first_row) {
    return (first_row.flags & solve::contact_touching) != 0;
}

/// Decides after the solver which pairs touch, and stores this in the table for the next tick. Clears the flags of
/// the points that the solver had to stop.
void settle_touching(std::span<ContactResult> results, ContactList& table, const base::Paths& paths,
                     Tasks* tasks = nullptr);

} // namespace lockstone::sim
