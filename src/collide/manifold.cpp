// Computes a manifold from two convex cores and a normal.
//
// source: Gregorius, Robust Contact Creation for Physics Simulations, GDC 2015 (supporting features, one-shot
// manifolds).
#include "collide/manifold.h"

#include <limits>
#include <utility>

namespace lockstone::collide {
namespace {

/// A face can be the reference when its normal is within 0.5 degrees of the contact normal (cosine).
constexpr std::int64_t cosine_min_30 = (std::int64_t{1} << 30) - 40902;

bool serves(const Facing& f, Long3 direction, std::int64_t& cosine) {
    cosine = shift_right_rounded(dot(f.normal_30, direction), 30);
    return f.flat && cosine >= cosine_min_30;
}

/// A length that decides whether a shape is small: its smallest half extent, radius or inner radius, 24
/// fraction bits.
std::int64_t thickness(const Convex& shape) {
    const Long3& h = shape.half_24;
    switch (shape.core) {
    case Convex::Core::point:
    case Convex::Core::segment:
        return shape.radius.raw;
    case Convex::Core::triangle:
        return std::numeric_limits<std::int64_t>::max();
    case Convex::Core::hull:
        return shape.hull->inner_radius.raw;
    default:
        return smaller(h[0], smaller(h[1], h[2]));
    }
}

/// The bias for faces, 30 fraction bits. 1/64 of a length with 24 fraction bits is the same number with 30.
std::int64_t bias_of(const Convex& a, const Convex& b) {
    return smaller(up(face_bias.raw, 3), smaller(thickness(a), thickness(b)));
}

/// Radius of curvature across an edge or generator. The generator of a cone has none, because it ends in the
/// apex.
std::int64_t edge_radius_30(const Convex& shape) {
    return up(shape.radius.raw + (shape.core == Convex::Core::cylinder ? shape.half_24[0] : 0), 6);
}

/// Two edges that face each other: A's through `a` along `along_a`, B's through `b` along `along_b`.
struct Lines {
    Long3 a, b; // 30
    Direction along_a, along_b;

    Long3 on_a(std::int64_t s) const { return moved(a, along_a.unit, s); }
    Long3 on_b(std::int64_t s) const { return moved(b, along_b.unit, s); }
    /// Parameter of the point of B's line nearest to x; not clamped.
    std::int64_t beside_on_b(Long3 x) const { return dot_unit(x - b, along_b.unit); }
    std::int64_t beside_on_a(Long3 x) const { return dot_unit(x - a, along_a.unit); }

