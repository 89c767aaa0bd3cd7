// Closest points of two convex cores: GJK in which every decision is exact.
//
// The difference A - B has integer vertices (core.h). The origin's closest point in the simplex is always an
// interior point of the simplex. A new vertex is accepted only when it is strictly nearer than the plane
// through that point, and the new closest simplex contains the new vertex. The signs of integers of at most 124
// bits decide which part of the simplex that is. So the distance strictly decreases with each step, no simplex
// is ever degenerate, and the search ends.
//
// source: Gilbert, Johnson, Keerthi, A Fast Procedure for Computing the Distance Between Complex Objects, 1988;
// Ericson, Real-Time Collision Detection, 5.1.5 and 9.5 (Voronoi regions of a simplex).
#include "collide/core.h"
#include "collide/pairs/point.h"

#include <utility>

namespace lockstone::collide {
namespace {

/// Smooth cores approach without end; the error after so many steps is far below a micrometre.
constexpr int gjk_steps_max = 128;

/// How a step ended.
enum class Step { nearer, closest, holds };

/// Reduces the simplex to a vertex, edge or triangle of the given vertices; the last one is the new vertex.
Step keep(Simplex& s, const Vertex& a) {
    s.v[0] = a;
    s.count = 1;
    if (is_zero(a.w)) return Step::holds;
    s.direction = with_bits(a.w, 30);
    return Step::nearer;
}
Step keep(Simplex& s, const Vertex& b, const Vertex& a) {
    const Vertex first = b, second = a;
    s.v[0] = first, s.v[1] = second;
    s.count = 2;
    const Long3 around = with_bits(cross(first.w, second.w), 31);
    if (is_zero(around)) return Step::holds;
    s.direction = with_bits(cross(second.w - first.w, around), 30);
    return Step::nearer;
}
Step keep(Simplex& s, const Vertex& c, const Vertex& b, const Vertex& a, Long3 normal) {
    const Vertex first = c, second = b, third = a;
    s.v[0] = first, s.v[1] = second, s.v[2] = third;
    s.count = 3;
    const int side = sign_of(wide_dot(normal, third.w));
    if (side == 0) return Step::holds;
    s.direction = with_bits(side < 0 ? -normal : normal, 30);
    return Step::nearer;
}

/// True when the closest point is past `from` in the direction of `to`.
bool leads_to(const Vertex& from, const Vertex& to) { return dot(to.w - from.w, from.w) < 0; }

Step from_vertex(Simplex& s, const Vertex& a) {
    const Vertex b = s.v[0];
    if (dot(b.w, a.w - b.w) >= 0) return Step::closest;
    return leads_to(a, b) ? keep(s, b, a) : keep(s, a);
}

/// True when a is nearer than the closest point of the line through b and c. Computes the sign of
/// (b (e e) - e (b e)) (a - b).
bool is_nearer_than_line(Long3 b, Long3 c, Long3 a) {
    const Long3 e = c - b, u = a - b;
    return (Wide::product(dot(b, u), dot(e, e)) - Wide::product(dot(e, u), dot(b, e))).is_negative();
}

Step from_edge(Simplex& s, const Vertex& a) {
    const Vertex b = s.v[0], c = s.v[1];
    if (!is_nearer_than_line(b.w, c.w, a.w)) return Step::closest;
    const Long3 normal = cross(b.w - a.w, c.w - a.w);
    const bool beyond_c = !wide_dot(normal, cross(a.w, c.w)).is_negative();
    if (beyond_c && leads_to(a, c)) return keep(s, c, a);
    if (beyond_c || !(Wide::from(0) < wide_dot(normal, cross(a.w, b.w))))
        return leads_to(a, b) ? keep(s, b, a) : keep(s, a);
    return keep(s, b, c, a, normal);
}

/// The three faces at the new vertex a: face k contains x[k] and x[k + 1], and its normal points outward.
Step from_triangle(Simplex& s, const Vertex& a) {
    Vertex x[3] = {s.v[0], s.v[1], s.v[2]};
    const Long3 base = cross(x[1].w - x[0].w, x[2].w - x[0].w);
    const int volume = sign_of(wide_dot(base, a.w - x[0].w)), side = sign_of(wide_dot(base, x[0].w));
    if (volume * side >= 0) return Step::closest;
    if (volume < 0) std::swap(x[1], x[2]);
    Long3 edge[3], normal[3];
    for (int k = 0; k < 3; ++k) edge[k] = x[k].w - a.w;
    bool out[3], any = false;
    for (int k = 0; k < 3; ++k) {
        normal[k] = cross(edge[k], edge[(k + 1) % 3]);
        out[k] = wide_dot(normal[k], a.w).is_negative();
        any = any || out[k];
    }
    if (!any) {
        s.v[0] = x[0], s.v[1] = x[1], s.v[2] = x[2], s.v[3] = a;
        s.count = 4;
        return Step::holds;
    }
    bool beyond_first[3], beyond_second[3]; // past the edges a x[k] and a x[k + 1] of face k
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        beyond_first[k] = !(Wide::from(0) < wide_dot(normal[k], cross(a.w, x[k].w)));
        beyond_second[k] = !wide_dot(normal[k], cross(a.w, x[next].w)).is_negative();
        if (out[k] && !beyond_first[k] && !beyond_second[k]) return keep(s, x[k], x[next], a, normal[k]);
    }
    for (int k = 0; k < 3; ++k)
        if (beyond_first[k] && beyond_second[(k + 2) % 3] && leads_to(a, x[k]) && leads_to(x[k], a))
            return keep(s, x[k], a);
    return keep(s, a);
}

Step advance(Simplex& s, const Vertex& a) {
    switch (s.count) {
    case 0:
        return keep(s, a);
    case 1:
        return from_vertex(s, a);
    case 2:
        return from_edge(s, a);
    default:
        return from_triangle(s, a);
    }
}

/// Tests along / |direction| > limit exactly; `along` is direction . w of a vertex. No coordinate exceeds 2^29,
/// so the result is false for limits of 2^30 and more.
bool is_beyond(std::int64_t along, Long3 direction, std::int64_t limit) {
    if (along <= 0 || limit < 0 || limit >= std::int64_t{1} << 30) return false;
    return Wide::product(limit * limit, dot(direction, direction)) < Wide::product(along, along);
}

/// 2^60 n / d for 0 <= n <= d, both below 2^126.
std::int64_t part_60(Wide n, Wide d) {
    const std::uint64_t high = static_cast<std::uint64_t>(d.high_bits());
    const int excess = (high != 0 ? 64 + bit_length(high) : bit_length(d.low_bits())) - 62;
    const int drop = excess > 0 ? excess : 0;
    const auto cut = [drop](Wide x) { return static_cast<std::int64_t>((x >> drop).low_bits()); };
    return clamped(divide_shifted(cut(n), cut(d), 60), 0, std::int64_t{1} << 60);
}
/// part (b - a); `part` has 60 fraction bits.
Long3 part_of(std::int64_t part, Long3 b, Long3 a) {
    const Long3 e = b - a;
    const auto one = [&](std::int64_t x) { return narrow_rounded(Wide::product(x, part), 60); };
    return {one(e[0]), one(e[1]), one(e[2])};
}

/// The direction of the closest simplex from its unscaled vertices, with at least 31 bits.
Long3 full_direction(const Simplex& s) {
    const Long3 p = s.v[0].a_30 - s.v[0].b_30;
    if (s.count == 1) return p;
    const Long3 e = s.v[1].a_30 - s.v[1].b_30 - p;
    if (s.count == 2) return cross(with_bits(e, 30), cross_with_bits(p, p + e, 31));
    const Long3 normal = cross_with_bits(e, s.v[2].a_30 - s.v[2].b_30 - p, 31);
    return wide_dot(normal, s.direction).is_negative() ? -normal : normal;
}

/// For simplices as small as the roundings of their vertices, which smooth cores have, the direction may be
/// inaccurate. The direction between the points, or a face's normal, replaces it when it separates the cores by
/// more. If none separates them by the distance of the points, the direction at the end of the search replaces
/// it if it separates them by more: its error is one step of the pair's scale.
void choose_normal(Difference& difference, const Simplex& s, Gap& gap) {
    const Long3 apart = gap.on_b_30 - gap.on_a_30;
    std::int64_t most = difference.separation_30(gap.normal_30);
    const auto consider = [&](Long3 normal) {
        const std::int64_t x = difference.separation_30(normal);
        if (x > most) most = x, gap.normal_30 = normal;
    };
    consider(direction_of_30(apart).unit);
    const SupportingFace face_a = supporting_face(difference.a.convex(), gap.normal_30),
                         face_b = supporting_face(difference.b.convex(), -gap.normal_30);
    if (face_a.flat) consider(face_a.normal_30);
    if (face_b.flat) consider(-face_b.normal_30);
    const std::int64_t between = direction_of_30(apart).length;
    constexpr std::int64_t micrometre_30 = 1 << 10;
    if (between - most > micrometre_30 + (between >> 16)) consider(-direction_of_30(s.direction).unit);
    gap.distance_30 = dot_unit(apart, gap.normal_30);
}

/// The difference vector leads from b to a, the normal from a to b.
Gap gap_of(Difference& difference, const Simplex& s) {
    Gap gap{};
    set_points(s, gap);
    const Direction exact = direction_of_30(full_direction(s));
    gap.normal_30 = -exact.unit;
    gap.distance_30 = s.count == 1 ? exact.length : dot_unit(gap.on_b_30 - gap.on_a_30, gap.normal_30);
    if (difference.is_smooth() || difference.shift() > 4) choose_normal(difference, s, gap);
    if (gap.distance_30 <= 0) return Gap{true, {}, 0, {}, {}};
    return gap;
}

/// The result for cores further apart than the limit: a plane between them.
Gap beyond_gap(const Simplex& s, std::int64_t limit_30, int drop) {
    const Direction d = direction_of_30(s.direction);
    const std::int64_t bound = up(divide_shifted(dot(s.direction, s.v[0].w), d.length, 0) - 1, drop);
    return {false, -d.unit, larger(bound, limit_30 + 1), s.v[0].a_30, s.v[0].b_30};
}

} // namespace

