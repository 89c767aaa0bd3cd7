#include "base/assert.h"
#include "base/hash.h"
#include "lockstone/state.h"
#include "state/canonical.h"
#include "state/pages.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace lockstone {

namespace {

/// H(page hashes ..., row count, seed). `pages` has room for one more value; the function restores it after use.
/// Hashing one range of bytes is several times faster than a stream of short ones.
std::uint64_t hash_of_pages(std::span<std::uint64_t> pages, std::uint32_t rows, std::uint64_t seed) {
    if constexpr (std::endian::native == std::endian::little) {
        const std::uint64_t next = std::exchange(pages.back(), rows);
        const std::uint64_t found =
            base::xxh3(std::as_bytes(pages).first(pages.size_bytes() - sizeof rows), seed);
        pages.back() = next;
        return found;
    }
    base::HashStream stream(seed);
    for (const std::uint64_t page : pages.first(pages.size() - 1)) stream.add(page);
    stream.add(rows);
    return stream.digest();
}

} // namespace

/// Hashes the pages whose hash belongs to another version, and the column if there is one.
std::uint64_t State::column_hash(std::uint32_t column) const {
    if (hashes.of.columns[column] == versions.columns[column]) return hashes.column[column];
    const ColumnInfo& info = shared_layout->columns()[column];
    const StateLayout::Placement& place = shared_layout->placements()[column];
    const std::span<const std::byte> rows = bytes(column);
    const std::size_t size = page_bytes(place);
    const std::uint32_t row_count = counts()[place.table];
    take_versions(place, place, column, row_count, versions, hashes.of, [&](std::size_t page) {
        hashes.page[place.first_page + page] =
            hash_canonical(std::endian::native, info.leaves,
                           rows.subspan(page * size, std::min(size, rows.size() - page * size)));
    });
    const std::span<std::uint64_t> pages =
        std::span(hashes.page).subspan(place.first_page, pages_of(place, row_count) + 1);
    return hashes.column[column] = hash_of_pages(pages, row_count, info.name_hash);
}

/// The common code of hash() and hash_tree(), so that they always agree. With a null tree it allocates nothing.
std::uint64_t State::hash_state(HashTree* tree) const {
    if constexpr (checks_versions) {
        const Status status = verify_versions();
        LOCKSTONE_ASSERT(status.ok(), status.error().message);
    }
    const std::span<const StateLayout::Placement> places = shared_layout->placements();
    const std::span<const ColumnInfo> columns = shared_layout->columns();
    std::array<base::HashStream, group_count> groups{};
    for (std::uint32_t column = 0; column < columns.size(); ++column) {
        const std::uint64_t found = column_hash(column);
        groups[static_cast<std::uint32_t>(columns[column].group)].add(found);
        if (tree == nullptr) continue;
        const std::uint32_t rows = counts()[places[column].table];
        const std::span<const std::uint64_t> pages =
            std::span(hashes.page).subspan(places[column].first_page, pages_of(places[column], rows));
        tree->pages.emplace_back(pages.begin(), pages.end());
        tree->columns.push_back(found);
        tree->row_counts.push_back(rows);
        tree->rows_per_page.push_back(columns[column].rows_per_page);
    }
    base::HashStream root;
    for (std::uint32_t group = 0; group < group_count; ++group) {
        const std::uint64_t group_hash = groups[group].digest();
        root.add(group_hash);
        if (tree != nullptr) tree->groups[group] = group_hash;
    }
    for (const std::uint32_t count : counts()) root.add(count);
    root.add(shared_layout->schema_hash());
    return root.digest();
}

std::uint64_t State::hash() const { return hash_state(nullptr); }

HashTree State::hash_tree() const {
    HashTree tree{};
    tree.root = hash_state(&tree);
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
