// A box against a sphere or a capsule. While the core is outside of the box, the closest points decide; when it
// is inside, the axis of least overlap.
//
// source: Ericson, Real-Time Collision Detection, 5.1.3 and 5.2.5; the segment's squared distance to the box is convex
// and piecewise quadratic along the segment, so its least value is found between the breakpoints of its derivative.
#include "collide/integer.h"

namespace lockstone::collide {
namespace {

/// A core closer to the box than this counts as inside: too few bits of its direction remain [30 fraction
/// bits].
constexpr std::int64_t touching_30 = std::int64_t{1} << 14; // 15 um

/// Distance of a point beyond the box on each axis; zero within.
Long3 excess(Long3 point, Long3 half) {
    const auto beyond = [](std::int64_t x, std::int64_t h) { return x > h ? x - h : x < -h ? x + h : 0; };
    return {beyond(point[0], half[0]), beyond(point[1], half[1]), beyond(point[2], half[2])};
}

std::uint32_t face_bits(int axis, std::int64_t sign) {
    return static_cast<std::uint32_t>(2 * axis + (sign < 0 ? 1 : 0));
}

/// The capsule's core p(s) = center + s axis, |s| <= half_length, in the box's frame.
struct CoreAndBox {
    Long3 center, axis, half; // 24, 30, 24 fraction bits
    std::int64_t half_length; // 24
    Length radius, margin;

    /// The bias for faces, 30 fraction bits. 1/64 of a length with 24 fraction bits is the same number with 30.
    std::int64_t bias() const {
        return smaller(up(face_bias.raw, 3),
                       smaller(radius.raw, smaller(half[0], smaller(half[1], half[2]))));
    }

