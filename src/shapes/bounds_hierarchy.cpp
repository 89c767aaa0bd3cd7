#include "shapes/bounds_hierarchy.h"

#include <algorithm>
#include <limits>

namespace lockstone::shapes {
namespace {

constexpr std::int32_t lowest = std::numeric_limits<std::int32_t>::min(),
                       highest = std::numeric_limits<std::int32_t>::max();

} // namespace

void BoundsHierarchy::start(std::uint32_t count, const Extent& all) {
    std::int64_t half = 0;
    for (int i = 0; i < 3; ++i) {
        middle[i] = Coordinate::from_raw((all.lower[i].raw + all.upper[i].raw) >> 1);
        half = std::max(half, all.upper[i].raw - middle[i].raw + 1);
    }
    while ((half >> shift) > highest - 2) ++shift;
    std::size_t total = 0;
    std::uint32_t boxes = count;
    do {
        level_start.push_back(static_cast<std::uint32_t>(total));
        boxes = (boxes + width - 1) / width;
        total += boxes;
    } while (boxes > 1);
    Group empty;
    for (auto& axis : empty.lower) std::ranges::fill(axis, highest);
    for (auto& axis : empty.upper) std::ranges::fill(axis, lowest);
    groups.assign(total, empty);
}

std::int32_t BoundsHierarchy::quantised(Coordinate x, int axis) const {
    // Clamps queries to a range beyond all boxes that excludes the bounds of empty slots.
    const std::int64_t steps = sub_saturated(x.raw, middle[axis].raw) >> shift;
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(steps, lowest + 1, highest - 1));
}

void BoundsHierarchy::put(Group& group, std::uint32_t slot, const Extent& box) const {
    for (int i = 0; i < 3; ++i) {
        group.lower[i][slot] = quantised(box.lower[i], i);
        group.upper[i][slot] = quantised(box.upper[i], i);
    }
}

void BoundsHierarchy::finish(std::uint32_t count) {
    std::uint32_t boxes = (count + width - 1) / width;
    for (std::size_t level = 1; level < level_start.size(); ++level) {
        for (std::uint32_t k = 0; k < boxes; ++k) {
            const Group& below = groups[level_start[level - 1] + k];
            Group& above = groups[level_start[level] + k / width];
            for (int i = 0; i < 3; ++i) {
                above.lower[i][k % width] = std::ranges::min(below.lower[i]);
                above.upper[i][k % width] = std::ranges::max(below.upper[i]);
            }
        }
        boxes = (boxes + width - 1) / width;
    }
}

BoundsHierarchy::Query BoundsHierarchy::query_of(const Extent& where) const {
    Query q;
    for (int i = 0; i < 3; ++i) {
        q.lower[i] = quantised(where.lower[i], i);
        q.upper[i] = quantised(where.upper[i], i);
    }
    return q;
}

// No branches, no shifts by variables, and never inlined: compilers then compare four boxes at once, which they
// do not do when it is inlined into a loop.
std::uint32_t BoundsHierarchy::overlaps(const Group& g, const Query& q) {
    constexpr std::uint32_t bit[width] = {1, 2, 4, 8, 16, 32, 64, 128};
    const auto past = [](std::int32_t a, std::int32_t b) { return static_cast<std::uint32_t>(a > b); };
    std::uint32_t hits = 0;
    for (std::uint32_t k = 0; k < width; ++k) {
        const std::uint32_t apart = past(g.lower[0][k], q.upper[0]) | past(q.lower[0], g.upper[0][k]) |
                                    past(g.lower[1][k], q.upper[1]) | past(q.lower[1], g.upper[1][k]) |
                                    past(g.lower[2][k], q.upper[2]) | past(q.lower[2], g.upper[2][k]);
        hits += (apart - 1) & bit[k];
    }
    return hits;
}

Extent BoundsHierarchy::box_of(const Group& group, std::uint32_t slot) const {
    Extent box;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t first = std::int64_t{group.lower[i][slot]} << shift,
                           last = ((std::int64_t{group.upper[i][slot]} + 1) << shift) - 1;
        box.lower[i] = Coordinate::from_raw(middle[i].raw + first);
        box.upper[i] = Coordinate::from_raw(middle[i].raw + last);
    }
    return box;
}

} // namespace lockstone::shapes
