// The edges of a triangle against a convex shape: the normals that an edge may have, and the contact it gives.
//
// Beside an edge, the nearest point of a mesh is on the edge only while the direction to it lies between the
// normals of the edge's two triangles (the edge's Voronoi range). A contact with another direction belongs to a
// neighbour. If the edge accepted it, bodies would stumble over the seams of a flat floor.
// source: Terdiman, Contact generation for meshes (codercorner.com); Ericson, Real-Time Collision Detection,
// 5.1.5.
#include "collide/mesh/triangle_contact.h"

#include <limits>
#include <utility>

namespace lockstone::collide {
namespace {

/// Directions are compared with this tolerance [sine, 30 fraction bits].
constexpr std::int64_t range_tolerance_30 = 1 << 20;       // 0.001
constexpr std::int64_t flat_tolerance_30 = (1 << 30) / 20; // 3 degrees: for an edge that is not felt
constexpr std::int64_t end_tolerance_30 = 1 << 12;         // 4 um

Long3 cross_30(Long3 a, Long3 b) {
    return shifted(Long3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]},
                   30);
}
std::int64_t dot_30(Long3 a, Long3 b) { return shift_right_rounded(dot(a, b), 30); }

/// An edge, clipped to the range near B.
struct EdgeLine {
    Long3 from_24, to_24, along_30;
    std::int64_t length_30;
};
EdgeLine line_between(const Long3& from_24, const Long3& to_24) {
    const Direction d = direction_of_30(up(to_24 - from_24, 6));
    return {from_24, to_24, d.unit, d.length};
}
/// Writes the ends of the part of edge k near B. Returns false when there is no such part.
bool ends_of(const LocalTriangle& t, int k, Long3& from_24, Long3& to_24) {
    from_24 = t.corners_24[k];
    to_24 = t.corners_24[(k + 1) % 3];
    return (!t.is_far || near_part(from_24, to_24)) && !is_same(from_24, to_24);
}
bool edge_line(const LocalTriangle& t, int k, EdgeLine& e) {
    Long3 from_24, to_24;
    if (!ends_of(t, k, from_24, to_24)) return false;
    e = line_between(from_24, to_24);
    return true;
}

/// The gap of a ball: from the point of the edge nearest to B's centre.
EdgeGap gap_of_ball(const TriangleContext& c, const LocalTriangle& t, const EdgeLine& e) {
    EdgeGap g{};
    const Long3 to_center = c.shape.center_24 - e.from_24;
    const std::int64_t s = clamped(dot(to_center, e.along_30) >> 24, 0, e.length_30);
    g.at_from = s <= end_tolerance_30;
    g.at_to = s >= e.length_30 - end_tolerance_30;
    g.on_edge_30 = s == e.length_30 ? up(e.to_24, 6) : up(e.from_24, 6) + shifted(e.along_30 * (s >> 6), 24);
    const Direction d = direction_of_30(up(c.shape.center_24, 6) - g.on_edge_30);
    // A ball centred on the edge is pushed along the triangle's normal.
    g.normal_30 = d.length == 0 ? t.normal_30 : d.unit;
    g.separation_30 = d.length - c.radius_30;
    return g;
}

Convex segment_of(const EdgeLine& e) {
    Convex s{};
    s.core = Convex::Core::segment;
    s.center_24 = shifted(e.from_24 + e.to_24, 1);
    const UnitVec3 side = any_perpendicular(unit_of_30(e.along_30));
    s.axes_30[0] = raw(side);
    s.axes_30[1] = e.along_30;
    s.axes_30[2] = cross_30(raw(side), e.along_30);
    s.half_24 = {0, shift_right_rounded(e.length_30, 7), 0};
    return s;
}

