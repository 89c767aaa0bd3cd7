#include "collide/broad/wide_tree.h"

#include <algorithm>
#include <cstdlib>

namespace lockstone::collide {
namespace {

// With these bounds no sum of 16-bit numbers in WideTree::meets overflows.
constexpr std::int64_t step_max = 8191;                           ///< of a corner of a leaf
constexpr std::int64_t swept_size_max = 1024;                     ///< of half of a moving box
constexpr std::int64_t place_max = step_max + swept_size_max + 2; ///< of a moving box along its main axis
/// A bound of the errors of SweptBox and of the line through its path, in steps of Bound.
constexpr std::int64_t path_error = 32;
/// A bound of the roundings of a place on a path, in steps.
constexpr std::int64_t place_error = 4;

std::int16_t short_of(std::int64_t x) { return static_cast<std::int16_t>(x); }

/// A mask of the lanes that are not 0.
template <std::size_t n> std::uint32_t bits_of(const std::int16_t (&lanes)[n]) {
    constexpr std::int16_t bit[8] = {1, 2, 4, 8, 16, 32, 64, 128};
    std::int16_t sum = 0;
    for (std::size_t k = 0; k < n; ++k) sum = static_cast<std::int16_t>(sum + (lanes[k] & bit[k]));
    return static_cast<std::uint32_t>(sum);
}
std::int16_t all_if(bool is) { return static_cast<std::int16_t>(is ? -1 : 0); }

} // namespace

bool WideTree::start(const BoundsTree& first, const BoundsTree& second) {
    groups.clear();
    if (first.root() == BoundsTree::none && second.root() == BoundsTree::none) return false;
    Bounds all = first.root() != BoundsTree::none ? first.node(first.root()).bounds
                                                  : second.node(second.root()).bounds;
    if (second.root() != BoundsTree::none) all = merge(all, second.node(second.root()).bounds);
    std::int64_t half = 0;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t low = all.lower[i].raw, high = all.upper[i].raw;
        origin[i] = (low + high) >> 1;
        half = std::max(half, high - origin[i] + 1);
    }
    for (shift = 0; half >> shift >= step_max;) ++shift;
    return true;
}

/// Replaces the largest node by its children until there are eight or only leaves.
void WideTree::add_group(Source (&from)[width], std::uint32_t count) {
    std::int64_t area[width] = {};
    const auto measure = [&](std::uint32_t k) {
        const BoundsTree::Node& node = from[k].node();
        area[k] = node.is_leaf() ? -1 : half_area(node.bounds);
    };
    for (std::uint32_t k = 0; k < count; ++k) measure(k);
    while (count < width) {
        const auto largest = static_cast<std::uint32_t>(std::max_element(area, area + count) - area);
        if (area[largest] < 0) break;
        const BoundsTree::Node& node = from[largest].node();
        from[count] = {from[largest].tree, node.child[1]}, from[largest].id = node.child[0];
        measure(largest), measure(count++);
    }
    const auto id = static_cast<std::uint32_t>(groups.size());
    Group& group = groups.emplace_back();
    for (std::uint32_t k = 0; k < width; ++k) {
        if (k >= count) { // no box meets this one
            for (int i = 0; i < 3; ++i) group.lower[i][k] = INT16_MAX, group.upper[i][k] = INT16_MIN;
            continue;
        }
        const BoundsTree::Node& node = from[k].node();
        for (int i = 0; i < 3; ++i) {
            group.lower[i][k] = short_of(steps_of(node.bounds.lower[i], i));
            group.upper[i][k] = short_of(steps_of(node.bounds.upper[i], i));
        }
        if (!node.is_leaf()) {
            waiting.push_back({from[k], id, k});
            continue;
        }
        group.child[k] = ~static_cast<std::int32_t>(node.proxy());
        int longest = 0;
        for (int i = 0; i < 3; ++i) longest = std::max(longest, group.upper[i][k] - group.lower[i][k]);
        ++leaf_count, leaf_steps += static_cast<std::uint64_t>(longest);
    }
}

void WideTree::build(const BoundsTree& first, const BoundsTree& second) {
    if (!start(first, second)) return;
    waiting.clear();
    leaf_count = leaf_steps = 0;
    Source from[width];
    std::uint32_t count = 0;
    for (const BoundsTree* tree : {&first, &second})
        if (tree->root() != BoundsTree::none) from[count++] = {tree, tree->root()};
    add_group(from, count);
    for (std::size_t next = 0; next < waiting.size(); ++next) {
        const Waiting of = waiting[next];
        groups[of.group].child[of.slot] = static_cast<std::int32_t>(groups.size());
        from[0] = of.from;
        add_group(from, 1);
    }
    constexpr std::uint64_t steps_min = 4; // of a leaf: roundings then add less than its size
    if (leaf_steps < leaf_count * steps_min) clear();
}

