// source: Ericson, Real-Time Collision Detection, 4.2.6 (bounds of a rotated box from |R|)
#include "collide/bounds.h"

#include "lockstone/math/math.h"
#include "shapes/hull/hull.h"
#include "shapes/hull/support_kernel.h"

#include <limits>

namespace lockstone::collide {
namespace {

constexpr std::int64_t up_30 = (std::int64_t{1} << Unit::fraction_bits) - 1;

constexpr std::int64_t length_step = std::int64_t{1} << (Real::fraction_bits - Length::fraction_bits);

/// Reach of a shape from its origin along a world axis, in Length steps, rounded outward.
struct Reach {
    std::int64_t low, high;
};

std::int64_t times(Unit along, Length half) {
    return static_cast<std::int64_t>(magnitude(along.raw)) * half.raw;
}

/// Reach of a cylinder or cone. `r`: the world axis in the shape's axes.
Reach reach_of_discs(const Geometry& g, UnitVec3 r) {
    const LengthVec3& half = g.half_extent;
    const std::int64_t factor = g.scale.x.raw >> Length::fraction_bits;
    const auto ceiling = [&](std::int64_t sum_54) {
        return (((sum_54 + up_30) >> Unit::fraction_bits) + g.radius.raw) * factor;
    };
    const auto square =
        static_cast<std::uint64_t>(std::int64_t{r.x.raw} * r.x.raw + std::int64_t{r.z.raw} * r.z.raw);
    const std::int64_t rim = (std::int64_t{isqrt(square)} + 1) * half.x.raw; // of the disc
    const std::int64_t height = std::int64_t{r.y.raw} * half.y.raw;
    if (g.kind == ShapeKind::cylinder) {
        const std::int64_t reach = ceiling(rim + (height < 0 ? -height : height));
        return {-reach, reach};
    }
    const auto greater = [](std::int64_t a, std::int64_t b) { return a < b ? b : a; };
    return {-ceiling(greater(rim + height, -height)), ceiling(greater(rim - height, height))};
}

/// Reach along each row of a rotation. |r| is 2^30 up to rounding and |v| is below 2^8 m, so the sums fit.
void reach_of_hull(const shapes::Solid& solid, const Rotation& r, Reach (&out)[3]) {
    const shapes::Hull& hull = *solid.hull;
    const std::int32_t rows[3][3] = {{r.x.x.raw, r.y.x.raw, r.z.x.raw},
                                     {r.x.y.raw, r.y.y.raw, r.z.y.raw},
                                     {r.x.z.raw, r.y.z.raw, r.z.z.raw}};
    std::int64_t low[3], high[3];
    if (solid.kernel != nullptr)
        solid.kernel->reach(hull.lanes.data(), static_cast<std::uint32_t>(hull.lanes.size() / 3), rows, low,
                            high);
    else
        for (int i = 0; i < 3; ++i) {
            const shapes::Reach reach =
                shapes::reach_along(hull.vertices, {Unit::from_raw(rows[i][0]), Unit::from_raw(rows[i][1]),
                                                    Unit::from_raw(rows[i][2])});
            low[i] = reach.low_54, high[i] = reach.high_54;
        }
    const std::int64_t radius = solid.geometry.radius.raw;
    for (int i = 0; i < 3; ++i)
        out[i] = {(low[i] >> Unit::fraction_bits) - radius,
                  ((high[i] + up_30) >> Unit::fraction_bits) + radius};
}

/// Reach of an extent in asset coordinates, which are at most 2^20 m.
Reach reach_of_extent(const shapes::Extent& e, UnitVec3 r) {
    std::int64_t low = 0, high = 0;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t a = e.lower[i].raw, b = e.upper[i].raw, along = r[i].raw;
        low += narrow_rounded(Wide::product(along < 0 ? b : a, along), Unit::fraction_bits) - 1;
        high += narrow_rounded(Wide::product(along < 0 ? a : b, along), Unit::fraction_bits) + 1;
    }
    return {low, high};
}

/// Reach of a sphere, capsule or box along all three axes. Only a box has half extents along x and z.
void reach_of_round_box(const Geometry& g, const Rotation& r, Reach (&out)[3]) {
    const std::int64_t factor = g.scale.x.raw >> Length::fraction_bits;
    const bool is_box = g.kind == ShapeKind::box;
    for (int i = 0; i < 3; ++i) {
        std::int64_t along = times(r.y[i], g.half_extent.y);
        if (is_box) along += times(r.x[i], g.half_extent.x) + times(r.z[i], g.half_extent.z);
        const std::int64_t reach = (((along + up_30) >> Unit::fraction_bits) + g.radius.raw) * factor;
        out[i] = {-reach, reach};
    }
}
bool is_round_box(ShapeKind kind) {
    return kind == ShapeKind::sphere || kind == ShapeKind::capsule || kind == ShapeKind::box;
}

Reach reach_along(const shapes::Solid& solid, const shapes::Extent& extent, UnitVec3 r) {
    switch (solid.geometry.kind) {
    case ShapeKind::compound:
    case ShapeKind::height_field:
    case ShapeKind::mesh:
        return reach_of_extent(extent, r);
    default:
        return reach_of_discs(solid.geometry, r);
    }
}

bool has_extent(ShapeKind kind) {
    return kind == ShapeKind::compound || kind == ShapeKind::height_field || kind == ShapeKind::mesh;
}

/// Bounds from `low` to `high` around a position, in Length steps, rounded outward and clamped.
Bounds clamped_around(const Vec3& position, const Reach (&reaches)[3], int drop) {
    Bounds out;
    for (int i = 0; i < 3; ++i) {
        const auto at = [&](std::int64_t along_24) {
            return add_saturated(position[i].raw, along_24 * length_step);
        };
        out.lower[i] = Bound::from_raw(saturate_to_int32(at(reaches[i].low) >> drop));
        out.upper[i] = Bound::from_raw(saturate_to_int32((at(reaches[i].high) >> drop) + 1));
    }
    return out;
}
/// As clamped_around, but without clamps when everything is within 16 km of the origin. Rounds up by floor + 1.
Bounds bounds_around(const Vec3& position, const Reach (&reaches)[3], int drop) {
    constexpr std::uint64_t near = std::uint64_t{1} << (Real::fraction_bits + 14);
    Bounds out;
    std::uint64_t beyond = 0;
    for (int i = 0; i < 3; ++i) {
        const auto at = [&](std::int64_t along_24) {
            const auto raw = static_cast<std::uint64_t>(position[i].raw) +
                             static_cast<std::uint64_t>(along_24 * length_step);
            beyond |= raw + near;
            return static_cast<std::int64_t>(raw) >> drop;
        };
        out.lower[i] = Bound::from_raw(static_cast<std::int32_t>(at(reaches[i].low)));
        out.upper[i] = Bound::from_raw(static_cast<std::int32_t>(at(reaches[i].high) + 1));
    }
    return beyond < 2 * near ? out : clamped_around(position, reaches, drop);
}
/// The margin and the bound of the rounding errors, to add to a reach.
std::int64_t more_than(Reach reach, Length margin) {
    return margin.raw + bounds_guard + ((reach.high - reach.low) >> 28); // 2^32 steps: 256 m
}

} // namespace

