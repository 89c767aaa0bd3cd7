// diff, dump, and to_string(Difference).
#include "base/assert.h"
#include "lockstone/state.h"
#include "state/leaf_text.h"

#include <algorithm>
#include <cstring>

namespace lockstone {

namespace {

std::string count_text(std::uint32_t count) { return base::join(count, " (raw ", base::hex(count), ")"); }

/// Appends the leaves of one row whose bytes differ.
void append_row(const ColumnInfo& column, std::uint32_t row, std::span<const std::byte> left,
                std::span<const std::byte> right, std::size_t limit, std::vector<Difference>& out) {
    for (const LeafInfo& leaf : column.leaves) {
        if (out.size() == limit) return;
        if (std::memcmp(left.data() + leaf.offset, right.data() + leaf.offset, leaf.size) == 0) continue;
        out.push_back(
            {column.name, row, leaf.name, leaf_text_with_raw(left, leaf), leaf_text_with_raw(right, leaf)});
    }
}

} // namespace

std::string to_string(const Difference& difference) {
    if (difference.field == row_count_field)
        return base::join("row count of ", difference.column, ": ", difference.left, " against ",
                          difference.right);
    return base::join("column ", difference.column, ", row ", difference.row, ", ", difference.field, ": ",
                      difference.left, " against ", difference.right);
}

std::vector<Difference> State::diff(const State& left, const State& right, std::size_t limit) {
    const StateLayout& layout = left.layout();
    LOCKSTONE_ASSERT(layout.schema_hash() == right.layout().schema_hash(), "states of different schemas");
    std::vector<Difference> out;
    for (std::uint32_t table = 0; table < layout.tables().size() && out.size() < limit; ++table)
        if (left.count({table}) != right.count({table}))
            out.push_back({layout.tables()[table].name, 0, row_count_field, count_text(left.count({table})),
                           count_text(right.count({table}))});
    for (std::uint32_t index = 0; index < layout.columns().size(); ++index) {
        const ColumnInfo& column = layout.columns()[index];
        const std::size_t size = column.row_size;
        const std::size_t shared = std::min(left.bytes(index).size(), right.bytes(index).size());
        for (std::size_t at = 0; at < shared && out.size() < limit; at += size) {
            const auto a = left.bytes(index).subspan(at, size), b = right.bytes(index).subspan(at, size);
            if (std::memcmp(a.data(), b.data(), size) == 0) continue;
            append_row(column, static_cast<std::uint32_t>(at / size), a, b, limit, out);
        }
    }
    return out;
}

std::string State::dump() const {
    std::string out;
    for (std::uint32_t index = 0; index < shared_layout->columns().size(); ++index) {
        const ColumnInfo& column = shared_layout->columns()[index];
        for (std::size_t at = 0; at < bytes(index).size(); at += column.row_size) {
            out += base::join(column.name, "[", at / column.row_size, "]");
            for (const LeafInfo& leaf : column.leaves)
                out += base::join(" ", leaf.name, "=",
                                  leaf_text(bytes(index).subspan(at, column.row_size), leaf));
            out += '\n';
        }
    }
    return out;
}

} // namespace lockstone
