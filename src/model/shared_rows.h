// Rows that many objects share. Most bodies and shapes of a game are alike: what they are like stands in the state once, and
// each names the row. A row that is in use never changes: what is no longer like it takes another one.
#pragma once

#include "base/assert.h"
#include "lockstone/state.h"

#include <algorithm>
#include <cstring>
#include <span>

namespace lockstone::sim {

/// How many objects name a row.
struct SharedUses {
    std::uint32_t count; ///< while free: is_free, and the next free row + 1, 0: last

    static constexpr std::uint32_t is_free = 0x80000000u; ///< bit
    constexpr bool is_used() const { return (count & is_free) == 0; }
    constexpr std::uint32_t next_free() const { return count & ~is_free; }
};
template <class V> constexpr void describe(SharedUses& u, V&& v) { v("count", u.count); }

template <class T> struct SharedTable {
    TableId table;
    Column<T> row;
    Column<SharedUses> uses;
};

/// Rows that are compared before one more is made. Worlds with more kinds of things than that share less; that costs memory
/// alone, and a bound keeps making many of them fast.
inline constexpr std::uint32_t shared_rows_compared = 256;

/// A row that holds `value`, with one use more. `first_free`: the header's, which the caller writes back. May grow the table: references
/// into the state end then. The caller makes sure that there are no more uses than rows_max.
template <class T>
std::uint32_t take_shared(State& state, const SharedTable<T>& t, const T& value, std::uint32_t& first_free) {
    const std::span<const T> rows = state.rows(t.row);
    const std::span<const SharedUses> uses = state.rows(t.uses);
    const std::uint32_t count = static_cast<std::uint32_t>(rows.size());
    for (std::uint32_t row = 0; row < std::min(count, shared_rows_compared); ++row)
        if (uses[row].is_used() && std::memcmp(&rows[row], &value, sizeof value) == 0) {
            ++state.edit_row(t.uses, row).count;
            return row;
        }
    std::uint32_t row = count;
    if (first_free != 0) {
        row = first_free - 1;
        first_free = uses[row].next_free();
    } else {
        state.resize(t.table, count + 1);
    }
    state.edit_row(t.row, row) = value;
    state.edit_row(t.uses, row).count = 1;
    return row;
}

/// Ends one use of a row. A row that nobody uses becomes zero, and is the next that is taken.
template <class T>
void drop_shared(State& state, const SharedTable<T>& t, std::uint32_t row, std::uint32_t& first_free) {
    SharedUses& uses = state.edit_row(t.uses, row);
    LOCKSTONE_ASSERT(uses.is_used() && uses.count != 0, "row ", row, " is in no use");
    if (--uses.count != 0) return;
    uses.count = SharedUses::is_free | first_free;
    first_free = row + 1;
    std::memset(static_cast<void*>(&state.edit_row(t.row, row)), 0, sizeof(T));
}

/// Ends one use of `row`, and returns the row that holds `value`, with one use more. `value` lies outside of the table.
template <class T>
std::uint32_t exchange_shared(State& state, const SharedTable<T>& t, std::uint32_t row, const T& value,
                              std::uint32_t& first_free) {
    drop_shared(state, t, row, first_free);
    return take_shared(state, t, value, first_free);
}

} // namespace lockstone::sim
