// Rows that several objects share. Most bodies and shapes of a game have equal traits: the state holds these once,
// and each object refers to the row. A row in use never changes: an object with new traits refers to another row.
#pragma once

#include "base/assert.h"
#include "lockstone/state.h"

#include <algorithm>
#include <cstring>
#include <span>

namespace lockstone::sim {

/// The number of objects that refer to a row.
struct SharedUses {
    std::uint32_t count; ///< if free: is_free plus the next free row + 1, 0: last

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

/// The number of rows that are compared before a new row is made. Worlds with more different traits share less, which
/// costs memory only; the bound keeps the creation of many different objects fast.
inline constexpr std::uint32_t shared_rows_compared = 256;

/// Returns a row that holds `value`, and adds one to its uses. `first_free`: the header's field, which the caller
/// writes back. May grow the table: references into the state then become invalid. The caller ensures that there are
/// no more uses than rows_max.
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

/// Ends one use of a row. A row without uses becomes zero, and is the next row that is taken.
template <class T>
void drop_shared(State& state, const SharedTable<T>& t, std::uint32_t row, std::uint32_t& first_free) {
    SharedUses& uses = state.edit_row(t.uses, row);
    LOCKSTONE_ASSERT(uses.is_used() && uses.count != 0, "row ", row, " is in no use");
    if (--uses.count != 0) return;
    uses.count = SharedUses::is_free | first_free;
    first_free = row + 1;
    std::memset(static_cast<void*>(&state.edit_row(t.row, row)), 0, sizeof(T));
}

/// Ends one use of `row`. Returns the row that holds `value`, and adds one to its uses. `value` must lie outside of
/// the table.
template <class T>
std::uint32_t exchange_shared(State& state, const SharedTable<T>& t, std::uint32_t row, const T& value,
                              std::uint32_t& first_free) {
    drop_shared(state, t, row, first_free);
    return take_shared(state, t, value, first_free);
}

} // namespace lockstone::sim