// Uses the weights of the scaled vertices: an error of one step in a weight moves both points equally.
void set_points(const Simplex& s, Gap& gap) {
    const Vertex &p = s.v[0], &q = s.v[1], &r = s.v[2];
    gap.on_a_30 = p.a_30, gap.on_b_30 = p.b_30;
    if (s.count == 2) {
        const Long3 e = q.w - p.w;
        const std::int64_t t = part_60(Wide::from(-dot(p.w, e)), Wide::from(dot(e, e)));
        gap.on_a_30 = p.a_30 + part_of(t, q.a_30, p.a_30);
        gap.on_b_30 = p.b_30 + part_of(t, q.b_30, p.b_30);
    } else if (s.count == 3) {
        const Long3 normal = cross(q.w - p.w, r.w - p.w);
        const Wide of_p = wide_dot(normal, cross(q.w, r.w)), of_q = wide_dot(normal, cross(r.w, p.w)),
                   of_r = wide_dot(normal, cross(p.w, q.w)), all = of_p + of_q + of_r;
        const std::int64_t t = part_60(of_q, all), u = part_60(of_r, all);
        gap.on_a_30 = p.a_30 + part_of(t, q.a_30, p.a_30) + part_of(u, r.a_30, p.a_30);
        gap.on_b_30 = p.b_30 + part_of(t, q.b_30, p.b_30) + part_of(u, r.b_30, p.b_30);
    }
}