  private:
    static Long3 moved(Long3 from, Long3 unit, std::int64_t s) { return from + times_unit(unit, s); }
};

/// Adds two points where the edges run along each other. Returns false when they cross or diverge.
bool touch_along(Contact& c, const Lines& g, const SupportingFace& ea, const SupportingFace& eb) {
    const std::int64_t cosine = shift_right_rounded(dot(g.along_a.unit, g.along_b.unit), 30);
    if (absolute(cosine) < std::int64_t{1} << 29) return false;
    std::int64_t low = g.beside_on_a(eb.corners_30[0]), high = g.beside_on_a(eb.corners_30[1]);
    if (low > high) std::swap(low, high);
    low = larger(low, 0), high = smaller(high, g.along_a.length);
    if (low >= high) return false;
    const std::int64_t bias = bias_of(c.a, c.b),
                       radius = smaller(larger(edge_radius_30(c.a), bias), larger(edge_radius_30(c.b), bias));
    std::int64_t separation[2];
    const std::int64_t at[2] = {low, high};
    for (int k = 0; k < 2; ++k) {
        const Long3 x = g.on_a(at[k]);
        // The point of B's edge above x: the one with the position of x along A's edge.
        const std::int64_t u = g.beside_on_b(x), within = clamped(u, 0, g.along_b.length);
        if (absolute(u - within) > bias) return false;
        const Long3 gap = g.on_b(within) - x;
        const std::int64_t along = dot_unit(gap, c.normal_30);
        const std::int64_t off = direction_of_30(gap - times_unit(c.normal_30, along)).length;
        if (Wide::product(2 * bias, radius) < Wide::product(off, off)) return false;
        separation[k] = along - c.radius_a_30() - c.radius_b_30();
    }
    constexpr std::int64_t micrometre_30 = 1 << 10;
    if (smaller(separation[0], separation[1]) > c.separation_30 + bias + micrometre_30) return false;
    const std::uint32_t name = edges_of(edge_of(ea.ids[0], ea.ids[1]), edge_of(eb.ids[0], eb.ids[1]));
    // A low and a high point: the top bit distinguishes them, and no corner's name has it.
    for (std::uint32_t k = 0; k < 2; ++k) c.add_above_a(g.on_a(at[k]), separation[k], name ^ (k << 31));
    return true;
}

/// Number of dimensions in which the touching point may vary: 0 for a corner, 1 for an edge, 2 for a part of a
/// face.
int freedom(const SupportingFace& edge) { return edge.flat ? 2 : edge.count - 1; }

std::uint32_t single_name(const SupportingFace& ea, const SupportingFace& eb) {
    if (freedom(ea) == 0) return corner_of_a(ea.ids[0]);
    if (freedom(eb) == 0) return corner_of_b(eb.ids[0]);
    const auto name = [](const SupportingFace& e) { return edge_of(e.ids[0], e.ids[e.count - 1]); };
    return edges_of(name(ea), name(eb));
}

/// The closest points of two cores. For overlapping cores it first moves the second one along the normal until
/// they just separate, and subtracts the move from its point.
Gap touching_points(const Convex& a, const Convex& b, Long3 normal, std::int64_t separation_30) {
    // 15 um: far enough for a direction, near enough for the same place.
    constexpr std::int64_t gap_24 = 1 << 8;
    const std::int64_t by_24 = gap_24 - (separation_30 >> 6);
    if (by_24 <= 0) return closest_points(a, b);
    const Convex moved = moved_along(b, normal, by_24);
    Gap gap = closest_points(a, moved);
    gap.on_b_30 = gap.on_b_30 - up(moved.center_24 - b.center_24, 6);
    return gap;
}

/// A point of the straight line through a supporting edge of two corners; for a cylinder a point of its axis.
Long3 line_of(const Convex& shape, const SupportingFace& edge) {
    return shape.core == Convex::Core::cylinder ? up(shape.center_24, 6) : edge.corners_30[0];
}

/// The search for a normal on a cylinder's side stops at an error of a few nanometres, which is 1e-4 rad. For
/// two straight lines that face each other the exact normal is known: perpendicular to both, or from one to the
/// other when they are parallel. It replaces the normal found when it separates the cores as well.
void refine_normal(Difference& difference, Long3& normal, std::int64_t& separation) {
    const Convex &a = difference.a.convex(), &b = difference.b.convex();
    if (a.core != Convex::Core::cylinder && b.core != Convex::Core::cylinder) return;
    if (a.core == Convex::Core::cone || b.core == Convex::Core::cone) return;
    const SupportingFace ea = supporting_edge(a, normal), eb = supporting_edge(b, -normal);
    if (ea.count != 2 || eb.count != 2) return;
    const Long3 u = direction_of_30(ea.corners_30[1] - ea.corners_30[0]).unit,
                v = direction_of_30(eb.corners_30[1] - eb.corners_30[0]).unit;
    const Direction across = direction_of_30(shifted(cross(u, v), 30));
    Long3 better = across.unit;
    if (across.length < std::int64_t{1} << 22) { // within 0.004 rad of parallel
        const Long3 d = line_of(b, eb) - line_of(a, ea);
        better = direction_of_30(d - times_unit(u, dot_unit(d, u))).unit;
    }
    if (dot(better, normal) < 0) better = -better;
    constexpr std::int64_t noise_30 = 1 << 7; // 0.1 um
    const std::int64_t s = difference.separation_30(better);
    if (!is_zero(better) && s >= separation - noise_30) normal = better, separation = s;
}

/// Reach of a core of at most 128 m from its origin along a unit direction, 54 fraction bits; negative for
/// cores that it does not support.
std::int64_t reach_54(const Convex& shape, Long3 n) {
    const auto along = [&](int i) { return shift_right_rounded(dot(shape.axes_30[i], n), 30); };
    switch (shape.core) {
    case Convex::Core::point:
        return 0;
    case Convex::Core::segment:
        return absolute(along(1)) * shape.half_24[1];
    case Convex::Core::box:
        return absolute(along(0)) * shape.half_24[0] + absolute(along(1)) * shape.half_24[1] +
               absolute(along(2)) * shape.half_24[2];
    case Convex::Core::hull: {
        const Long3 local{along(0), along(1), along(2)};
        return larger(furthest_along_54(*shape.hull, shape.kernel, local), 0);
    }
    default:
        return -1;
    }
}

/// True when a unit direction separates the cores by more than a limit, 30 fraction bits, and the guard.
bool is_parted(const Convex& a, const Convex& b, Long3 n, std::int64_t limit_30) {
    const std::int64_t limit = limit_30 + hint_guard_30;
    const Long3 between = b.center_24 - a.center_24;
    // Within 128 m the products of the fast way fit, and its roundings are far below the guard. Larger shapes are
    // static and take the slow way.
    constexpr std::int64_t most = std::int64_t{1} << 31;
    if (limit < most << 6 && widest(between) < most && widest(a.half_24) < most && widest(b.half_24) < most) {
        const std::int64_t of_a = reach_54(a, n), of_b = reach_54(b, -n);
        if (of_a >= 0 && of_b >= 0) return (dot(between, n) >> 24) - (of_a >> 24) - (of_b >> 24) > limit;
    }
    return separation_along_30(a, b, n) > limit;
}

/// Depth of a point in a core with faces: the least distance to the plane of a face, 30 fraction bits. Zero for
/// other cores, and for points further than 128 m from the core's origin.
std::int64_t depth_in(const Convex& shape, Long3 at_30) {
    const Long3 from = shifted(at_30, 6) - shape.center_24;
    constexpr std::int64_t most = std::int64_t{1} << 31;
    if (widest(from) >= most) return 0;
    const auto along = [&](int i) { return shift_right_rounded(dot(shape.axes_30[i], from), 30); };
    const Long3 local{along(0), along(1), along(2)};
    std::int64_t least = most;
    if (shape.core == Convex::Core::box)
        for (int i = 0; i < 3; ++i) least = smaller(least, shape.half_24[i] - absolute(local[i]));
    else if (shape.core == Convex::Core::hull)
        for (const shapes::Hull::Face& face : shape.hull->faces)
            least = smaller(least, face.offset.raw - (dot(raw(face.normal), local) >> 30));
    else
        return 0;
    return up(larger(least, 0), 6);
}

/// Makes the manifold of the face that gave the last normal, while that face is as good as any other to within
/// the bias; or finds that it separates the shapes. Returns false when it can decide neither.
///
/// Let s be the separation along the best normal; no normal has a greater one. A face of A has a separation of
/// at least s - bias in these two cases:
/// * A point of B is over the face, and not higher than the face's separation plus the bias: s is not above
///   that height.
/// * B's furthest point below the face is in A, and no other face of A is nearer to it by more than the bias:
///   to separate the cores, that point must leave A.
///
/// For a face of B this holds with A and B exchanged.
bool keep_face(const Convex& a, const Convex& b, Long3 last_30, Length margin, Manifold& out) {
    if (has_discs(a) || has_discs(b)) return false;
    const Facing face_a = facing(a, last_30), face_b = facing(b, -last_30);
    std::int64_t cosine_a = 0, cosine_b = 0;
    if (face_a.flat) cosine_a = dot(face_a.normal_30, last_30);
    if (face_b.flat) cosine_b = -dot(face_b.normal_30, last_30);
    // Cosine of 7 degrees.
    constexpr std::int64_t same_face = (std::int64_t{1} << 60) - (std::int64_t{1} << 53);
    const bool by_a = cosine_a >= cosine_b;
    if (larger(cosine_a, cosine_b) < same_face) return false;
    const Long3 normal = by_a ? face_a.normal_30 : -face_b.normal_30;
    const SupportPoint top_a = support(a, normal), top_b = support(b, -normal);
    const Long3 on_a = top_a.at_30, on_b = top_b.at_30;
    const std::int64_t separation = dot_unit(on_b - on_a, normal), radii = up(a.radius.raw + b.radius.raw, 6),
                       bias = bias_of(a, b);
    out.normal = unit_of_30(normal);
    if (separation > radii + up(margin.raw, 6)) return true;
    if (separation < -bias && (by_a ? depth_in(a, on_b) : depth_in(b, on_a)) < -separation - bias)
        return false;
    Contact c{a, b, normal, separation - radii, margin, out};
    if (by_a)
        clip_to_face(c, false, face_at(a, face_a, last_30), supporting_face(b, -normal, top_b.id));
    else
        clip_to_face(c, true, face_at(b, face_b, -last_30), supporting_face(a, normal, top_a.id));
    std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
    for (std::uint32_t k = 0; k < out.count; ++k)
        lowest = smaller(lowest, up(out.points[k].separation.raw, 3));
    if (lowest <= c.separation_30 + bias) return true;
    out = Manifold{};
    return false;
}

/// The direction that separates two cores most, their separation along it, and where they touch along it.
struct Parting {
    Long3 normal_30{};
    std::int64_t separation_30 = 0;
    Touch touch;
    std::uint32_t edges =
        0; ///< name of the edges that touch, if they cross at 60 degrees or more; 0: unknown
    /// Hull corners furthest along the normal.
    std::uint32_t corner_a = unknown_corner, corner_b = unknown_corner;
};

/// Finds a corner of a box or hull, 30 fraction bits. Returns false when no corner has that id.
bool find_corner(const Convex& shape, std::uint32_t id, Long3& at_30) {
    if (shape.core == Convex::Core::hull) {
        if (id >= shape.hull->vertices.size()) return false;
        at_30 = corner_of(shape, id);
        return true;
    }
    if (shape.core != Convex::Core::box || id >= 8) return false;
    at_30 = up(shape.center_24, 6);
    for (int i = 0; i < 3; ++i) {
        const Long3 along = along_30(shape.axes_30[i], shape.half_24[i]);
        at_30 = (id >> i & 1u) != 0 ? at_30 + along : at_30 - along;
    }
    return true;
}

/// An edge between two corners, at most 16 m long on each axis.
struct Edge {
    Long3 from_30, along_30, along_24;
};
bool find_edge(const Convex& shape, std::uint32_t name, Edge& edge) {
    Long3 to{};
    if ((name >> 8) >= (name & 0xff) || !find_corner(shape, name >> 8, edge.from_30) ||
        !find_corner(shape, name & 0xff, to))
        return false;
    edge.along_30 = to - edge.from_30;
    edge.along_24 = shifted(edge.along_30, 6);
    return widest(edge.along_30) < std::int64_t{1} << 34;
}

/// The point of an edge's line nearest to another line, as a fraction of the edge, 30 fraction bits; negative
/// when it is not on the edge. `between` leads from the edge's first corner to the other edge's, `other` is
/// along the other edge (both 24 fraction bits), and `normal` is perpendicular to both.
std::int64_t part_beside(const Edge& edge, const Long3& between_24, const Long3& other_24,
                         const Long3& normal_30) {
    const Long3 across = shifted(cross(normal_30, other_24), 30);
    const std::int64_t whole = dot(edge.along_24, across), part = dot(between_24, across);
    if (whole == 0 || (part < 0) != (whole < 0) || absolute(part) > absolute(whole)) return -1;
    return divide_shifted(absolute(part), absolute(whole), 30);
}

/// Finds the parting along the common normal of the two crossing edges that made the last manifold. They must
/// face each other within both edges, and no direction may separate the cores by more than theirs and the bias.
/// Returns false when this is not certain.
///
/// Let p and q be the nearest points of the two lines. They are points of the cores, and q - p is along the
/// normal. When the cores are apart, p and q are their nearest points, because no corner is further along the
/// normal than the edges. When they overlap by at most the bias, every direction is good to within the bias.
/// When they overlap by more, q must leave A, or p must leave B, to separate the cores: the depth of that point
/// is a bound of the move.
bool keep_edges(Cores& cores, std::uint32_t edges, Long3 last_30, Parting& found) {
    const Convex &a = cores.a.convex(), &b = cores.b.convex();
    Edge on_a, on_b;
    if (!find_edge(a, edges >> 16, on_a) || !find_edge(b, edges & 0xffff, on_b)) return false;
    const Long3 between = on_b.from_30 - on_a.from_30;
    if (widest(between) >= std::int64_t{1} << 34) return false;
    const Long3 run_a = with_bits(on_a.along_30, 30), run_b = with_bits(on_b.along_30, 30),
                across = cross(run_a, run_b);
    // Edges that pass have an angle whose sine is at least 1/12. Edges whose widest component is just above a power
    // of two need a wider angle to pass. The search handles all others, which costs time but changes no result.
    if (widest(across) < std::int64_t{1} << 58) return false;
    Long3 normal = direction_of_30(with_bits(across, 31)).unit;
    if (dot(normal, last_30) < 0) normal = -normal;
    const Long3 between_24 = shifted(between, 6);
    const std::int64_t part_a = part_beside(on_a, between_24, on_b.along_24, normal),
                       part_b = part_beside(on_b, -between_24, on_a.along_24, normal);
    if (part_a < 0 || part_b < 0) return false;
    const SeparationAlong along = cores.separation(normal);
    const std::int64_t separation = along.separation_30;
    constexpr std::int64_t micrometre_30 = 1 << 10;
    if (separation < dot_unit(between, normal) - micrometre_30) return false;
    const Long3 p = on_a.from_30 + shifted(on_a.along_24 * part_a, 24),
                q = on_b.from_30 + shifted(on_b.along_24 * part_b, 24);
    const std::int64_t too_deep = -separation - bias_of(a, b);
    if (too_deep > 0 && depth_in(a, q) < too_deep && depth_in(b, p) < too_deep) return false;
    const Long3 sine = shifted(across, 32);
    const std::int64_t cosine = shift_right_rounded(dot(run_a, run_b), 32);
    const bool crosses = dot(sine, sine) > 3 * cosine * cosine;
    found = {normal, separation, {true, p, q}, crosses ? edges : 0, along.corner_a, along.corner_b};
    return true;
}

Parting find_parting(const Cores& cores, std::int64_t limit_30) {
    Difference difference(cores);
    Simplex simplex;
    const Gap gap = find_gap(difference, limit_30, difference.between(), simplex);
    Parting found{gap.normal_30, gap.distance_30, {true, gap.on_a_30, gap.on_b_30}};
    if (!gap.overlap && gap.distance_30 > limit_30) return found;
    if (gap.overlap) {
        found.touch.is_known = false;
        const Penetration p = find_move(difference, simplex, found.touch);
        found.normal_30 = p.normal_30, found.separation_30 = -p.depth_30;
    }
    refine_normal(difference, found.normal_30, found.separation_30);
    return found;
}

/// Adds the points of a face whose normal is within half a degree of the contact normal; none when there is no
/// such face.
void touch_faces(Contact& c) {
    const Facing face_a = facing(c.a, c.normal_30), face_b = facing(c.b, -c.normal_30);
    std::int64_t cosine_a = 0, cosine_b = 0;
    const bool a_serves = serves(face_a, c.normal_30, cosine_a),
               b_serves = serves(face_b, -c.normal_30, cosine_b);
    constexpr std::int64_t better = 1 << 6; // difference of cosines for 0.3 mrad
    if (!a_serves && !b_serves) return;
    const SupportingFace of_a = face_at(c.a, face_a, c.normal_30), of_b = face_at(c.b, face_b, -c.normal_30);
    if (a_serves && (!b_serves || cosine_b <= cosine_a + better))
        clip_to_face(c, false, of_a, of_b);
    else
        clip_to_face(c, true, of_b, of_a);
}

} // namespace

void touch_edges(Contact& c, const Touch& touch, std::uint32_t corner_a, std::uint32_t corner_b) {
    const SupportingFace ea = supporting_edge(c.a, c.normal_30, corner_a),
                         eb = supporting_edge(c.b, -c.normal_30, corner_b);
    if (freedom(ea) == 1 && freedom(eb) == 1) {
        const Lines g{ea.corners_30[0], eb.corners_30[0],
                      direction_of_30(ea.corners_30[1] - ea.corners_30[0]),
                      direction_of_30(eb.corners_30[1] - eb.corners_30[0])};
        if (touch_along(c, g, ea, eb) && c.out.count > 0) return;
    }
    const std::uint32_t name = single_name(ea, eb);
    if (touch.is_known) return c.add_between(touch.on_a_30, touch.on_b_30, name);
    const Gap found =
        touching_points(c.a, c.b, c.normal_30, c.separation_30 + c.radius_a_30() + c.radius_b_30());
    if (!found.overlap) return c.add_between(found.on_a_30, found.on_b_30, name);
    c.add_below_b(eb.corners_30[0], c.separation_30, name);
}

void manifold_from_faces(const Convex& a, const Convex& b, Long3 normal_30, std::int64_t separation_30,
                         Length margin, Manifold& out) {
    out = Manifold{};
    if (separation_30 > up(margin.raw, 6)) return;
    Contact c{a, b, normal_30, separation_30, margin, out};
    out.normal = unit_of_30(normal_30);
    touch_faces(c);
    if (out.count > 0) return;
    out.on_face = 0;
    touch_edges(c, Touch{});
}

void collide_convex(const Convex& a, const Convex& b, Length margin, Manifold& out, const PairHints& hints) {
    out = Manifold{};
    const std::int64_t radii = up(a.radius.raw + b.radius.raw, 6), limit = radii + up(margin.raw, 6);
    if (hints.apart != UnitVec3{} && is_parted(a, b, raw(hints.apart), limit)) {
        out.normal = hints.apart;
        return;
    }
    const bool was_edges = hints.edges != 0;
    if (!was_edges && hints.normal != UnitVec3{} && keep_face(a, b, raw(hints.normal), margin, out)) return;
    Cores cores(a, b);
    Parting best;
    if (!was_edges || !keep_edges(cores, hints.edges, raw(hints.normal), best))
        best = find_parting(cores, limit);
    const Long3 normal = best.normal_30;
    const std::int64_t separation = best.separation_30;
    out.normal = unit_of_30(normal);
    if (separation > limit) return;
    // If a face's separation is as good to within the bias, the face gives the normal; A's face is preferred.
    const std::int64_t bias = bias_of(a, b);
    const Facing face_a = facing(a, normal, best.corner_a), face_b = facing(b, -normal, best.corner_b);
    constexpr std::int64_t none = std::numeric_limits<std::int64_t>::min() / 2;
    SeparationAlong along_a{none, unknown_corner, unknown_corner}, along_b = along_a;
    if (face_a.flat) along_a = cores.separation(face_a.normal_30);
    if (face_b.flat) along_b = cores.separation(-face_b.normal_30);
    const std::int64_t of_a = along_a.separation_30, of_b = along_b.separation_30;
    const bool by_a = of_a >= separation - bias && of_a >= of_b - bias,
               by_b = !by_a && of_b >= separation - bias;
    if (by_a || by_b) {
        const Long3 of_face = by_a ? face_a.normal_30 : -face_b.normal_30;
        Contact c{a, b, of_face, (by_a ? of_a : of_b) - radii, margin, out};
        out.normal = unit_of_30(of_face);
        if (by_a)
            clip_to_face(c, false, face_at(a, face_a, normal),
                         supporting_face(b, -of_face, along_a.corner_b));
        else
            clip_to_face(c, true, face_at(b, face_b, -normal), supporting_face(a, of_face, along_b.corner_a));
        if (out.count > 0) return;
    }
    Contact c{a, b, normal, separation - radii, margin, out};
    out.normal = unit_of_30(normal);
    out.on_face = 0;
    if (best.edges != 0) return c.add_between(best.touch.on_a_30, best.touch.on_b_30, best.edges);
    touch_edges(c, best.touch, face_a.corner, face_b.corner);
}

} // namespace lockstone::collide
