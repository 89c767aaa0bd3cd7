// A box that moves along a segment, in the integers of the broad phase. With size zero it is a ray.
#pragma once

#include "collide/bounds.h"

#include <cstdint>

namespace lockstone::collide {

/// Tests whether the moving box may meet given bounds. It never returns false when they meet, and seldom
/// returns true when they do not.
class SweptBox {
  public:
    /// From `begin` to `end`. Both must have the same size, up to rounding.
    SweptBox(const Bounds& begin, const Bounds& end) : hull(merge(begin, end)) {
        for (int i = 0; i < 3; ++i) {
            const std::int64_t low = begin.lower[i].raw, high = begin.upper[i].raw;
            const std::int64_t low_end = end.lower[i].raw, high_end = end.upper[i].raw;
            middle[i] = (low + high + low_end + high_end) >> 2;
            const std::int64_t half_way = (low_end + high_end - low - high) >> 2;
            half_size[i] = (high - low > high_end - low_end ? high - low : high_end - low_end) / 2 + 2;
            is_short &= magnitude_of(half_way) <= half_size[i];
            way[i] = half_way >> 2, way_size[i] = magnitude_of(way[i]);
            // At the border of the range positions are clamped, so the direction of motion is unknown.
            is_clamped |= hull.lower[i] == Bound::min() || hull.upper[i] == Bound::max();
        }
        for (int i = 0; i < 3; ++i) rounding[i] = 2 * (way_size[(i + 1) % 3] + way_size[(i + 2) % 3]) + 8;
    }
    const Bounds& bounds() const { return hull; }
    /// The middle of the path, half of the box's size [steps], and half of the path [four steps], rounded.
    std::int64_t middle_of(int axis) const { return middle[axis]; }
    std::int64_t half_size_of(int axis) const { return half_size[axis]; }
    std::int64_t way_of(int axis) const { return way[axis]; }
    /// True where positions are clamped: the path is unknown.
    bool is_at_border() const { return is_clamped; }

    /// source: Ericson, Real-Time Collision Detection, 5.3.3 (segment against box by separating axes)
    bool may_meet(const Bounds& b) const {
        if (!overlap(hull, b)) return false;
        if (is_clamped) return true;
        // In units of four steps, below 2^31: products of two, and their sums, fit 64 bits.
        std::int64_t m[3], h[3], size[3];
        for (int i = 0; i < 3; ++i) {
            const std::int64_t low = b.lower[i].raw, high = b.upper[i].raw;
            m[i] = (middle[i] - ((low + high) >> 1)) >> 2;
            h[i] = ((((high - low) >> 1) + half_size[i]) >> 2) + 2;
            size[i] = magnitude_of(m[i]) + h[i];
        }
        for (int i = 0; i < 3; ++i) {
            const int j = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
            const std::int64_t apart = magnitude_of(way[j] * m[k] - way[k] * m[j]);
            const std::int64_t together = h[j] * way_size[k] + h[k] * way_size[j];
            // `way` is rounded by less than one unit, m by two.
            if (apart > together + size[j] + size[k] + rounding[i]) return false;
        }
        return true;
    }

    /// `may_meet` for inner nodes of the tree. A box that moves by less than its size is compared by bounds
    /// alone: this is faster, but enters a few more nodes that hold no result.
    bool may_meet_node(const Bounds& b) const { return is_short ? overlap(hull, b) : may_meet(b); }

  private:
    Bounds hull;
    static std::int64_t magnitude_of(std::int64_t x) { return x < 0 ? -x : x; }

    std::int64_t middle[3], half_size[3]; ///< in steps
    std::int64_t way[3], way_size[3];     ///< half of the way and its size, in four steps
    std::int64_t rounding[3];             ///< bound of the errors that `way` causes, by axis of the test
    bool is_clamped = false;
    bool is_short = true; ///< it moves by at most its own size along each axis
};

} // namespace lockstone::collide