bool find_simplex(Difference& difference, std::int64_t limit_30, Simplex& s, bool& beyond) {
    const std::int64_t limit = limit_30 < 0 ? -1 : (limit_30 >> difference.shift()) + 2;
    s.count = 0;
    beyond = false;
    for (int step = 0; step < gjk_steps_max; ++step) {
        const Vertex v = difference.support(-s.direction);
        const std::int64_t along = dot(s.direction, v.w);
        if (is_beyond(along, s.direction, limit)) {
            s.v[0] = v;
            beyond = true;
            return false;
        }
        if (difference.is_smooth() && s.count > 0) {
            const std::int64_t now = dot(s.direction, s.v[0].w); // |direction| >= 2^29
            if (now - along <= larger(std::int64_t{1} << 29, now >> 24)) return false;
        }
        const Step ended = advance(s, v);
        if (ended != Step::nearer) return ended == Step::holds;
    }
    return false;
}

Gap find_gap(Difference& difference, std::int64_t limit_30, Long3 start, Simplex& simplex) {
    const Convex &a = difference.a.convex(), &b = difference.b.convex();
    if (has_point_form(a, b)) {
        const PointForm f = point_form(a, b);
        if (f.distance_30 <= 0) return {true, {}, 0, {}, {}};
        return {false, f.normal_30, f.distance_30, f.on_a_30, f.on_b_30};
    }
    bool beyond = false;
    simplex.direction = with_bits(start, 30);
    if (find_simplex(difference, limit_30, simplex, beyond)) return {true, {}, 0, {}, {}};
    return beyond ? beyond_gap(simplex, limit_30, difference.shift()) : gap_of(difference, simplex);
}

Gap closest_points(const Convex& a, const Convex& b) {
    if (Gap gap; triangle_gap(a, b, gap)) return gap;
    Difference difference(a, b);
    Simplex simplex;
    return find_gap(difference, -1, difference.between(), simplex);
}

Gap closest_points_within(const Convex& a, const Convex& b, std::int64_t limit_30) {
    if (Gap gap; triangle_gap(a, b, gap)) return gap;
    Difference difference(a, b);
    Simplex simplex;
    return find_gap(difference, larger(limit_30, 0), difference.between(), simplex);
}

} // namespace lockstone::collide
