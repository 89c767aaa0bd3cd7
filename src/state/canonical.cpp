#include "state/canonical.h"

#include "base/assert.h"

#include <algorithm>
#include <cstring>

namespace lockstone {

namespace {
std::size_t row_size_of(std::span<const LeafInfo> leaves) {
    return leaves.back().offset + leaves.back().size;
}
} // namespace

void copy_canonical(std::endian order, std::span<const LeafInfo> leaves, std::span<const std::byte> rows,
                    std::span<std::byte> to) {
    LOCKSTONE_ASSERT(rows.size() == to.size(), "from ", rows.size(), " bytes, to ", to.size());
    if (rows.empty()) return;
    if (order == std::endian::little) {
        std::memcpy(to.data(), rows.data(), rows.size());
        return;
    }
    const std::size_t row_size = row_size_of(leaves);
    LOCKSTONE_ASSERT(rows.size() % row_size == 0, rows.size(), " bytes of rows of ", row_size);
    for (std::size_t row = 0; row < rows.size(); row += row_size)
        for (const LeafInfo& leaf : leaves) {
            const std::byte* from = rows.data() + row + leaf.offset;
            std::reverse_copy(from, from + leaf.size, to.data() + row + leaf.offset);
        }
}

std::uint64_t hash_canonical(std::endian order, std::span<const LeafInfo> leaves,
                             std::span<const std::byte> rows) {
    if (order == std::endian::little || rows.empty()) return base::xxh3(rows);
    // Leaf by leaf into a buffer of fixed size, since a single row may be longer than any buffer.
    std::byte buffer[4096];
    std::size_t filled = 0;
    base::HashStream stream;
    const std::size_t row_size = row_size_of(leaves);
    LOCKSTONE_ASSERT(rows.size() % row_size == 0, rows.size(), " bytes of rows of ", row_size);
    for (std::size_t row = 0; row < rows.size(); row += row_size)
        for (const LeafInfo& leaf : leaves) {
            if (filled + leaf.size > sizeof buffer) {
                stream.add({buffer, filled});
                filled = 0;
            }
            const std::byte* from = rows.data() + row + leaf.offset;
            std::reverse_copy(from, from + leaf.size, buffer + filled);
            filled += leaf.size;
        }
    stream.add({buffer, filled});
    return stream.digest();
}

void append_canonical(std::span<const std::byte> row, std::span<const LeafInfo> leaves,
                      std::vector<std::byte>& out) {
    const std::size_t start = out.size();
    out.resize(start + row.size());
    copy_canonical(std::endian::native, leaves, row, std::span(out).subspan(start));
}

void read_canonical(std::span<const std::byte> from, std::span<const LeafInfo> leaves,
                    std::span<std::byte> row) {
    copy_canonical(std::endian::native, leaves, from, row);
}

std::uint64_t hash_bytes(std::span<const std::byte> bytes, std::uint64_t seed) {
    return base::xxh3(bytes, seed);
}

} // namespace lockstone
