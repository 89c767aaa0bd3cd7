// Pages of a column: the unit of the hash tree, of the marks of edits and of the copies of images.
#pragma once

#include "lockstone/state.h"

#include <algorithm>

namespace lockstone {

/// Without NDEBUG, every hash and image first checks the pages against their versions.
#ifdef NDEBUG
inline constexpr bool checks_versions = false;
#else
inline constexpr bool checks_versions = true;
#endif

/// Columns begin on a cache line, in the block and in images.
constexpr std::size_t whole_lines(std::size_t size) { return (size + 63) / 64 * 64; }

/// The number of pages that hold `rows` rows.
inline std::size_t pages_of(const StateLayout::Placement& column, std::uint32_t rows) {
    return rows / column.rows_per_page + (rows % column.rows_per_page != 0 ? 1 : 0);
}

inline std::size_t page_bytes(const StateLayout::Placement& column) {
    return std::size_t{column.rows_per_page} * column.row_size;
}

/// Visits the live pages of a column whose versions differ, in order, and copies the versions. Skips a chunk or a
/// column with equal versions as a whole. The column may have another place in each of the two layouts.
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

/// Converts a list of values for each page, or each chunk of pages, from one layout to another one of the same
/// schema. Pages that only the new layout has get 0.
std::vector<std::uint64_t> moved(const std::vector<std::uint64_t>& values, const StateLayout& from,
                                 const StateLayout& to, std::size_t pages_per_value);
void move_versions(detail::Versions& versions, const StateLayout& from, const StateLayout& to);

} // namespace lockstone
