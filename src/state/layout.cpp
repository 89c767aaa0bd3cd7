// The layout of a state: the places of columns, and the schema hash.
#include "base/assert.h"
#include "base/bytes.h"
#include "base/hash.h"
#include "lockstone/state.h"

#include <algorithm>
#include <limits>

namespace lockstone {

namespace {

constexpr std::size_t column_alignment = 64; // a cache line, and the widest vector load
constexpr std::uint32_t page_bytes_target =
    4096; // of the hash tree: a difference is located to a few dozen rows

constexpr std::uint64_t round_up(std::uint64_t size) {
    return (size + column_alignment - 1) / column_alignment * column_alignment;
}

/// Returns true if the leaves cover the row in order, without a gap, and have sizes that every host can read.
bool describes(std::span<const LeafInfo> leaves, std::size_t row_size) {
    std::size_t end = 0;
    for (const LeafInfo& leaf : leaves) {
        const bool known_size = leaf.size == 1 || leaf.size == 2 || leaf.size == 4 || leaf.size == 8;
        if (!known_size || leaf.offset != end || leaf.fraction_bits >= 8 * leaf.size) return false;
        end += leaf.size;
    }
    return end == row_size && end > 0;
}

std::uint64_t hash_of(std::span<const TableInfo> tables, std::span<const ColumnInfo> columns) {
    std::vector<std::byte> bytes;
    base::ByteWriter out(bytes);
    out.u32(static_cast<std::uint32_t>(tables.size()));
    out.u32(static_cast<std::uint32_t>(columns.size()));
    out.u32(group_count);
    for (std::uint32_t group = 0; group < group_count; ++group) out.text(name_of(Group{group}));
    for (const TableInfo& table : tables) out.text(table.name);
    for (const ColumnInfo& column : columns) {
        out.text(column.name);
        out.u32(column.table);
        out.u32(static_cast<std::uint32_t>(column.group));
        out.u32(column.row_size);
        out.u32(static_cast<std::uint32_t>(column.leaves.size()));
        for (const LeafInfo& leaf : column.leaves) {
            out.text(leaf.name);
            out.u32(leaf.offset);
            out.u8(leaf.size);
            out.u8(static_cast<std::uint8_t>(leaf.kind));
            out.u8(leaf.fraction_bits);
        }
    }
    return base::xxh3(bytes);
}

} // namespace

std::string_view name_of(Group group) {
    switch (group) {
    case Group::world:
        return "world";
    case Group::definition:
        return "definition";
    case Group::motion:
        return "motion";
    case Group::contact:
        return "contact";
    case Group::game:
        return "game";
    }
    return "unknown";
}

std::uint32_t TableInfo::grown(std::uint32_t rows) const {
    constexpr std::uint32_t least = 8; // avoids several growths of tiny tables
    if (rows <= capacity) return capacity;
    // Adds some rows to the requested number: without them, a state that was just loaded would grow again in its
    // first tick.
    const std::uint64_t some = std::uint64_t{rows} + rows / 8, more = std::uint64_t{capacity} + capacity / 4;
    return static_cast<std::uint32_t>(
        std::min<std::uint64_t>(rows_max, std::max<std::uint64_t>({some, more, least})));
}

TableId StateLayout::add_table(std::string name, std::uint32_t capacity, std::uint32_t rows_max) {
    for (const TableInfo& table : table_infos)
        LOCKSTONE_ASSERT(table.name != name, "two tables named ", name);
    LOCKSTONE_ASSERT(capacity <= rows_max, "table ", name, ", capacity ", capacity, " of ", rows_max);
    table_infos.push_back({std::move(name), capacity, rows_max});
    return {static_cast<std::uint32_t>(table_infos.size() - 1)};
}

std::uint32_t StateLayout::add_column(TableId table, std::string name, Group group, std::size_t row_size,
                                      std::vector<LeafInfo> leaves) {
    LOCKSTONE_ASSERT(table.index < table_infos.size(), "column ", name, " in table ", table.index, " of ",
                     table_infos.size());
    LOCKSTONE_ASSERT(find_column(name) == nullptr, "two columns named ", name);
    LOCKSTONE_ASSERT(static_cast<std::uint32_t>(group) < group_count, "column ", name);
    LOCKSTONE_ASSERT(row_size <= std::numeric_limits<std::uint32_t>::max() && describes(leaves, row_size),
                     "column ", name, ", row size ", row_size);
    const auto size = static_cast<std::uint32_t>(row_size);
    const std::uint64_t name_hash = base::xxh3(std::string_view(name));
    leaf_lists.push_back(std::make_shared<const std::vector<LeafInfo>>(std::move(leaves)));
    column_infos.push_back({.name = std::move(name),
                            .table = table.index,
                            .group = group,
                            .row_size = size,
                            .rows_per_page = std::max(1u, page_bytes_target / size),
                            .offset = 0,
                            .leaves = *leaf_lists.back(),
                            .name_hash = name_hash});
    return static_cast<std::uint32_t>(column_infos.size() - 1);
}

std::shared_ptr<const StateLayout> StateLayout::finished() && {
    list_columns();
    place_columns();
    schema = hash_of(table_infos, column_infos);
    has_places = true;
    return std::make_shared<const StateLayout>(std::move(*this));
}

std::shared_ptr<const StateLayout>
StateLayout::with_capacities(std::span<const std::uint32_t> capacities) const {
    LOCKSTONE_ASSERT(has_places && capacities.size() == table_infos.size(), capacities.size(),
                     " capacities for ", table_infos.size(), " tables");
    auto other = std::make_shared<StateLayout>(*this);
    for (std::size_t table = 0; table < capacities.size(); ++table) {
        TableInfo& info = other->table_infos[table];
        LOCKSTONE_ASSERT(capacities[table] <= info.rows_max, "table ", info.name, ", capacity ",
                         capacities[table], " of ", info.rows_max);
        info.capacity = capacities[table];
    }
    other->place_columns();
    return other;
}

void StateLayout::list_columns() {
    for (std::uint32_t table = 0; table < table_infos.size(); ++table) {
        columns_begin.push_back(static_cast<std::uint32_t>(columns_by_table.size()));
        for (std::uint32_t column = 0; column < column_infos.size(); ++column)
            if (column_infos[column].table == table) columns_by_table.push_back(column);
    }
    columns_begin.push_back(static_cast<std::uint32_t>(columns_by_table.size()));
}

/// Computes the offsets and sizes from the lists of tables and columns.
void StateLayout::place_columns() {
    const std::uint64_t header = table_infos.size() * sizeof(std::uint32_t);
    std::uint64_t block = round_up(header);
    std::uint64_t image = round_up(sizeof(std::uint64_t) + header);
    for (ColumnInfo& column : column_infos) {
        const std::uint64_t size = std::uint64_t{table_infos[column.table].capacity} * column.row_size;
        column.offset = static_cast<std::size_t>(block);
        block += round_up(size);
        image += round_up(size);
        LOCKSTONE_ASSERT(size < (std::uint64_t{1} << 48) &&
                             block <= std::numeric_limits<std::size_t>::max() / 2,
                         "column ", column.name, " needs ", size, " bytes");
    }
    column_placements.clear();
    pages_total = 0;
    for (const ColumnInfo& column : column_infos) {
        column_placements.push_back(
            {column.offset, column.row_size, column.table, column.rows_per_page, pages_total});
        const std::uint32_t capacity = table_infos[column.table].capacity;
        const std::size_t pages =
            capacity / column.rows_per_page + (capacity % column.rows_per_page != 0 ? 1 : 0);
        pages_total += (pages + pages_per_chunk - 1) / pages_per_chunk * pages_per_chunk;
    }
    block_size = static_cast<std::size_t>(block);
    image_size_max = static_cast<std::size_t>(image);
}

const ColumnInfo* StateLayout::find_column(std::string_view name) const {
    const auto found = std::ranges::find(column_infos, name, &ColumnInfo::name);
    return found == column_infos.end() ? nullptr : &*found;
}

} // namespace lockstone
