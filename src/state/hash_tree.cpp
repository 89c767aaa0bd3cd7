#include "base/hash.h"
#include "lockstone/state.h"
#include "state/canonical.h"

#include <algorithm>

namespace lockstone {

namespace {

/// The page and column hashes of one column; pages are also written down where `pages` is given.
std::uint64_t hash_column(const ColumnInfo& column, std::span<const std::byte> rows, std::uint32_t row_count,
                          std::vector<std::uint64_t>* pages) {
    const std::size_t page_size = std::size_t{column.rows_per_page} * column.row_size;
    base::HashStream stream(column.name_hash);
    for (std::size_t at = 0; at < rows.size(); at += page_size) {
        const std::span<const std::byte> page = rows.subspan(at, std::min(page_size, rows.size() - at));
        const std::uint64_t page_hash = hash_canonical(std::endian::native, column.leaves, page);
        stream.add(page_hash);
        if (pages != nullptr) pages->push_back(page_hash);
    }
    stream.add(row_count);
    return stream.digest();
}

/// One walk for hash() and hash_tree(), so that they cannot disagree. A null tree makes it allocate nothing.
std::uint64_t hash_state(const State& state, HashTree* tree) {
    const StateLayout& layout = state.layout();
    std::array<base::HashStream, group_count> groups{};
    for (std::uint32_t index = 0; index < layout.columns().size(); ++index) {
        const ColumnInfo& column = layout.columns()[index];
        const std::uint32_t row_count = state.count({column.table});
        const std::uint64_t column_hash = hash_column(
            column, state.bytes(index), row_count, tree != nullptr ? &tree->pages.emplace_back() : nullptr);
        groups[static_cast<std::uint32_t>(column.group)].add(column_hash);
        if (tree == nullptr) continue;
        tree->columns.push_back(column_hash);
        tree->row_counts.push_back(row_count);
        tree->rows_per_page.push_back(column.rows_per_page);
    }
    base::HashStream root;
    for (std::uint32_t group = 0; group < group_count; ++group) {
        const std::uint64_t group_hash = groups[group].digest();
        root.add(group_hash);
        if (tree != nullptr) tree->groups[group] = group_hash;
    }
    for (std::uint32_t table = 0; table < layout.tables().size(); ++table) root.add(state.count({table}));
    root.add(layout.schema_hash());
    return root.digest();
}

} // namespace

std::uint64_t State::hash() const { return hash_state(*this, nullptr); }

HashTree State::hash_tree() const {
    HashTree tree{};
    tree.root = hash_state(*this, &tree);
    return tree;
}

std::vector<PageRef> differing_pages(const HashTree& left, const HashTree& right) {
    std::vector<PageRef> out;
    const std::size_t columns = std::min(left.pages.size(), right.pages.size());
    for (std::size_t column = 0; column < columns; ++column) {
        if (left.columns[column] == right.columns[column]) continue;
        const auto& a = left.pages[column];
        const auto& b = right.pages[column];
        const std::uint32_t row_count = std::max(left.row_counts[column], right.row_counts[column]);
        const std::uint32_t rows_per_page = left.rows_per_page[column];
        for (std::size_t page = 0; page < std::max(a.size(), b.size()); ++page) {
            if (page < a.size() && page < b.size() && a[page] == b[page]) continue;
            const auto number = static_cast<std::uint32_t>(page);
            const std::uint32_t first = number * rows_per_page;
            out.push_back({static_cast<std::uint32_t>(column), number, first,
                           std::min(first + (rows_per_page - 1), row_count - 1)});
        }
    }
    return out;
}

} // namespace lockstone