EdgeGap gap_of(const TriangleContext& c, const LocalTriangle& t, const EdgeLine& e) {
    if (c.shape.core == Convex::Core::point) return gap_of_ball(c, t, e);
    const Convex segment = segment_of(e);
    EdgeGap g{};
    const std::int64_t limit_30 = c.radius_30 + up(c.margin.raw, 6);
    Difference difference(segment, c.shape);
    Simplex simplex;
    const Gap gap = find_gap(difference, larger(limit_30, 0), difference.between(), simplex);
    g.overlap = gap.overlap;
    if (gap.overlap) {
        Touch touch;
        const Penetration p = find_move(difference, simplex, touch);
        g.normal_30 = p.normal_30;
        g.separation_30 = -p.depth_30 - c.radius_30;
        return g;
    }
    g.normal_30 = gap.normal_30;
    g.separation_30 = gap.distance_30 - c.radius_30;
    if (gap.distance_30 > limit_30) return g;
    g.on_edge_30 = gap.on_a_30;
    const auto is_near = [&](Long3 end_24) {
        const Long3 d = gap.on_a_30 - up(end_24, 6);
        return larger(absolute(d[0]), larger(absolute(d[1]), absolute(d[2]))) <= end_tolerance_30;
    };
    g.at_from = is_near(e.from_24);
    g.at_to = is_near(e.to_24);
    return g;
}

bool is_before(Long3 a, Long3 b) {
    for (int i = 0; i < 3; ++i)
        if (a[i] != b[i]) return a[i] < b[i];
    return false;
}

KnownEdges::Entry* find_known(KnownEdges& known, Long3 from_24, Long3 to_24) {
    if (is_before(to_24, from_24)) std::swap(from_24, to_24);
    for (int i = 0; i < known.count; ++i)
        if (is_same(known.entries[i].from_24, from_24) && is_same(known.entries[i].to_24, to_24))
            return &known.entries[i];
    return nullptr;
}

/// True when B and an edge are certainly further apart than the margin: by a millimetre, far more than all
/// roundings.
bool are_parted(const TriangleContext& c, const Long3& from_24, const Long3& to_24) {
    constexpr std::int64_t guard_24 = 1 << 14;
    const std::int64_t margin = c.margin.raw + guard_24;
    if (c.shape.core == Convex::Core::point) { // 16 fraction bits, below 2^26
        const auto from_center = [&](const Long3& end_24) {
            const Long3 d = end_24 - c.shape.center_24;
            return Long3{d[0] >> 8, d[1] >> 8, d[2] >> 8};
        };
        const Long3 from = from_center(from_24), to = from_center(to_24), edge = to - from;
        const std::int64_t reach = ((margin + (c.radius_30 >> 6)) >> 8) + 1, square = reach * reach;
        const std::int64_t ahead = -dot(from, edge), whole = dot(edge, edge);
        if (ahead <= 0) return dot(from, from) > square;
        if (ahead >= whole) return dot(to, to) > square;
        return Wide::product(ahead, ahead) < Wide::product(dot(from, from) - square, whole);
    }
    for (int i = 0; i < 3; ++i) {
        const std::int64_t x = dot(c.shape.axes_30[i], from_24) >> 30,
                           y = dot(c.shape.axes_30[i], to_24) >> 30;
        if (smaller(x, y) > c.upper_24[i] + margin || larger(x, y) < c.lower_24[i] - margin) return true;
    }
    return false;
}

/// Adds the gap of an edge to the cache, with ends in an order that does not depend on the edge's direction.
/// Where the cache cannot hold all edges, edges apart from B take entries too: the entries that are replaced
/// decide which edges are written twice.
KnownEdges::Entry* add_known(TriangleContext& c, const LocalTriangle& t, const Long3& from_24,
                             const Long3& to_24) {
    const bool reversed = is_before(to_24, from_24);
    KnownEdges& known = c.edges;
    const int slot = known.count < KnownEdges::max ? known.count++ : known.oldest++ % KnownEdges::max;
    KnownEdges::Entry& entry = known.entries[slot];
    entry.from_24 = reversed ? to_24 : from_24;
    entry.to_24 = reversed ? from_24 : to_24;
    entry.written = false;
    if (!known.all_fit && are_parted(c, from_24, to_24)) {
        entry.gap.separation_30 = std::numeric_limits<std::int64_t>::max();
        return &entry;
    }
    EdgeLine line = line_between(from_24, to_24);
    if (reversed) line = {entry.from_24, entry.to_24, -line.along_30, line.length_30};
    entry.gap = gap_of(c, t, line);
    return &entry;
}

