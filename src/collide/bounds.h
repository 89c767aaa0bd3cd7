// Axis-aligned bounds of 32-bit integers, rounded outward, for the broad phase.
#pragma once

#include "shapes/asset/asset.h"

namespace lockstone::collide {

/// A closed box. One step of `Bound` is 2^(shift - 16) m; the whole world has one `shift` (0..8). Shift 0
/// covers +-32 km in steps of 15 um, shift 8 covers +-8388 km in steps of 4 mm.
struct Bounds {
    Vector3<Bound> lower, upper;

    friend constexpr bool operator==(const Bounds&, const Bounds&) = default;
};

inline constexpr int bounds_shift_max = 8;

/// A bound of the rounding errors of the rotation and of the narrow phase, in Length steps: 1 um for shapes of
/// up to 100 m. For larger shapes it grows in proportion to the size (see more_than in bounds.cpp).
inline constexpr std::int64_t bounds_guard = 16;

/// log2 of the ratio of one step of `Bound` to one step of Real.
constexpr int bounds_drop(int shift) { return Real::fraction_bits - Bound::fraction_bits + shift; }

/// Bounds that contain every point of the shape and every point nearer to it than `margin` (>= 0), including
/// roundings. They are at most 2 steps + 2 um + 2^-27 of the shape's size too large on each side; for a
/// compound, mesh or height field, compared with the box around it. Coordinates beyond the range are clamped:
/// shapes out there then overlap at the border, which gives a superset again. A plane fills all space.
Bounds bounds_of(const shapes::Solid& solid, const Transform& pose, Length margin, int shift = 0);
/// As above, with the rotation as a matrix `axes`.
Bounds bounds_of(const shapes::Solid& solid, Vec3 position, const Rotation& axes, Length margin, int shift);

/// As above for a sphere, which needs no rotation.
Bounds bounds_of_ball(const Geometry& ball, Vec3 position, Length margin, int shift);

/// A length in bound steps, rounded up.
constexpr Bound bound_steps(Length length, int shift) {
    const int drop = Length::fraction_bits - Bound::fraction_bits + shift;
    return Bound::from_raw(
        static_cast<std::int32_t>((std::int64_t{length.raw} + (std::int64_t{1} << drop) - 1) >> drop));
}

constexpr bool overlap(const Bounds& a, const Bounds& b) {
    // Not short-circuited: six predictable comparisons cost less than one mispredicted branch.
    return (a.lower.x.raw <= b.upper.x.raw) & (b.lower.x.raw <= a.upper.x.raw) &
           (a.lower.y.raw <= b.upper.y.raw) & (b.lower.y.raw <= a.upper.y.raw) &
           (a.lower.z.raw <= b.upper.z.raw) & (b.lower.z.raw <= a.upper.z.raw);
}
constexpr Bounds merge(const Bounds& a, const Bounds& b) {
    return {min(a.lower, b.lower), max(a.upper, b.upper)};
}
constexpr bool contains(const Bounds& outer, const Bounds& inner) {
    return (outer.lower.x.raw <= inner.lower.x.raw) & (inner.upper.x.raw <= outer.upper.x.raw) &
           (outer.lower.y.raw <= inner.lower.y.raw) & (inner.upper.y.raw <= outer.upper.y.raw) &
           (outer.lower.z.raw <= inner.lower.z.raw) & (inner.upper.z.raw <= outer.upper.z.raw);
}
constexpr Bounds expand(const Bounds& b, Bound by) {
    return {{b.lower.x - by, b.lower.y - by, b.lower.z - by},
            {b.upper.x + by, b.upper.y + by, b.upper.z + by}};
}

/// Half the surface, in units of 16 square steps, so that it fits 64 bits for any box. Needs lower <= upper.
constexpr std::int64_t half_area(const Bounds& b) {
    const std::int64_t x = (std::int64_t{b.upper.x.raw} - b.lower.x.raw) >> 2;
    const std::int64_t y = (std::int64_t{b.upper.y.raw} - b.lower.y.raw) >> 2;
    const std::int64_t z = (std::int64_t{b.upper.z.raw} - b.lower.z.raw) >> 2;
    return x * y + y * z + z * x;
}

} // namespace lockstone::collide
