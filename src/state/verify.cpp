// Checks the versions of pages: finds writes that did not go through State::edit.
#include "base/text.h"
#include "lockstone/state.h"
#include "state/canonical.h"
#include "state/pages.h"

#include <algorithm>
#include <cstring>

namespace lockstone {

namespace {

using base::join;

/// "column body.pose, rows 56 to 99"
std::string name_of_page(const ColumnInfo& column, std::size_t page, std::uint32_t rows) {
    const std::size_t first = page * column.rows_per_page;
    return join("column ", column.name, ", rows ", first, " to ",
                std::min<std::size_t>(first + column.rows_per_page, rows) - 1);
}

} // namespace

Status State::verify_versions() const {
    const std::span<const StateLayout::Placement> places = shared_layout->placements();
    for (std::uint32_t c = 0; c < places.size(); ++c) {
        const ColumnInfo& column = shared_layout->columns()[c];
        const std::uint32_t rows = counts()[places[c].table];
        const std::span<const std::byte> all = bytes(c);
        const std::size_t size = page_bytes(places[c]), pages = pages_of(places[c], rows);
        for (std::size_t page = 0; page < pages; ++page) {
            const std::size_t at = places[c].first_page + page;
            const std::uint64_t version = versions.pages[at];
            if (version == 0 || version > version_last || version > versions.columns[c])
                return Error{join("versions: ", name_of_page(column, page, rows), ": version ", version,
                                  " was not given out")};
            const std::size_t chunk = at / StateLayout::pages_per_chunk;
            if (hashes.of.pages[at] != version) {
                if (hashes.of.columns[c] != versions.columns[c] &&
                    hashes.of.chunks[chunk] != versions.chunks[chunk])
                    continue;
                return Error{join("versions: ", name_of_page(column, page, rows),
                                  ": its chunk or column counts as hashed, this page does not")};
            }
            const std::uint64_t found =
                hash_canonical(std::endian::native, column.leaves,
                               all.subspan(page * size, std::min(size, all.size() - page * size)));
            if (found != hashes.page[at])
                return Error{join("versions: ", name_of_page(column, page, rows),
                                  ": written without State::edit since the last hash")};
        }
    }
    return {};
}

Status State::verify_versions(const Image& image) const {
    if (image.owner != owner) return {};
    const std::span<const StateLayout::Placement> places = shared_layout->placements(),
                                                  theirs = image.layout->placements();
    for (std::uint32_t c = 0; c < places.size(); ++c) {
        const ColumnInfo& column = shared_layout->columns()[c];
        const std::uint32_t rows = std::min(counts()[places[c].table], image.counts()[places[c].table]);
        const std::size_t size = page_bytes(places[c]), pages = pages_of(places[c], rows);
        const std::size_t live = std::size_t{rows} * column.row_size;
        for (std::size_t page = 0; page < pages; ++page) {
            constexpr std::size_t step = StateLayout::pages_per_chunk;
            const std::size_t at = places[c].first_page + page, their_at = theirs[c].first_page + page,
                              begin = page * size;
            const bool same_version = versions.columns[c] == image.versions.columns[c] ||
                                      versions.chunks[at / step] == image.versions.chunks[their_at / step] ||
                                      versions.pages[at] == image.versions.pages[their_at];
            if (same_version &&
                std::memcmp(block.get() + places[c].offset + begin,
                            image.block.get() + theirs[c].offset + begin, std::min(size, live - begin)) != 0)
                return Error{join("versions: ", name_of_page(column, page, rows),
                                  ": other rows than in the image, but the same version")};
        }
    }
    return {};
}

} // namespace lockstone