/// Position of a direction around an edge: on the inner side of the triangle's normal, between it and the
/// neighbour's normal, or past the neighbour's normal.
enum class EdgeSide : std::uint8_t { inward, between, past };
EdgeSide place_around(const LocalTriangle& t, int k, Long3 along_30, Long3 direction_30) {
    const Long3 outward = cross_30(along_30, t.normal_30);
    const std::int64_t up_d = dot_30(direction_30, t.normal_30), out_d = dot_30(direction_30, outward);
    const std::int64_t up_b = dot_30(t.beyond_30[k], t.normal_30), out_b = dot_30(t.beyond_30[k], outward);
    if ((t.felt >> k & 1u) == 0) {
        if (out_d <= flat_tolerance_30) return EdgeSide::between;
        return EdgeSide::past;
    }
    const std::int64_t before_30 = dot(Long3{up_d, out_d, 0}, Long3{out_b, -up_b, 0}) >> 30;
    if (out_d >= -range_tolerance_30 && before_30 >= -range_tolerance_30) return EdgeSide::between;
    return shift_right_rounded(up_d * up_b + out_d * out_b, 30) > up_d ? EdgeSide::past : EdgeSide::inward;
}

/// At an end of edge k, the other edge at that end must accept the direction too.
EdgeSide edge_side_of(const LocalTriangle& t, int k, const EdgeLine& e, const EdgeGap& g) {
    const EdgeSide own = place_around(t, k, e.along_30, g.normal_30);
    if (own != EdgeSide::between || g.at_from == g.at_to) return own;
    const int other = (k + (g.at_from ? 2 : 1)) % 3;
    EdgeLine line;
    if (!edge_line(t, other, line)) return own;
    const EdgeSide place = place_around(t, other, line.along_30, g.normal_30);
    return place == EdgeSide::inward ? own : place;
}

void nearest_contact(const TriangleContext& c, const EdgeGap& g, std::uint32_t feature, Manifold& out) {
    out.normal = unit_of_30(g.normal_30);
    const Long3 to_middle = shifted(g.normal_30 * (g.separation_30 >> 7), 24);
    add_point(out, g.on_edge_30 + to_middle, g.separation_30, c.margin, feature);
}

void write_contact(const TriangleContext& c, const LocalTriangle& t, int k, const EdgeLine& line,
                   const EdgeGap& g, Manifold& out) {
    out = Manifold{};
    const std::uint32_t edge = static_cast<std::uint32_t>(k);
    if (c.shape.core == Convex::Core::point) {
        return nearest_contact(c, g, feature_of(4, t.index, edge, 0), out);
    }
    manifold_from_faces(segment_of(line), c.shape, g.normal_30, g.separation_30, c.margin, out);
    // Only the edge's own normal is known to be within its range, so it replaces the normal of
    // manifold_from_faces.
    out.normal = unit_of_30(g.normal_30);
    out.on_face = 0;
    bool is_deep = false;
    for (std::uint32_t i = 0; i < out.count; ++i) {
        out.points[i].feature = feature_of(4, t.index, edge, out.points[i].feature);
        is_deep = is_deep || up(out.points[i].separation.raw, 3) <= g.separation_30 + c.face_bias_30;
    }
    if (is_deep || g.overlap) return;
    out = Manifold{}; // The supporting face of a smooth core is coarse: use the nearest points instead.
    nearest_contact(c, g, feature_of(4, t.index, edge, 0), out);
}

/// True when B, grown by the margin, extends past the side of edge k.
bool reaches(TriangleContext& c, LocalTriangle& t, int k) {
    need_side(t, k);
    const Long3 furthest = furthest_24(c, up(t.sides_27[k], 2));
    const std::int64_t reach_24 = (c.radius_30 >> 6) + c.margin.raw;
    return dot(t.sides_27[k], furthest) + up(reach_24, 28) > t.limits_51[k];
}

} // namespace

bool near_part(Long3& from_24, Long3& to_24) {
    const Long3 a = from_24, b = to_24;
    std::int64_t first = 0, last = std::int64_t{1} << 62; // range along the segment, 62 fraction bits
    bool whole = true;
    for (int i = 0; i < 3; ++i) {
        for (const std::int64_t sign : {-1, 1}) {
            const std::int64_t inside_a = near_24 - sign * a[i], inside_b = near_24 - sign * b[i];
            if (inside_a >= 0 && inside_b >= 0) continue;
            whole = false;
            if (inside_a < 0 && inside_b < 0) return false;
            const std::int64_t at = divide_shifted(inside_a, inside_a - inside_b, 62);
            if (inside_b < 0)
                last = smaller(last, at);
            else
                first = larger(first, at);
        }
    }
    if (whole) return true;
    if (first >= last) return false;
    for (int i = 0; i < 3; ++i) {
        from_24[i] = a[i] + narrow_rounded(Wide::product(b[i] - a[i], first), 62);
        to_24[i] = a[i] + narrow_rounded(Wide::product(b[i] - a[i], last), 62);
    }
    return true;
}

