// Growth of tables. The capacity is not part of the content of a state: rows and their versions move to their places
// in a larger block, and all hashes and versions stay valid.
#include "base/assert.h"
#include "lockstone/state.h"
#include "state/pages.h"

#include <algorithm>
#include <cstring>

namespace lockstone {

namespace {

std::vector<std::uint32_t> capacities_of(const StateLayout& layout) {
    std::vector<std::uint32_t> capacities;
    for (const TableInfo& table : layout.tables()) capacities.push_back(table.capacity);
    return capacities;
}

} // namespace

std::vector<std::uint64_t> moved(const std::vector<std::uint64_t>& values, const StateLayout& from,
                                 const StateLayout& to, std::size_t pages_per_value) {
    std::vector<std::uint64_t> out(to.page_count() / pages_per_value, 0);
    const std::span<const StateLayout::Placement> places = from.placements();
    for (std::size_t c = 0; c < places.size(); ++c) {
        const std::size_t end = c + 1 < places.size() ? places[c + 1].first_page : from.page_count(),
                          count = (end - places[c].first_page) / pages_per_value;
        std::copy_n(values.data() + places[c].first_page / pages_per_value, count,
                    out.data() + to.placements()[c].first_page / pages_per_value);
    }
    return out;
}

void move_versions(detail::Versions& versions, const StateLayout& from, const StateLayout& to) {
    versions.pages = moved(versions.pages, from, to, 1);
    versions.chunks = moved(versions.chunks, from, to, StateLayout::pages_per_chunk);
}

/// `layout`: no table has less capacity than before.
void State::grow(std::shared_ptr<const StateLayout> layout) {
    const StateLayout &from = *shared_layout, &to = *layout;
    detail::Block larger(to.size_bytes());
    // Copies what is used, and clears only the bytes between.
    std::size_t done = counts().size_bytes();
    if (done != 0) std::memcpy(larger.get(), block.get(), done);
    for (std::uint32_t column = 0; column < from.columns().size(); ++column)
        if (const std::span<const std::byte> rows = bytes(column); !rows.empty()) {
            const std::size_t begin = to.placements()[column].offset;
            std::memset(larger.get() + done, 0, begin - done);
            std::memcpy(larger.get() + begin, rows.data(), rows.size());
            done = begin + rows.size();
        }
    std::memset(larger.get() + done, 0, to.size_bytes() - done);
    move_versions(versions, from, to);
    move_versions(hashes.of, from, to);
    hashes.page = moved(hashes.page, from, to, 1);
    hashes.page.push_back(0); // room for one value after the last
    block = std::move(larger);
    shared_layout = std::move(layout);
}

/// Moves the block to another address; the rows keep their offsets.
void State::move_block() {
    const std::size_t size = shared_layout->size_bytes();
    // A large block moves at one chance in 16 only, because its copy takes longer than a tick.
    constexpr std::size_t large = std::size_t{1} << 18;
    if (size > large && version_last % 16 != 0) return;
    detail::Block other(size);
    std::memcpy(other.get(), block.get(), size);
    std::memset(block.get(), 0xa5, size);
    constexpr std::size_t kept = 8;
    if (left_blocks.size() == kept) left_blocks.erase(left_blocks.begin());
    left_blocks.push_back(std::move(block));
    block = std::move(other);
}

void State::reserve(std::span<const std::uint32_t> wanted) {
    if (moves_at_every_chance) move_block();
    std::vector<std::uint32_t> capacities = capacities_of(*shared_layout);
    LOCKSTONE_ASSERT(wanted.size() == capacities.size(), wanted.size(), " capacities for ", capacities.size(),
                     " tables");
    bool grows = false;
    for (std::size_t table = 0; table < capacities.size(); ++table) {
        grows |= wanted[table] > capacities[table];
        capacities[table] = std::max(capacities[table], wanted[table]);
    }
    if (grows) grow(shared_layout->with_capacities(capacities));
}

/// Grows to these capacities. A growth moves all tables, so those that are nearly full grow too: objects have rows in
/// several tables, which else would grow one shortly after the other.
void State::grow_to(std::vector<std::uint32_t>& capacities) {
    for (std::uint32_t table = 0; table < capacities.size(); ++table) {
        const TableInfo& info = shared_layout->tables()[table];
        const std::uint64_t rows = counts()[table];
        if (capacities[table] == info.capacity && 8 * rows > std::uint64_t{7} * info.capacity &&
            info.capacity < info.rows_max)
            capacities[table] = info.grown(info.capacity + 1);
    }
    grow(shared_layout->with_capacities(capacities));
}

void State::make_room(std::initializer_list<TableId> tables, std::uint32_t more) {
    if (moves_at_every_chance) move_block();
    const auto wanted = [&](TableId table) {
        return static_cast<std::uint32_t>(
            std::min<std::uint64_t>(std::uint64_t{count(table)} + more, rows_max(table)));
    };
    if (std::ranges::all_of(tables, [&](TableId table) { return wanted(table) <= capacity(table); })) return;
    std::vector<std::uint32_t> capacities = capacities_of(*shared_layout);
    for (const TableId table : tables)
        capacities[table.index] = shared_layout->tables()[table.index].grown(wanted(table));
    grow_to(capacities);
}

void State::make_room_for(std::initializer_list<TableRows> tables) {
    if (moves_at_every_chance) move_block();
    if (std::ranges::all_of(tables, [&](const TableRows& t) { return t.rows <= capacity(t.table); })) return;
    std::vector<std::uint32_t> capacities = capacities_of(*shared_layout);
    for (const auto& [table, rows] : tables) {
        const TableInfo& info = shared_layout->tables()[table.index];
        LOCKSTONE_ASSERT(rows <= info.rows_max, "table ", info.name, ": ", rows, " rows, capacity ",
                         info.rows_max);
        capacities[table.index] = info.grown(rows);
    }
    grow_to(capacities);
}

/// `rows`: by table; each within the limit (asserted).
void State::make_room_for(std::span<const std::uint32_t> rows) {
    if (moves_at_every_chance) move_block();
    std::vector<std::uint32_t> capacities;
    for (std::uint32_t table = 0; table < rows.size(); ++table) {
        const TableInfo& info = shared_layout->tables()[table];
        LOCKSTONE_ASSERT(rows[table] <= info.rows_max, "table ", info.name, ": ", rows[table],
                         " rows, capacity ", info.rows_max);
        if (rows[table] <= info.capacity) continue;
        if (capacities.empty()) capacities = capacities_of(*shared_layout);
        capacities[table] = info.grown(rows[table]);
    }
    if (!capacities.empty()) grow_to(capacities);
}

} // namespace lockstone
