// Lists the rows that have changed since a reader's last call: pages by version, as images compare them.
#include "lockstone/state.h"
#include "state/pages.h"

#include <algorithm>
#include <utility>

namespace lockstone {

std::uint32_t State::take_changes(std::uint32_t column, ChangeMark& mark, std::vector<RowRange>& out) const {
    constexpr std::size_t step = StateLayout::pages_per_chunk;
    if (mark.owner != owner) {
        mark.owner = owner;
        mark.layout = shared_layout;
        mark.versions.pages.assign(versions.pages.size(), 0);
        mark.versions.chunks.assign(versions.chunks.size(), 0);
        mark.versions.columns.assign(versions.columns.size(), 0);
        mark.rows.resize(versions.columns.size());
    }
    if (mark.layout != shared_layout) { // the state has grown since then, so the pages have moved
        move_versions(mark.versions, *mark.layout, *shared_layout);
        mark.layout = shared_layout;
    }
    out.clear();
    const StateLayout::Placement& place = shared_layout->placements()[column];
    const std::uint32_t now = counts()[place.table], before = std::exchange(mark.rows[column], now);
    take_versions(place, place, column, now, versions, mark.versions, [&](std::size_t page) {
        // Below the row count, so the products fit.
        const std::uint32_t first = static_cast<std::uint32_t>(page) * place.rows_per_page;
        const std::uint32_t end = first + std::min(place.rows_per_page, now - first);
        if (!out.empty() && out.back().end == first)
            out.back().end = end;
        else
            out.push_back({first, end});
    });
    // A page that no longer exists counts as changed when it comes back, even with its old version.
    const std::size_t live = pages_of(place, now), gone = pages_of(place, before);
    for (std::size_t page = live; page < gone; ++page) mark.versions.pages[place.first_page + page] = 0;
    for (std::size_t chunk = (live + step - 1) / step; chunk * step < gone; ++chunk)
        mark.versions.chunks[place.first_page / step + chunk] = 0;
    return before;
}

} // namespace lockstone
