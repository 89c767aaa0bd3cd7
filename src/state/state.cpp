#include "lockstone/state.h"

#include "base/assert.h"

#include <algorithm>
#include <cstring>
#include <new>

namespace lockstone {

namespace {

constexpr std::align_val_t block_alignment{64};

/// At least one byte, so that the block of an empty layout is an object too.
std::byte* allocate_block(std::size_t size) {
    return static_cast<std::byte*>(::operator new(std::max<std::size_t>(size, 1), block_alignment));
}

struct ImageHeader {
    std::uint64_t schema;
};

constexpr std::size_t line = 64; ///< columns begin on one, in the block and in images

std::size_t whole_lines(std::size_t size) { return (size + line - 1) / line * line; }

/// Where the rows begin: the header and the counts, up to a cache line, since a misaligned copy is slower.
std::size_t rows_offset(std::size_t tables) {
    return whole_lines(sizeof(ImageHeader) + tables * sizeof(std::uint32_t));
}

/// Walks the packed image in manifest order: copy(offset in the block, offset in the image, bytes). Live rows are taken
/// in whole lines (what follows them in the block is zero), so columns of a full table lie one after another in
/// both places and are one copy.
template <class Copy>
std::size_t walk_columns(const StateLayout& layout, std::span<const std::uint32_t> counts, Copy&& copy) {
    std::size_t at = rows_offset(counts.size());
    std::size_t from = 0, size = 0; // the run so far
    for (const StateLayout::Placement& column : layout.placements()) {
        const std::size_t next = whole_lines(std::size_t{counts[column.table]} * column.row_size);
        if (next == 0) continue;
        if (size != 0 && from + size == column.offset) {
            size += next;
            continue;
        }
        if (size != 0) copy(from, at, size);
        at += size;
        from = column.offset;
        size = next;
    }
    if (size != 0) copy(from, at, size);
    return at + size;
}

} // namespace

void State::AlignedFree::operator()(std::byte* p) const { ::operator delete(p, block_alignment); }

State::State(std::shared_ptr<const StateLayout> layout) : shared_layout(std::move(layout)) {
    LOCKSTONE_ASSERT(shared_layout != nullptr, "a State needs a layout");
    block.reset(allocate_block(shared_layout->size_bytes()));
    std::memset(block.get(), 0, shared_layout->size_bytes());
}

State::State(const State& other) : shared_layout(other.shared_layout) {
    block.reset(allocate_block(shared_layout->size_bytes()));
    std::memcpy(block.get(), other.block.get(), shared_layout->size_bytes());
}

State& State::operator=(const State& other) {
    if (this == &other) return *this;
    if (shared_layout != other.shared_layout) {
        if (shared_layout == nullptr) return *this = State(other); // assigned to after it was moved from
        LOCKSTONE_ASSERT(shared_layout->schema_hash() == other.shared_layout->schema_hash(),
                         "states of different schemas");
        LOCKSTONE_ASSERT(std::ranges::equal(shared_layout->tables(), other.shared_layout->tables(), {},
                                            &TableInfo::capacity, &TableInfo::capacity),
                         "states of different capacities");
    }
    std::memcpy(block.get(), other.block.get(), shared_layout->size_bytes());
    return *this;
}

std::span<std::byte> State::bytes(std::uint32_t column) {
    const ColumnInfo& info = shared_layout->columns()[column];
    return {block.get() + info.offset, std::size_t{counts()[info.table]} * info.row_size};
}

std::span<const std::byte> State::bytes(std::uint32_t column) const {
    const ColumnInfo& info = shared_layout->columns()[column];
    return {block.get() + info.offset, std::size_t{counts()[info.table]} * info.row_size};
}

void State::resize(TableId table, std::uint32_t rows) {
    LOCKSTONE_ASSERT(table.index < counts().size(), "table ", table.index, " of ", counts().size());
    LOCKSTONE_ASSERT(rows <= capacity(table), "table ", shared_layout->tables()[table.index].name, ": ", rows,
                     " rows, capacity ", capacity(table));
    const std::uint32_t old = counts()[table.index];
    counts()[table.index] = rows;
    if (rows >= old) return; // what is not live is zero already
    for (const ColumnInfo& column : shared_layout->columns())
        if (column.table == table.index)
            std::memset(block.get() + column.offset + std::size_t{rows} * column.row_size, 0,
                        std::size_t{old - rows} * column.row_size);
}

std::size_t State::image_bytes() const {
    return walk_columns(*shared_layout, counts(), [](std::size_t, std::size_t, std::size_t) {});
}

void State::save(Image& image) const {
    // The largest image at once: a ring then never allocates again, however the world grows.
    if (image.bytes.size() < shared_layout->image_bytes_max())
        image.bytes.resize(shared_layout->image_bytes_max());
    std::byte* to = image.bytes.data();
    const ImageHeader header{shared_layout->schema_hash()};
    std::memset(to, 0, rows_offset(counts().size())); // so that equal states give equal images
    std::memcpy(to, &header, sizeof header);
    if (!counts().empty()) std::memcpy(to + sizeof header, block.get(), counts().size_bytes());
    image.size =
        walk_columns(*shared_layout, counts(), [&](std::size_t offset, std::size_t at, std::size_t size) {
            std::memcpy(to + at, block.get() + offset, size);
        });
}

void State::restore(const Image& image) {
    const std::byte* from = image.bytes.data();
    ImageHeader header{};
    LOCKSTONE_ASSERT(image.size <= image.bytes.size() && image.size >= rows_offset(counts().size()),
                     "image of ", image.size, " bytes");
    std::memcpy(&header, from, sizeof header);
    LOCKSTONE_ASSERT(header.schema == shared_layout->schema_hash(), "an image of another schema");
    const auto count_in_image = [&](std::size_t table) {
        std::uint32_t count = 0;
        std::memcpy(&count, from + sizeof header + table * sizeof count, sizeof count);
        return count;
    };
    // Rows beyond those of the image are zeroed by the resize.
    for (std::uint32_t table = 0; table < counts().size(); ++table) {
        LOCKSTONE_ASSERT(count_in_image(table) <= capacity({table}), "table ",
                         shared_layout->tables()[table].name);
        if (count_in_image(table) != counts()[table]) resize({table}, count_in_image(table));
    }
    LOCKSTONE_ASSERT(image.size == image_bytes(), "image of ", image.size, " bytes, its rows need ",
                     image_bytes());
    walk_columns(*shared_layout, counts(), [&](std::size_t offset, std::size_t at, std::size_t size) {
        std::memcpy(block.get() + offset, from + at, size);
    });
}

} // namespace lockstone