    Long3 at_54(std::int64_t s) const { return up(center, 30) + axis * s; }
    Long3 at_30(std::int64_t s) const { return shifted(at_54(s), 24); }
    /// Half the derivative of the squared distance to the box along the core, 54 fraction bits. It never
    /// decreases with s.
    std::int64_t slope(std::int64_t s) const { return dot(axis, excess(shifted(at_54(s), 30), half)); }
    /// Parameter at which coordinate i of the core is x, clamped to the core's ends. Needs axis[i] != 0.
    std::int64_t crossing(int i, std::int64_t x) const {
        return ratio_clamped(x - center[i], axis[i], 30, -half_length, half_length);
    }
};

/// The parameter of the core's point that is closest to the box.
std::int64_t closest_parameter(const CoreAndBox& g) {
    std::int64_t s[8] = {-g.half_length, g.half_length};
    int count = 2;
    const auto insert = [&](std::int64_t value) {
        int k = count++;
        for (; k > 0 && s[k - 1] > value; --k) s[k] = s[k - 1];
        s[k] = value;
    };
    for (int i = 0; i < 3; ++i) {
        if (g.axis[i] == 0) continue;
        insert(g.crossing(i, g.half[i]));
        insert(g.crossing(i, -g.half[i]));
    }
    std::int64_t before = g.slope(s[0]);
    if (before >= 0) return s[0];
    for (int k = 1; k < count; ++k) {
        const std::int64_t after = g.slope(s[k]);
        if (after >= 0) { // the slope changes by at most as much as s, so the difference fits
            const std::int64_t part_30 = divide_shifted(-before, after - before, 30);
            return s[k - 1] + shift_right_rounded((s[k] - s[k - 1]) * part_30, 30);
        }
        before = after;
    }
    return g.half_length;
}

/// The part of the core between the box's sides on all axes except the skipped ones; empty when low > high.
struct Stretch {
    std::int64_t low, high;
};
Stretch between_sides(const CoreAndBox& g, bool skip_x, bool skip_y, bool skip_z) {
    Stretch out{-g.half_length, g.half_length};
    const bool skip[3] = {skip_x, skip_y, skip_z};
    for (int i = 0; i < 3; ++i) {
        if (skip[i]) continue;
        const std::int64_t reach = (g.half_length * absolute(g.axis[i])) >> 30;
        if (absolute(g.center[i]) + reach <= g.half[i]) continue; // the whole core is between them
        if (g.axis[i] == 0 || absolute(g.center[i]) - reach > g.half[i]) return {1, 0};
        const std::int64_t a = g.crossing(i, g.half[i]), b = g.crossing(i, -g.half[i]);
        out.low = larger(out.low, smaller(a, b));
        out.high = smaller(out.high, larger(a, b));
    }
    return out;
}

/// Adds contacts of the core over the face `sign` of `axis`: at the ends of its part between the face's sides,
/// extended to its closest point s.
void add_face_points(const CoreAndBox& g, int axis, std::int64_t sign, std::int64_t s, Manifold& out) {
    Stretch over = between_sides(g, axis == 0, axis == 1, axis == 2);
    over = over.low > over.high ? Stretch{s, s} : Stretch{smaller(over.low, s), larger(over.high, s)};
    Long3 normal{};
    normal[axis] = sign << 30;
    out.normal = unit_of_30(normal);
    out.on_face = 1;
    const std::int64_t ends[2] = {over.low, over.high};
    for (std::uint32_t k = 0; k < (over.low == over.high ? 1u : 2u); ++k) {
        Long3 p = g.at_30(ends[k]);
        const std::int64_t separation = sign * p[axis] - up(g.half[axis] + g.radius.raw, 6);
        p[axis] = sign * (up(g.half[axis], 6) + (separation >> 1));
        add_point(out, p, separation, g.margin, face_bits(axis, sign) << 4 | k);
    }
}

/// Adds contacts of the core beside the box's edge along `axis`; `normal` is the direction at its closest
/// point. Adds two points when the core runs along the edge; returns false when it does not.
bool add_edge_line(const CoreAndBox& g, int axis, Long3 normal, Long3 at_closest, Manifold& out) {
    if (absolute(g.axis[axis]) < std::int64_t{1} << 29) return false;
    const Stretch along = between_sides(g, axis != 0, axis != 1, axis != 2);
    if (along.low >= along.high) return false;
    const std::int64_t ends[2] = {along.low, along.high};
    Long3 corner{}, from[2]; // the edge is at `corner` on the other two axes, 30 fraction bits
    std::int64_t distance[2];
    for (int i = 0; i < 3; ++i) corner[i] = i == axis ? 0 : up(sign_of(at_closest[i]) * g.half[i], 6);
    for (int k = 0; k < 2; ++k) {
        from[k] = g.at_30(ends[k]);
        Long3 gap = from[k] - corner;
        gap[axis] = 0;
        distance[k] = shift_right_rounded(dot(shifted(gap, 6), normal), 24);
        if (direction_of_30(gap).length - distance[k] > g.bias()) return false;
        for (int i = 0; i < 3; ++i)
            if (i != axis) from[k][i] = corner[i];
    }
    for (std::uint32_t k = 0; k < 2; ++k)
        add_round_point(out, from[k], normal, distance[k], Length{}, g.radius, g.margin,
                        0x100u | static_cast<std::uint32_t>(axis) << 4 | k);
    return true;
}

/// The core is outside of the box. `gap` leads from the box to the core's closest point at s.
void collide_outside(const CoreAndBox& g, std::int64_t s, Long3 gap, const Direction& to_core,
                     Manifold& out) {
    out.normal = unit_of_30(to_core.unit);
    if (to_core.length > up(std::int64_t{g.radius.raw} + g.margin.raw, 6)) return;
    int axis = 0, on_axes = 0, free_axis = 0;
    for (int i = 0; i < 3; ++i) {
        if (absolute(gap[i]) > absolute(gap[axis])) axis = i;
        if (gap[i] != 0)
            ++on_axes;
        else
            free_axis = i;
    }
    if (to_core.length - absolute(gap[axis]) <= g.bias())
        return add_face_points(g, axis, sign_of(gap[axis]), s, out);
    const Long3 point = g.at_30(s);
    if (on_axes == 2 && add_edge_line(g, free_axis, to_core.unit, point, out)) return;
    add_round_point(out, point - gap, to_core.unit, to_core.length, Length{}, g.radius, g.margin, 0x200u);
}

/// The axis of least overlap; `separation` of box and core along it has 30 fraction bits.
struct Overlap {
    std::int64_t separation;
    int axis;
    bool is_edge; // along e_axis x core; else along the face normal e_axis
};

Overlap least_overlap(const CoreAndBox& g) {
    Overlap best{std::numeric_limits<std::int64_t>::min(), 0, false};
    for (int i = 0; i < 3; ++i) {
        const std::int64_t s_54 =
            up(absolute(g.center[i]) - g.half[i], 30) - g.half_length * absolute(g.axis[i]);
        if (const std::int64_t s = s_54 >> 24; s > best.separation) best = {s, i, false};
    }
    best.separation += g.bias();
    const Overlap face = best;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const std::int64_t square = g.axis[j] * g.axis[j] + g.axis[k] * g.axis[k];
        if (square < std::int64_t{1} << 44) continue; // sin < 0.004: mostly rounding error, the faces decide
        // For all 32 bits of the root.
        const int spare = std::countl_zero(static_cast<std::uint64_t>(square)) / 2;
        const std::int64_t sin = isqrt(static_cast<std::uint64_t>(square) << (2 * spare));
        const std::int64_t s_54 = absolute(g.center[k] * g.axis[j] - g.center[j] * g.axis[k]) -
                                  g.half[j] * absolute(g.axis[k]) - g.half[k] * absolute(g.axis[j]);
        if (const std::int64_t s = divide_shifted(s_54, sin, 6 + spare); s > best.separation)
            best = {s, i, true};
    }
    return best.is_edge ? best : Overlap{face.separation - g.bias(), face.axis, false};
}

/// The core reaches into the box; its point at `touching` is inside.
void collide_inside(const CoreAndBox& g, std::int64_t touching, Manifold& out) {
    const Overlap overlap = least_overlap(g);
    const int i = overlap.axis, j = (i + 1) % 3, k = (i + 2) % 3;
    if (!overlap.is_edge) return add_face_points(g, i, sign_of(g.center[i]), touching, out);
    Long3 across{};
    across[j] = -g.axis[k];
    across[k] = g.axis[j];
    Long3 normal = direction_of_30(across).unit;
    if (dot(normal, g.center) < 0) normal = -normal;
    Long3 edge{}; // the point of the box's edge beside the core's closest point
    edge[j] = sign_of(normal[j]) * g.half[j];
    edge[k] = sign_of(normal[k]) * g.half[k];
    const std::int64_t square = g.axis[j] * g.axis[j] + g.axis[k] * g.axis[k];
    const std::int64_t along = (edge[j] - g.center[j]) * g.axis[j] + (edge[k] - g.center[k]) * g.axis[k];
    const std::int64_t s = ratio_clamped(along, square, 30, -g.half_length, g.half_length);
    Long3 point = up(edge, 6);
    point[i] = clamped(g.at_30(s)[i], -up(g.half[i], 6), up(g.half[i], 6));
    out.normal = unit_of_30(normal);
    add_round_point(out, point, normal, overlap.separation, Length{}, g.radius, g.margin, 0x200u);
}

} // namespace