WideTree::Box WideTree::box_of(const Bounds& bounds) const {
    constexpr std::int64_t beyond = 2 * step_max; // beyond all boxes, but before those that are not there
    Box box;
    for (int i = 0; i < 3; ++i) {
        box.lower[i] = short_of(std::clamp(steps_of(bounds.lower[i], i), -beyond, beyond));
        box.upper[i] = short_of(std::clamp(steps_of(bounds.upper[i], i), -beyond, beyond));
    }
    return box;
}

bool WideTree::find_path(const SweptBox& swept, Path& path) const {
    if (swept.is_at_border()) return false;
    std::int64_t size[3], way[3], middle[3];
    int main = 0;
    for (int i = 0; i < 3; ++i) {
        size[i] = ((swept.half_size_of(i) + path_error) >> shift) + 2;
        if (size[i] > swept_size_max) return false;
        way[i] = swept.way_of(i), middle[i] = swept.middle_of(i) - origin[i];
        if (std::abs(way[i]) > std::abs(way[main])) main = i;
    }
    // The quarter of the place and the way are below 2^31.
    const std::int64_t reach = 4 * std::abs(way[main]) + path_error;
    path.axis[0] = main, path.size = size[main];
    path.begin = std::clamp((middle[main] - reach) >> shift, -place_max, place_max + 1);
    path.end = std::clamp(((middle[main] + reach) >> shift) + 1, -place_max - 1, place_max);
    for (int k = 0; k < 2; ++k) {
        const int i = (main + 1 + k) % 3;
        std::int64_t slope_15 = 0, at = middle[i];
        if (way[main] != 0) {
            slope_15 = way[i] * 32767 / way[main];
            at -= way[i] * (middle[main] >> 2) / way[main] * 4;
        }
        path.axis[k + 1] = i, path.slope_15[k] = slope_15;
        // A path further away than this meets no box, and keeps clear of all boxes when it is moved here.
        constexpr std::int64_t far = step_max + place_max + swept_size_max;
        at = std::clamp(at >> shift, -far, far);
        path.lowest[k] = at - size[i] - place_error;
        path.highest[k] = at + size[i] + place_error;
    }
    return true;
}

// No branches and never inlined: compilers then compare all boxes at once.
std::uint32_t WideTree::overlaps(const Group& g, const Box& box) {
    std::int16_t meet[width];
    for (std::uint32_t k = 0; k < width; ++k)
        meet[k] = static_cast<std::int16_t>(
            all_if(g.lower[0][k] <= box.upper[0]) & all_if(box.lower[0] <= g.upper[0][k]) &
            all_if(g.lower[1][k] <= box.upper[1]) & all_if(box.lower[1] <= g.upper[1][k]) &
            all_if(g.lower[2][k] <= box.upper[2]) & all_if(box.lower[2] <= g.upper[2][k]));
    return bits_of(meet);
}

/// Clips the path to the range of each box along the main axis. The line over this range meets the range of the box
/// on another axis exactly when the lower end of the line is not above it, and the upper end not below it.
std::uint32_t WideTree::meets(const Group& g, const Path& path) {
    std::int16_t meet[width];
    const auto &low = g.lower[path.axis[0]], &high = g.upper[path.axis[0]];
    const auto &low_1 = g.lower[path.axis[1]], &high_1 = g.upper[path.axis[1]];
    const auto &low_2 = g.lower[path.axis[2]], &high_2 = g.upper[path.axis[2]];
    const auto sum = [](std::int16_t a, std::int16_t b) { return static_cast<std::int16_t>(a + b); };
    const auto times = [](std::int16_t twice, std::int16_t slope_15) {
        return static_cast<std::int16_t>((std::int32_t{twice} * slope_15) >> 16);
    };
    for (std::uint32_t k = 0; k < width; ++k) {
        const std::int16_t first =
            std::max(static_cast<std::int16_t>(low[k] - path.size.of[k]), path.begin.of[k]);
        const std::int16_t last = std::min(sum(high[k], path.size.of[k]), path.end.of[k]);
        const std::int16_t first_2 = sum(first, first), last_2 = sum(last, last);
        const std::int16_t a = times(first_2, path.slope_15[0].of[k]),
                           b = times(last_2, path.slope_15[0].of[k]);
        const std::int16_t c = times(first_2, path.slope_15[1].of[k]),
                           d = times(last_2, path.slope_15[1].of[k]);
        meet[k] = static_cast<std::int16_t>(all_if(first <= last) &
                                            all_if(sum(std::min(a, b), path.lowest[0].of[k]) <= high_1[k]) &
                                            all_if(sum(std::max(a, b), path.highest[0].of[k]) >= low_1[k]) &
                                            all_if(sum(std::min(c, d), path.lowest[1].of[k]) <= high_2[k]) &
                                            all_if(sum(std::max(c, d), path.highest[1].of[k]) >= low_2[k]));
    }
    return bits_of(meet);
}

} // namespace lockstone::collide
