// Closed forms for a point against a cylinder or cone, in the plane of the axis and the point, and against a
// triangle.
//
// source: Ericson, Real-Time Collision Detection, 5.1 (closest points by regions).
#include "collide/pairs/point.h"

#include "collide/core.h"

namespace lockstone::collide {
namespace {

/// A point in the half plane from the axis outward: `rim` is the distance from the axis, `y` the height along
/// it; 30 fraction bits.
struct Profile {
    std::int64_t rim, y;
};

/// The nearest point of a profile: the outward normal there, and the distance of the point along it.
struct NearestOfProfile {
    Profile normal; ///< unit
    std::int64_t distance;
};

NearestOfProfile off_corner(Profile from) {
    const Direction d = direction_of_30({from.rim, from.y, 0});
    return {{d.unit[0], d.unit[1]}, d.length};
}

NearestOfProfile nearest_of_cylinder(Profile p, std::int64_t radius, std::int64_t half) {
    const std::int64_t side = p.rim - radius, cap = absolute(p.y) - half,
                       up_or_down = p.y < 0 ? -one_30 : one_30;
    if (side > 0 && cap > 0) return off_corner({side, p.y < 0 ? -cap : cap});
    if (side > cap) return {{one_30, 0}, side};
    return {{0, up_or_down}, cap};
}

NearestOfProfile nearest_of_cone(Profile p, std::int64_t radius, std::int64_t half) {
    const Direction side = direction_of_30({2 * half, radius, 0}); // its outward normal
    const Profile n{side.unit[0], side.unit[1]};
    const auto along = [](Profile a, Profile b) {
        return narrow_rounded(Wide::product(a.rim, b.rim) + Wide::product(a.y, b.y), 30);
    };
    const std::int64_t off_side = along(n, {p.rim, p.y - half}), off_base = -half - p.y;
    if (off_side <= 0 && off_base <= 0)
        return off_side > off_base ? NearestOfProfile{n, off_side} : NearestOfProfile{{0, -one_30}, off_base};
    if (off_base > 0 && p.rim <= radius) return {{0, -one_30}, off_base};
    const Profile to_apex{-n.y, n.rim}; // along the side, from the rim of the base
    if (along(to_apex, {p.rim - radius, p.y + half}) <= 0) return off_corner({p.rim - radius, p.y + half});
    if (along(to_apex, {p.rim, p.y - half}) >= 0) return off_corner({p.rim, p.y - half});
    return {n, off_side};
}

/// A triangle relative to the point, 24 fraction bits: all coordinates are below 2^29, so products of two are
/// below 2^62.
struct RelativeTriangle {
    static constexpr int finer =
        /// nearest points have 36 fraction bits: roundings then affect the direction to them less
        12;
    Long3 a, b, c;

