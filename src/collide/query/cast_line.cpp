#include "collide/query/cast_line.h"

#include <algorithm>

namespace lockstone::collide {

bool make_line(CoordinateVec3 from, CoordinateVec3 way, Line& out) {
    if (!move_line(from, out)) return false;
    out.way_24 = raw(way);
    for (int i = 0; i < 3; ++i)
        if (out.way_24[i] > cast_length_max.raw || out.way_24[i] < -cast_length_max.raw) return false;
    const detail::SquareSum n = detail::square_sum(way); // below 2^78
    if ((n.high | n.low) == 0) {
        out.unit_60 = Long3{};
        out.length_30 = 0;
        return true;
    }
    const detail::InverseRoot root = detail::inverse_root(n.high, n.low);
    for (int i = 0; i < 3; ++i) out.unit_60[i] = detail::scaled_to_60(out.way_24[i], root);
    // Twelve more bits under the root give six more bits of the length.
    out.length_30 = static_cast<std::int64_t>(detail::isqrt(n.high << 12 | n.low >> 52, n.low << 12));
    return out.length_30 <= up(cast_length_max.raw, 6);
}

Span span_of_ball(const Line& line, Long3 center_24, std::int64_t radius_24) {
    constexpr std::int64_t guard_24 = 16; // the error that rounding the nearest point can cause
    // Deep inside a large ball the whole line is in it.
    const Long3 from_center = line.from_24 - center_24;
    const std::int64_t quarter = radius_24 / 4;
    if (absolute(from_center[0]) < quarter && absolute(from_center[1]) < quarter &&
        absolute(from_center[2]) < quarter && line.length_30 < up(quarter, 6))
        return {0, line.length_30};
    const std::int64_t nearest = nearest_30(line, center_24);
    const Long3 off = point_30(line, nearest) - up(center_24, 6);
    const std::int64_t r_30 = up(radius_24 + guard_24, 6);
    const Wide left = Wide::product(r_30, r_30) - Wide::product(off[0], off[0]) -
                      Wide::product(off[1], off[1]) - Wide::product(off[2], off[2]);
    if (left.is_negative()) return {1, 0};
    const std::int64_t half = static_cast<std::int64_t>(isqrt(left)) + up(guard_24, 6);
    return {larger(0, nearest - half), smaller(line.length_30, nearest + half)};
}

Span span_of_box(const Line& line, const shapes::Extent& box) {
    constexpr std::int64_t guard_30 = std::int64_t{16} << 6;
    Span span{0, line.length_30};
    const Long3 lower = raw(box.lower), upper = raw(box.upper);
    for (int i = 0; i < 3; ++i) {
        const std::int64_t o = line.from_24[i], u = line.unit_60[i];
        const std::int64_t low = up(lower[i] - o, 6) - guard_30, high = up(upper[i] - o, 6) + guard_30;
        if (u == 0) {
            if (low > 0 || high < 0) return {1, 0};
            continue;
        }
        const std::int64_t first = divide_shifted(u > 0 ? low : high, u, 60);
        const std::int64_t last = divide_shifted(u > 0 ? high : low, u, 60);
        span = {larger(span.enter_30, first), smaller(span.exit_30, last)};
    }
    return span;
}

CastHit hit_at(const Line& line, std::int64_t at_30, Long3 normal_30, std::uint32_t feature) {
    const std::int64_t at = clamped(at_30, 0, line.length_30);
    CastHit hit{};
    hit.distance = Coordinate::from_raw(shift_right_rounded(at, 6));
    hit.fraction = fraction_of(line, at);
    hit.point = coordinates(shifted(point_30(line, at), 6));
    hit.normal = unit_of_30(normal_30);
    hit.feature = feature;
    return hit;
}

CastHit hit_at_start(const Line& line, std::uint32_t feature) { return hit_at(line, 0, Long3{}, feature); }

std::int64_t reach_24(const shapes::Solid& solid) {
    const Geometry& g = solid.geometry;
    if (g.kind == ShapeKind::sphere || g.kind == ShapeKind::capsule)
        return (std::int64_t{g.radius.raw} + g.half_extent.y.raw) * (g.scale.x.raw >> 24);
    const shapes::Extent e = shapes::extent_of(solid);
    const Long3 low = raw(e.lower), high = raw(e.upper);
    Wide square = Wide::from(0);
    for (int i = 0; i < 3; ++i) {
        const std::int64_t widest = larger(absolute(low[i]), absolute(high[i]));
        square = square + Wide::product(widest, widest);
    }
    return static_cast<std::int64_t>(isqrt(square)) + 1;
}

bool is_convex(const shapes::Solid& solid) { return solid.geometry.kind <= ShapeKind::hull; }
RelativePose part_pose(const RelativePose& pose, const Transform& part) {
    return {pose.rotation * to_rotation(part.rotation),
            pose.position + lockstone::mul<Coordinate>(pose.rotation, part.position)};
}

} // namespace lockstone::collide
