// Shared by all casts: a ray as unit direction and length, and how a hit is reported. A name's suffix gives its
// fraction bits.
#pragma once

#include "collide/integer.h"
#include "collide/query/cast.h"

namespace lockstone::collide {

/// The points from + unit * s for s in 0..length.
struct Line {
    Long3 from_24, way_24;
    Long3 unit_60; ///< zero when the length is zero
    std::int64_t length_30;
};
/// Returns false when `way` is longer than cast_length_max, or `from` is further than 2^17 m from the origin on
/// an axis.
bool make_line(CoordinateVec3 from, CoordinateVec3 way, Line& out);
/// Replaces the start of the line. Returns false when it is further than 2^17 m from the origin on an axis.
inline bool move_line(CoordinateVec3 from, Line& line) {
    constexpr std::int64_t start_max_24 = std::int64_t{1} << (17 + 24);
    line.from_24 = raw(from);
    for (int i = 0; i < 3; ++i)
        if (line.from_24[i] > start_max_24 || line.from_24[i] < -start_max_24) return false;
    return true;
}

/// a . b without overflow, rounded to `drop` fewer fraction bits. For components of up to 2^62 and sums below
/// 2^126.
constexpr std::int64_t dot_dropped(Long3 a, Long3 b, int drop) {
    return narrow_rounded(Wide::product(a[0], b[0]) + Wide::product(a[1], b[1]) + Wide::product(a[2], b[2]),
                          drop);
}
/// Dot product of two unit directions: its magnitude is near 1 at most, so it needs no clamp.
constexpr std::int64_t slope_60(Long3 direction_30, Long3 unit_60) {
    const Wide sum = Wide::product(direction_30[0], unit_60[0]) + Wide::product(direction_30[1], unit_60[1]) +
                     Wide::product(direction_30[2], unit_60[2]);
    return (static_cast<std::int64_t>((sum >> 29).low_bits()) + 1) >> 1;
}
constexpr std::int64_t times_60(std::int64_t x, std::int64_t unit_60) {
    return narrow_rounded(Wide::product(x, unit_60), 60);
}
constexpr Long3 times_60(Long3 unit_60, std::int64_t x) {
    // No component of the product exceeds x, so it needs no clamp.
    constexpr std::int64_t small = std::int64_t{1} << 61;
    if (x < small && x > -small) [[likely]] {
        const auto rounded = [x](std::int64_t u) {
            return (static_cast<std::int64_t>((Wide::product(x, u) >> 59).low_bits()) + 1) >> 1;
        };
        return {rounded(unit_60[0]), rounded(unit_60[1]), rounded(unit_60[2])};
    }
    return {times_60(x, unit_60[0]), times_60(x, unit_60[1]), times_60(x, unit_60[2])};
}

/// The point at the distance `at_30` along the line, with 30 fraction bits.
inline Long3 point_30(const Line& line, std::int64_t at_30) {
    return up(line.from_24, 6) + times_60(line.unit_60, at_30);
}

/// As above with 24 fraction bits; exact at the ends of the line.
inline Long3 place_24(const Line& line, std::int64_t at_30) {
    if (at_30 <= 0) return line.from_24;
    if (at_30 >= line.length_30) return line.from_24 + line.way_24;
    const Long3 p = point_30(line, at_30);
    return shifted(p, 6);
}

/// Distance along the line of its point nearest to `center_24`, not clamped to the line's ends.
inline std::int64_t nearest_30(const Line& line, Long3 center_24) {
    return dot_dropped(center_24 - line.from_24, line.unit_60, 54);
}

/// A range of distances along a line. Empty when enter > exit.
struct Span {
    std::int64_t enter_30, exit_30;

    bool empty() const { return enter_30 > exit_30; }
};
/// A superset of the line's part in a ball: its part in a ball that is 2^-20 m larger, extended by 2^-20 m on each
/// side and clipped to 0..length. Empty when the line misses the larger ball.
Span span_of_ball(const Line& line, Long3 center_24, std::int64_t radius_24);
/// A superset of the line's part in a box: its part in a box that is 2^-20 m larger on all sides.
Span span_of_box(const Line& line, const shapes::Extent& box);

/// Compares two hits by distance, then by feature.
inline bool comes_first(const CastHit& a, const CastHit& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.feature < b.feature;
}

/// A distance along the line as a fraction of its length; 0 for a line of length zero.
inline Unit fraction_of(const Line& line, std::int64_t at_30) {
    if (line.length_30 == 0) return Unit{};
    return Unit::from_raw(static_cast<std::int32_t>(divide_shifted(at_30, line.length_30, 30)));
}

/// A hit at a distance along the line (clamped to its ends), with the normal of the surface.
CastHit hit_at(const Line& line, std::int64_t at_30, Long3 normal_30, std::uint32_t feature);
CastHit hit_at_start(const Line& line, std::uint32_t feature);

inline CoordinateVec3 coordinates(Long3 p_24) {
    return {Coordinate::from_raw(p_24[0]), Coordinate::from_raw(p_24[1]), Coordinate::from_raw(p_24[2])};
}

/// Radius of a ball around the solid's origin that contains the solid. Not for a plane.
std::int64_t reach_24(const shapes::Solid& solid);

/// True for primitives and hulls; false for compounds, height fields, meshes and planes.
bool is_convex(const shapes::Solid& solid);
inline bool has_triangles(const shapes::Solid& solid) {
    return solid.geometry.kind == ShapeKind::mesh || solid.geometry.kind == ShapeKind::height_field;
}

/// The pose of a part of a solid that has the pose `pose`.
RelativePose part_pose(const RelativePose& pose, const Transform& part);

// The casts for each kind of solid. The line is in the solid's frame. `hit` is set when the result is true.
bool cast_ray_convex(const shapes::Solid& solid, const Line& line, CastHit& hit);
bool cast_ray_part(const shapes::Compound::Part& part, const Line& line, CastHit& hit);
bool cast_ray_triangles(const shapes::Solid& solid, const Line& line, NarrowScratch& scratch, CastHit& hit);

} // namespace lockstone::collide