void collide_box_sphere(const Geometry& a, const Geometry& b, const RelativePose& pose, Length margin,
                        Manifold& out) {
    const Long3 center = raw(pose.position), half = raw(a.half_extent);
    const Long3 gap = up(excess(center, half), 6);
    const Direction to_b = direction_of_30(gap);
    if (to_b.length > touching_30) {
        out.normal = unit_of_30(to_b.unit);
        out.on_face = (gap[0] != 0) + (gap[1] != 0) + (gap[2] != 0) == 1 ? 1 : 0;
        return add_round_point(out, up(center, 6) - gap, to_b.unit, to_b.length, Length{}, b.radius, margin,
                               1);
    }
    int axis = 0;
    const auto depth = [&](int i) { return absolute(center[i]) - half[i]; };
    for (int i = 1; i < 3; ++i)
        if (depth(i) > depth(axis)) axis = i;
    const std::int64_t sign = sign_of(center[axis]);
    Long3 normal{}, from = up(center, 6);
    normal[axis] = sign << 30;
    from[axis] = sign * up(half[axis], 6);
    out.normal = unit_of_30(normal);
    out.on_face = 1;
    add_round_point(out, from, normal, up(depth(axis), 6), Length{}, b.radius, margin, 1);
}

void collide_box_capsule(const Geometry& a, const Geometry& b, const RelativePose& pose, Length margin,
                         Manifold& out) {
    const CoreAndBox g{
        raw(pose.position), raw(pose.rotation.y), raw(a.half_extent), b.half_extent.y.raw, b.radius, margin};
    const std::int64_t s = closest_parameter(g);
    const Long3 gap = excess(g.at_30(s), up(g.half, 6));
    const Direction to_core = direction_of_30(gap);
    if (to_core.length > touching_30)
        collide_outside(g, s, gap, to_core, out);
    else
        collide_inside(g, s, out);
}

} // namespace lockstone::collide