    Long3 edge(Long3 from, Long3 to, std::int64_t part, std::int64_t whole) const {
        const std::int64_t part_60 = divide_shifted(part, whole, 60);
        const Long3 way = up(to - from, finer);
        const auto one = [&](std::int64_t x) { return narrow_rounded(Wide::product(x, part_60), 60); };
        return up(from, finer) + Long3{one(way[0]), one(way[1]), one(way[2])};
    }
};

/// Finds the nearest point if it is on the border of the triangle; returns false when it is inside. Decides by
/// the Voronoi regions of corners and edges; each sign is that of an exact integer.
bool nearest_on_border(const RelativeTriangle& t, Long3& out_36) {
    const Long3 ab = t.b - t.a, ac = t.c - t.a;
    const std::int64_t d1 = -dot(ab, t.a), d2 = -dot(ac, t.a);
    if (d1 <= 0 && d2 <= 0) return out_36 = up(t.a, t.finer), true;
    const std::int64_t d3 = -dot(ab, t.b), d4 = -dot(ac, t.b);
    if (d3 >= 0 && d4 <= d3) return out_36 = up(t.b, t.finer), true;
    const auto is_beyond = [](std::int64_t p, std::int64_t q, std::int64_t r, std::int64_t s) {
        return !(Wide::product(r, s) < Wide::product(p, q)); // p q <= r s
    };
    if (d1 >= 0 && d3 <= 0 && is_beyond(d1, d4, d3, d2)) return out_36 = t.edge(t.a, t.b, d1, d1 - d3), true;
    const std::int64_t d5 = -dot(ab, t.c), d6 = -dot(ac, t.c);
    if (d6 >= 0 && d5 <= d6) return out_36 = up(t.c, t.finer), true;
    if (d2 >= 0 && d6 <= 0 && is_beyond(d5, d2, d1, d6)) return out_36 = t.edge(t.a, t.c, d2, d2 - d6), true;
    const std::int64_t from_b = d4 - d3, from_c = d5 - d6;
    if (from_b >= 0 && from_c >= 0 && is_beyond(d3, d6, d5, d4))
        return out_36 = t.edge(t.b, t.c, from_b, from_b + from_c), true;
    return false;
}

} // namespace

bool triangle_gap(const Convex& a, const Convex& b, Gap& out) {
    const bool swapped = a.core == Convex::Core::point;
    const Convex &triangle = swapped ? b : a, &point = swapped ? a : b;
    if (triangle.core != Convex::Core::triangle || point.core != Convex::Core::point) return false;
    const RelativeTriangle t{triangle.corners_24[0] - point.center_24,
                             triangle.corners_24[1] - point.center_24,
                             triangle.corners_24[2] - point.center_24};
    if (larger(widest(t.a), larger(widest(t.b), widest(t.c))) >= std::int64_t{1} << 29) return false;
    const Long3 at = up(point.center_24, 6);
    Long3 nearest{}; // from the point, first with 36 fraction bits
    Direction way{}; // to the point
    std::int64_t least_30 = std::int64_t{1} << 24;
    if (nearest_on_border(t, nearest)) {
        way = direction_of_30(-nearest);
        way.length = shift_right_rounded(way.length, 6);
        nearest = shifted(nearest, 6);
    } else {
        least_30 = std::int64_t{1} << 20;
        way.unit = direction_of_30(cross(t.b - t.a, t.c - t.a)).unit;
        way.length = shift_right_rounded(-dot(way.unit, t.a), 24);
        if (way.length < 0) way = {-way.unit, -way.length};
        for (int i = 0; i < 3; ++i) nearest[i] = -narrow_rounded(Wide::product(way.unit[i], way.length), 30);
    }
    // For nearer points a rounding of the nearest point would change the direction.
    if (way.length < least_30) return false;
    out = {false, swapped ? -way.unit : way.unit, way.length, swapped ? at : at + nearest,
           swapped ? at + nearest : at};
    return true;
}

bool has_point_form(const Convex& a, const Convex& b) {
    const auto is_round = [](const Convex& x) {
        return x.core == Convex::Core::cylinder || x.core == Convex::Core::cone;
    };
    return (is_round(a) && b.core == Convex::Core::point) || (a.core == Convex::Core::point && is_round(b));
}

PointForm point_form(const Convex& a, const Convex& b) {
    const bool swapped = a.core == Convex::Core::point;
    const Convex &round = swapped ? b : a, &point = swapped ? a : b;
    const Long3 at = up(point.center_24, 6), offset = at - up(round.center_24, 6);
    const auto local = [&](int i) { return narrow_rounded(wide_dot(round.axes_30[i], offset), 30); };
    const Direction flat = direction_of_30({local(0), 0, local(2)});
    const Long3 outward = flat.length == 0 ? Long3{one_30, 0, 0} : flat.unit; // on the axis: along local x
    const Profile p{flat.length, local(1)};
    const std::int64_t radius = up(round.half_24[0], 6), half = up(round.half_24[1], 6);
    const NearestOfProfile nearest = round.core == Convex::Core::cylinder
                                         ? nearest_of_cylinder(p, radius, half)
                                         : nearest_of_cone(p, radius, half);
    const Long3 n{shift_right_rounded(outward[0] * nearest.normal.rim, 30), nearest.normal.y,
                  shift_right_rounded(outward[2] * nearest.normal.rim, 30)};
    Long3 normal{};
    for (int i = 0; i < 3; ++i)
        normal[i] = shift_right_rounded(
            round.axes_30[0][i] * n[0] + round.axes_30[1][i] * n[1] + round.axes_30[2][i] * n[2], 30);
    Long3 on_round{};
    for (int i = 0; i < 3; ++i)
        on_round[i] = at[i] - narrow_rounded(Wide::product(normal[i], nearest.distance), 30);
    return {swapped ? -normal : normal, nearest.distance, swapped ? at : on_round, swapped ? on_round : at};
}

} // namespace lockstone::collide
