// Pages of a column: the unit of the hash tree, of what edits mark and of what
// images copy.
#pragma once

#include "lockstone/state.h"

#include <algorithm>

namespace lockstone {

/// Columns begin on a cache line, in the block and in images.
constexpr std::size_t whole_lines(std::size_t size) { return (size + 63) / 64 * 64; }

/// How many pages hold `rows` rows.
inline std::size_t pages_of(const StateLayout::Placement& column, std::uint32_t rows) {
    return rows / column.rows_per_page + (rows % column.rows_per_page != 0 ? 1 : 0);
}

inline std::size_t page_bytes(const StateLayout::Placement& column) {
    return std::size_t{column.rows_per_page} * column.row_size;
}

/// Visits the live pages of a column whose versions differ, in order, and takes over the versions. A chunk or a column
/// of the same version is passed over as a whole.
template <class Visit>
void take_versions(const StateLayout& layout, std::size_t column, std::uint32_t rows,
                   const detail::Versions& from, detail::Versions& to, Visit&& visit) {
    if (from.columns[column] == to.columns[column]) return;
    to.columns[column] = from.columns[column];
    constexpr std::size_t step = StateLayout::pages_per_chunk;
    const StateLayout::Placement& place = layout.placements()[column];
    const std::size_t pages = pages_of(place, rows);
    for (std::size_t first = 0; first < pages; first += step) {
        const std::size_t chunk = (place.first_page + first) / step;
        if (from.chunks[chunk] == to.chunks[chunk]) continue;
        to.chunks[chunk] = from.chunks[chunk];
        for (std::size_t page = first; page < std::min(first + step, pages); ++page) {
            const std::size_t at = place.first_page + page;
            if (from.pages[at] == to.pages[at]) continue;
            to.pages[at] = from.pages[at];
            visit(page);
        }
    }
}

} // namespace lockstone