EdgeContact edge_contact(TriangleContext& c, LocalTriangle& t, std::int64_t lowest_30, bool has_face) {
    using Verdict = EdgeContact::Verdict;
    EdgeContact best{};
    for (int k = 0; k < 3; ++k) {
        if ((t.felt >> k & 1u) == 0) continue;
        const bool on_border = (t.border >> k & 1u) != 0 && lowest_30 >= -c.border_bias_30;
        const std::int64_t limit_30 = on_border ? 0 : up(c.margin.raw, 6);
        Long3 from_24, to_24;
        if ((on_border && has_face) || !ends_of(t, k, from_24, to_24)) continue;
        const KnownEdges::Entry* known = find_known(c.edges, from_24, to_24);
        if (known != nullptr && known->gap.separation_30 > limit_30) continue;
        if (known == nullptr && c.edges.all_fit && are_parted(c, from_24, to_24)) continue;
        if (!reaches(c, t, k)) continue;
        if (known == nullptr) known = add_known(c, t, from_24, to_24);
        if (known->gap.separation_30 > limit_30) continue;
        EdgeGap g = known->gap;
        if (is_before(to_24, from_24)) std::swap(g.at_from, g.at_to);
        const EdgeSide place = edge_side_of(t, k, line_between(from_24, to_24), g);
        if (place == EdgeSide::inward || (place == EdgeSide::past && !g.overlap)) continue;
        // When apart, the nearest edge is best; when overlapping, the edge with the least depth.
        const bool nearer =
            g.overlap ? g.separation_30 > best.separation_30 : g.separation_30 < best.separation_30;
        const bool better = best.verdict == Verdict::none || (g.overlap && !best.gap.overlap) ||
                            (g.overlap == best.gap.overlap && nearer);
        if (!better) continue;
        best = {Verdict::contact, k, g.separation_30, g};
        // When B is sunk by up to 5/32 of its inner ball, it rests on any border it overlaps: another mesh may
        // continue there.
        if (place == EdgeSide::past)
            best.verdict = Verdict::beyond;
        else if (on_border && g.separation_30 - lowest_30 <= c.border_bias_30 * 5 / 8)
            best.verdict = Verdict::upright;
    }
    return best;
}

Manifold edge_manifold(TriangleContext& c, const LocalTriangle& t, const EdgeContact& contact) {
    Manifold out;
    out.count = 0;
    Long3 from_24, to_24;
    if (!ends_of(t, contact.edge, from_24, to_24)) return out;
    KnownEdges::Entry* known = find_known(c.edges, from_24, to_24);
    if (known != nullptr && known->written) return out;
    if (known != nullptr) known->written = true;
    write_contact(c, t, contact.edge, line_between(from_24, to_24), contact.gap, out);
    return out;
}

PointDistance distance_from(LocalTriangle& t, Long3 point_24) {
    constexpr std::int64_t far_20 = std::int64_t{1} << 30;
    const std::int64_t height_20 = clamped(height_30(t, point_24) >> 10, -far_20, far_20);
    bool above = true;
    for (int k = 0; k < 3 && above; ++k) {
        need_side(t, k);
        above = dot(t.sides_27[k], point_24) <= t.limits_51[k];
    }
    if (above) return {absolute(height_20), height_20};
    std::int64_t least = far_20;
    for (int k = 0; k < 3; ++k) {
        EdgeLine e;
        if (!edge_line(t, k, e)) continue;
        const std::int64_t s = clamped(dot(point_24 - e.from_24, e.along_30) >> 24, 0, e.length_30);
        const Long3 nearest = up(e.from_24, 6) + shifted(e.along_30 * (s >> 6), 24);
        least = smaller(least, direction_of_30(up(point_24, 6) - nearest).length >> 10);
    }
    return {least, height_20};
}

} // namespace lockstone::collide
