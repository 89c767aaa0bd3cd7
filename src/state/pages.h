// Pages of a column: the unit of the hash tree, of what edits mark and of what
// images copy.
#pragma once

#include "lockstone/state.h"

#include <algorithm>

namespace lockstone {

/// Without NDEBUG every hash and image first compares the pages with their versions.
#ifdef NDEBUG
inline constexpr bool checks_versions = false;
#else
inline constexpr bool checks_versions = true;
#endif

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
/// of the same version is passed over as a whole. The column may stand at another place in each layout.
template <class Visit>
void take_versions(const StateLayout::Placement& from_place, const StateLayout::Placement& to_place,
                   std::size_t column, std::uint32_t rows, const detail::Versions& from, detail::Versions& to,
                   Visit&& visit) {
    if (from.columns[column] == to.columns[column]) return;
    to.columns[column] = from.columns[column];
    constexpr std::size_t step = StateLayout::pages_per_chunk;
    const std::size_t pages = pages_of(from_place, rows);
    for (std::size_t first = 0; first < pages; first += step) {
        const std::uint64_t chunk = from.chunks[(from_place.first_page + first) / step];
        std::uint64_t& to_chunk = to.chunks[(to_place.first_page + first) / step];
        if (chunk == to_chunk) continue;
        to_chunk = chunk;
        for (std::size_t page = first; page < std::min(first + step, pages); ++page) {
            const std::uint64_t version = from.pages[from_place.first_page + page];
            std::uint64_t& to_version = to.pages[to_place.first_page + page];
            if (version == to_version) continue;
            to_version = version;
            visit(page);
        }
    }
}

/// A value for each page, or each chunk of pages, of one layout, as one for each of a layout of the same schema: those of
/// pages that only the latter has are 0.
std::vector<std::uint64_t> moved(const std::vector<std::uint64_t>& values, const StateLayout& from,
                                 const StateLayout& to, std::size_t pages_per_value);
void move_versions(detail::Versions& versions, const StateLayout& from, const StateLayout& to);

} // namespace lockstone