Bounds bounds_of(const shapes::Solid& solid, const Transform& pose, Length margin, int shift) {
    return bounds_of(solid, pose.position, to_rotation(pose.rotation), margin, shift);
}

Bounds bounds_of_ball(const Geometry& ball, Vec3 position, Length margin, int shift) {
    const std::int64_t reach = ball.radius.raw * std::int64_t{ball.scale.x.raw >> Length::fraction_bits};
    const std::int64_t all = reach + more_than({-reach, reach}, margin);
    return bounds_around(position, {{-all, all}, {-all, all}, {-all, all}}, bounds_drop(shift));
}

Bounds bounds_of(const shapes::Solid& solid, Vec3 position, const Rotation& r, Length margin, int shift) {
    if (solid.geometry.kind == ShapeKind::plane) {
        const Vector3<Bound> low{Bound::min(), Bound::min(), Bound::min()},
            high{Bound::max(), Bound::max(), Bound::max()};
        return {low, high};
    }
    Reach reaches[3];
    if (is_round_box(solid.geometry.kind)) {
        reach_of_round_box(solid.geometry, r, reaches);
    } else if (solid.hull != nullptr) {
        reach_of_hull(solid, r, reaches);
    } else {
        const shapes::Extent extent =
            has_extent(solid.geometry.kind) ? shapes::extent_of(solid) : shapes::Extent{};
        for (int i = 0; i < 3; ++i) reaches[i] = reach_along(solid, extent, {r.x[i], r.y[i], r.z[i]});
    }
    for (Reach& reach : reaches) {
        const std::int64_t more = more_than(reach, margin);
        reach.low -= more, reach.high += more;
    }
    return bounds_around(position, reaches, bounds_drop(shift));
}

} // namespace lockstone::collide
