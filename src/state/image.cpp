// Ring images: copies pages whose versions differ, adjacent pages in one copy.
#include "base/assert.h"
#include "lockstone/state.h"
#include "state/pages.h"

#include <algorithm>
#include <cstring>

namespace lockstone {

namespace {

using Placement = StateLayout::Placement;

/// Collects ranges of the block, and copies adjacent ranges at once.
class Run {
  public:
    void add(const std::byte* source, std::byte* target, std::size_t bytes) {
        if (source != from + size || target != to + size) {
            flush();
            from = source, to = target, size = 0;
        }
        size += bytes;
    }
    void flush() const {
        if (size != 0) std::memcpy(to, from, size);
    }

  private:
    const std::byte* from = nullptr;
    std::byte* to = nullptr;
    std::size_t size = 0;
};

/// The rows of a state or an image, and their versions.
struct Source {
    const StateLayout& layout;
    const std::byte* block;
    const detail::Versions& versions;
};
struct Target {
    const StateLayout& layout;
    std::byte* block;
    detail::Versions& versions;
};

/// Copies the pages that differ between two blocks, except the row counts. The copy of a partly filled last page
/// extends to a whole cache line (the bytes after its live rows are zero), so the columns of a full table form one
/// range. It ends there, as the image may still hold old rows after it.
void copy_columns(std::span<const std::uint32_t> counts, const Source& from, const Target& to) {
    Run run;
    const std::span<const Placement> places = from.layout.placements(), to_places = to.layout.placements();
    for (std::size_t c = 0; c < places.size(); ++c) {
        const std::size_t size = page_bytes(places[c]);
        const std::byte* const source = from.block + places[c].offset;
        std::byte* const target = to.block + to_places[c].offset;
        const std::uint32_t rows = counts[places[c].table];
        const std::size_t end = whole_lines(std::size_t{rows} * places[c].row_size);
        take_versions(places[c], to_places[c], c, rows, from.versions, to.versions, [&](std::size_t page) {
            run.add(source + page * size, target + page * size, std::min(size, end - page * size));
        });
    }
    run.flush();
}

} // namespace

bool operator==(const Image& left, const Image& right) {
    if (left.layout == nullptr || right.layout == nullptr) return left.layout == right.layout;
    if (left.layout->schema_hash() != right.layout->schema_hash()) return false;
    if (!std::ranges::equal(left.counts(), right.counts())) return false;
    const std::span<const Placement> a = left.layout->placements(), b = right.layout->placements();
    for (std::size_t c = 0; c < a.size(); ++c) {
        const std::size_t size = std::size_t{left.counts()[a[c].table]} * a[c].row_size;
        if (size != 0 &&
            std::memcmp(left.block.get() + a[c].offset, right.block.get() + b[c].offset, size) != 0)
            return false;
    }
    return true;
}

std::size_t State::image_bytes() const {
    // The schema hash and the counts, then the rows.
    std::size_t size = whole_lines(sizeof(std::uint64_t) + counts().size_bytes());
    for (const Placement& column : shared_layout->placements())
        size += whole_lines(std::size_t{counts()[column.table]} * column.row_size);
    return size;
}

void State::reserve(Image& image) const {
    if (image.layout == shared_layout) return;
    image.block = detail::Block(shared_layout->size_bytes());
    std::memset(image.block.get(), 0, counts().size_bytes());
    image.owner = nullptr;
    image.layout = shared_layout;
    image.packed_size = 0;
}

void State::save(Image& image) const {
    reserve(image);
    detail::Versions& theirs = image.versions;
    if (image.owner != owner) {
        image.owner = owner;
        theirs.pages.assign(versions.pages.size(), 0);
        theirs.chunks.assign(versions.chunks.size(), 0);
        theirs.columns.assign(versions.columns.size(), 0);
    }
    if (!counts().empty()) std::memcpy(image.block.get(), block.get(), counts().size_bytes());
    copy_columns(counts(), {*shared_layout, block.get(), versions},
                 {*shared_layout, image.block.get(), theirs});
    image.packed_size = image_bytes();
    if constexpr (checks_versions) {
        const Status status = verify_versions(image);
        LOCKSTONE_ASSERT(status.ok(), status.error().message);
    }
}

Status State::can_restore(const Image& image) const {
    if (image.size() == 0) return Error{"the image is empty: nothing was saved into it"};
    if (image.layout->schema_hash() != shared_layout->schema_hash())
        return Error{"the image is of a state whose columns have other names or fields"};
    if (image.origin() != shared_layout->origin())
        return Error{"the image is of a world with another definition or other assets"};
    return {};
}

void State::restore(const Image& image) {
    const Status good = can_restore(image);
    LOCKSTONE_ASSERT(good.ok(), good.error().message);
    make_room_for(image.counts());
    // resize() zeroes rows beyond those of the image.
    for (std::uint32_t table = 0; table < counts().size(); ++table) resize({table}, image.counts()[table]);
    if (image.owner == owner)
        copy_columns(counts(), {*image.layout, image.block.get(), image.versions},
                     {*shared_layout, block.get(), versions});
    else
        restore_foreign(image);
    if constexpr (checks_versions) {
        const Status status = verify_versions(image);
        LOCKSTONE_ASSERT(status.ok(), status.error().message);
    }
}

/// The versions of another state's image have no meaning in this state: its rows are written like any other rows.
void State::restore_foreign(const Image& image) {
    const std::span<const Placement> places = image.layout->placements();
    for (std::uint32_t column = 0; column < places.size(); ++column) {
        const std::span<std::byte> rows = edit_bytes(column);
        if (!rows.empty()) std::memcpy(rows.data(), image.block.get() + places[column].offset, rows.size());
    }
}

} // namespace lockstone
