// The memory block of a state. Edits and resizes mark the pages that they write.
#include "lockstone/state.h"

#include "base/assert.h"
#include "state/pages.h"

#include <algorithm>
#include <cstring>
#include <new>

namespace lockstone {

namespace detail {

namespace {
constexpr std::align_val_t block_alignment{64};
}

/// At least one byte, so that the block of an empty layout is an object too.
Block::Block(std::size_t size)
    : memory(static_cast<std::byte*>(::operator new(std::max<std::size_t>(size, 1), block_alignment))) {}

void Block::Free::operator()(std::byte* p) const { ::operator delete(p, block_alignment); }

} // namespace detail

namespace {
#ifdef LOCKSTONE_MOVE_STATE
constexpr bool moves_by_default = true;
#else
constexpr bool moves_by_default = false;
#endif

detail::Owner new_owner() { return std::make_shared<const std::byte>(); }
} // namespace

State::State(std::shared_ptr<const StateLayout> layout)
    : shared_layout(std::move(layout)), owner(new_owner()), moves_at_every_chance(moves_by_default) {
    LOCKSTONE_ASSERT(shared_layout != nullptr && shared_layout->is_finished(),
                     "a State needs a finished layout");
    block = detail::Block(shared_layout->size_bytes());
    std::memset(block.get(), 0, shared_layout->size_bytes());
    const std::size_t pages = shared_layout->page_count(), columns = shared_layout->columns().size();
    versions.pages.assign(pages, 0);
    versions.chunks.assign(pages / StateLayout::pages_per_chunk, 0);
    versions.columns.assign(columns, 0);
    hashes.page.assign(pages + 1, 0);
    hashes.column.assign(columns, 0);
    hashes.of = versions;
    std::ranges::fill(versions.columns, ++version_last);
}

/// The versions and hashes stay valid in the copy. The copy has its own owner, which gives out its new versions.
State::State(const State& other)
    : shared_layout(other.shared_layout), block(shared_layout->size_bytes()), owner(new_owner()),
      versions(other.versions), version_last(other.version_last),
      moves_at_every_chance(other.moves_at_every_chance), hashes(other.hashes) {
    std::memcpy(block.get(), other.block.get(), shared_layout->size_bytes());
}

State& State::operator=(const State& other) {
    if (this == &other) return *this;
    if (shared_layout == nullptr) return *this = State(other); // `this` was moved from
    LOCKSTONE_ASSERT(shared_layout->schema_hash() == other.shared_layout->schema_hash(),
                     "states of different schemas");
    make_room_for(other.counts());
    const std::span<const StateLayout::Placement> places = shared_layout->placements();
    for (std::uint32_t column = 0; column < places.size(); ++column) {
        const std::span<const std::byte> from = other.bytes(column);
        std::byte* const to = block.get() + places[column].offset;
        const std::size_t before = bytes(column).size();
        if (!from.empty()) std::memcpy(to, from.data(), from.size());
        if (before > from.size()) std::memset(to + from.size(), 0, before - from.size());
    }
    std::ranges::copy(other.counts(), counts().begin());
    forget_all();
    return *this;
}

/// Gives every live page and every column a version that was never given out, as they may hold anything.
void State::forget_all() {
    ++version_last;
    const std::span<const StateLayout::Placement> places = shared_layout->placements();
    std::ranges::fill(versions.pages, 0);
    std::ranges::fill(versions.chunks, version_last);
    std::ranges::fill(versions.columns, version_last);
    for (const StateLayout::Placement& place : places)
        std::fill_n(versions.pages.data() + place.first_page, pages_of(place, counts()[place.table]),
                    version_last);
}

/// Gives pages of a column a version that was never given out.
void State::mark(std::uint32_t column, std::size_t first_page, std::size_t end_page) {
    constexpr std::size_t step = StateLayout::pages_per_chunk;
    const std::uint64_t version = ++version_last;
    const std::size_t first = shared_layout->placements()[column].first_page + first_page;
    const std::size_t end = shared_layout->placements()[column].first_page + end_page;
    for (std::size_t page = first; page < end; ++page) versions.pages[page] = version;
    for (std::size_t chunk = first / step; chunk * step < end; ++chunk) versions.chunks[chunk] = version;
    versions.columns[column] = version;
}

/// mark() for one page.
inline void State::mark_page(std::uint32_t column, std::size_t page) {
    const std::uint64_t version = ++version_last;
    versions.pages[page] = version;
    versions.chunks[page / StateLayout::pages_per_chunk] = version;
    versions.columns[column] = version;
}

std::span<std::byte> State::edit_row_bytes(std::uint32_t column, std::uint32_t row) {
    const StateLayout::Placement& place = shared_layout->placements()[column];
    if (row >= counts()[place.table]) [[unlikely]]
        return edit_bytes(column, row, 1); // ends the program
    mark_page(column, place.first_page + row / place.rows_per_page);
    return {block.get() + place.offset + std::size_t{row} * place.row_size, place.row_size};
}

std::span<std::byte> State::edit_bytes(std::uint32_t column) {
    const StateLayout::Placement& place = shared_layout->placements()[column];
    const std::uint32_t live = counts()[place.table];
    mark(column, 0, pages_of(place, live));
    return {block.get() + place.offset, std::size_t{live} * place.row_size};
}

std::span<std::byte> State::edit_bytes(std::uint32_t column, std::uint32_t first_row, std::uint32_t count) {
    const StateLayout::Placement& place = shared_layout->placements()[column];
    const std::uint32_t live = counts()[place.table];
    LOCKSTONE_ASSERT(first_row <= live && count <= live - first_row, "rows ", first_row, " and ", count,
                     " from it of ", live, " in column ", shared_layout->columns()[column].name);
    if (count != 0)
        mark(column, first_row / place.rows_per_page, (first_row + (count - 1)) / place.rows_per_page + 1);
    return {block.get() + place.offset + std::size_t{first_row} * place.row_size,
            std::size_t{count} * place.row_size};
}

void State::resize(TableId table, std::uint32_t rows) {
    LOCKSTONE_ASSERT(table.index < counts().size(), "table ", table.index, " of ", counts().size());
    LOCKSTONE_ASSERT(rows <= rows_max(table), "table ", shared_layout->tables()[table.index].name, ": ", rows,
                     " rows, capacity ", rows_max(table));
    const std::uint32_t old = counts()[table.index];
    if (rows == old) return;
    if (moves_at_every_chance) move_block();
    if (rows > capacity(table)) make_room({table}, rows - old);
    counts()[table.index] = rows;
    // Most objects come and go one by one.
    if (rows == old + 1) return mark_new_row(table);
    if (rows + 1 == old) return clear_old_row(table);
    for (const std::uint32_t column : shared_layout->columns_of(table)) {
        const StateLayout::Placement& place = shared_layout->placements()[column];
        // The set of live rows of a page that was or is partly filled changes, even if its bytes do not.
        const std::size_t now = pages_of(place, rows), before = pages_of(place, old);
        mark(column, std::min(rows, old) / place.rows_per_page, std::max(now, before));
        if (rows > old) continue; // rows that are not live are zero already
        std::memset(block.get() + place.offset + std::size_t{rows} * place.row_size, 0,
                    std::size_t{old - rows} * place.row_size);
        std::fill_n(versions.pages.data() + place.first_page + now, before - now, 0);
    }
}

/// The last row is new. Its page gets a new version.
void State::mark_new_row(TableId table) {
    const std::uint32_t row = counts()[table.index] - 1;
    for (const std::uint32_t column : shared_layout->columns_of(table)) {
        const StateLayout::Placement& place = shared_layout->placements()[column];
        mark_page(column, place.first_page + row / place.rows_per_page);
    }
}

/// The row after the last was live. It becomes zero. Its page gets a new version, or 0 if no row of it is live.
void State::clear_old_row(TableId table) {
    const std::uint32_t row = counts()[table.index];
    for (const std::uint32_t column : shared_layout->columns_of(table)) {
        const StateLayout::Placement& place = shared_layout->placements()[column];
        const std::size_t page = place.first_page + row / place.rows_per_page;
        mark_page(column, page);
        std::memset(block.get() + place.offset + std::size_t{row} * place.row_size, 0, place.row_size);
        if (row % place.rows_per_page == 0) versions.pages[page] = 0;
    }
}

} // namespace lockstone
