// What the casts share: a ray as a unit direction and a length, and how a hit is reported. A name's suffix tells the
// fraction bits.
#pragma once

#include "collide/integer.h"
#include "collide/query/cast.h"

namespace lockstone::collide {

/// The point from + unit * s for s in 0..length.
struct Line {
    Long3 from_24, way_24;
    Long3 unit_60; ///< zero for a way of no length
    std::int64_t length_30;
};
/// False when the way is longer than cast_length_max or starts further than 2^17 m away on an axis.
bool make_line(CoordinateVec3 from, CoordinateVec3 way, Line& out);
/// The same line from elsewhere.
inline bool move_line(CoordinateVec3 from, Line& line) {
    constexpr std::int64_t start_max_24 = std::int64_t{1} << (17 + 24);
    line.from_24 = raw(from);
    for (int i = 0; i < 3; ++i)
        if (line.from_24[i] > start_max_24 || line.from_24[i] < -start_max_24) return false;
    return true;
}

/// a . b without overflow, `drop` fraction bits rounded away. For components of up to 2^62 and sums below 2^126.
constexpr std::int64_t dot_dropped(Long3 a, Long3 b, int drop) {
    return narrow_rounded(Wide::product(a[0], b[0]) + Wide::product(a[1], b[1]) + Wide::product(a[2], b[2]),
                          drop);
}
/// Of two directions: never far from 1, so that nothing is clamped.
constexpr std::int64_t slope_60(Long3 direction_30, Long3 unit_60) {
    const Wide sum = Wide::product(direction_30[0], unit_60[0]) + Wide::product(direction_30[1], unit_60[1]) +
                     Wide::product(direction_30[2], unit_60[2]);
    return (static_cast<std::int64_t>((sum >> 29).low_bits()) + 1) >> 1;
}
constexpr std::int64_t times_60(std::int64_t x, std::int64_t unit_60) {
    return narrow_rounded(Wide::product(x, unit_60), 60);
}
constexpr Long3 times_60(Long3 unit_60, std::int64_t x) {
    constexpr std::int64_t small = std::int64_t{1} << 61; // no product is longer than x: nothing is clamped
    if (x < small && x > -small) [[likely]] {
        const auto rounded = [x](std::int64_t u) {
            return (static_cast<std::int64_t>((Wide::product(x, u) >> 59).low_bits()) + 1) >> 1;
        };
        return {rounded(unit_60[0]), rounded(unit_60[1]), rounded(unit_60[2])};
    }
    return {times_60(x, unit_60[0]), times_60(x, unit_60[1]), times_60(x, unit_60[2])};
}

/// The point at `at_30` of the line, with 30 fraction bits.
inline Long3 point_30(const Line& line, std::int64_t at_30) {
    return up(line.from_24, 6) + times_60(line.unit_60, at_30);
}

/// The same with 24 fraction bits; at the ends of the line exactly.
inline Long3 place_24(const Line& line, std::int64_t at_30) {
    if (at_30 <= 0) return line.from_24;
    if (at_30 >= line.length_30) return line.from_24 + line.way_24;
    const Long3 p = point_30(line, at_30);
    return shifted(p, 6);
}

/// The point of the line nearest to `center_24`, as a place along it: not clamped to the line's ends.
inline std::int64_t nearest_30(const Line& line, Long3 center_24) {
    return dot_dropped(center_24 - line.from_24, line.unit_60, 54);
}

/// The part of a line that can meet a ball: places along it. Empty when enter > exit.
struct Span {
    std::int64_t enter_30, exit_30;

    bool empty() const { return enter_30 > exit_30; }
};
/// Within 2^-20 m of what the line's part in the ball is, never less; within 0..length. Empty when it passes by.
Span span_of_ball(const Line& line, Long3 center_24, std::int64_t radius_24);
/// The same for a box.
Span span_of_box(const Line& line, const shapes::Extent& box);

/// The first of two hits: by distance, then feature.
inline bool comes_first(const CastHit& a, const CastHit& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.feature < b.feature;
}

/// How much of the line a place in it has behind it.
inline Unit fraction_of(const Line& line, std::int64_t at_30) {
    if (line.length_30 == 0) return Unit{};
    return Unit::from_raw(static_cast<std::int32_t>(divide_shifted(at_30, line.length_30, 30)));
}

/// A hit at a place of the line (clamped to its ends), with the normal of the surface.
CastHit hit_at(const Line& line, std::int64_t at_30, Long3 normal_30, std::uint32_t feature);
CastHit hit_at_start(const Line& line, std::uint32_t feature);

inline CoordinateVec3 coordinates(Long3 p_24) {
    return {Coordinate::from_raw(p_24[0]), Coordinate::from_raw(p_24[1]), Coordinate::from_raw(p_24[2])};
}

/// Radius of a ball about the solid's origin that holds it. Not of a plane.
std::int64_t reach_24(const shapes::Solid& solid);

/// A primitive at scale 1, a hull, or any of them rounded; what collide calls convex.
bool is_convex(const shapes::Solid& solid);
inline bool has_triangles(const shapes::Solid& solid) {
    return solid.geometry.kind == ShapeKind::mesh || solid.geometry.kind == ShapeKind::height_field;
}

/// The pose of a part of a solid that is at `pose`.
RelativePose part_pose(const RelativePose& pose, const Transform& part);

// The kinds. The line is in the solid's frame; `hit` is set when true is returned.
bool cast_ray_convex(const shapes::Solid& solid, const Line& line, CastHit& hit);
bool cast_ray_part(const shapes::Compound::Part& part, const Line& line, CastHit& hit);
bool cast_ray_triangles(const shapes::Solid& solid, const Line& line, NarrowScratch& scratch, CastHit& hit);

} // namespace lockstone::collide
