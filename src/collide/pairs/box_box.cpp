// Two boxes: the axis of greatest separation, then the face of one clipped against the face of the other, or the
// closest points of two edges.
//
// source: Gottschalk, Lin, Manocha, OBBTree, SIGGRAPH 1996 (the fifteen axes); Gregorius, The Separating Axis Test
// between Convex Polyhedra, GDC 2013 (reference and incident face); Sutherland, Hodgman, Reentrant Polygon Clipping,
// CACM 1974.
#include "collide/pairs/box_box.h"
#include "collide/convex/convex.h"

namespace lockstone::collide {
namespace {

/// sin^2 = 2^-16 in 60 fraction bits. For two edges closer to parallel than 0.004 rad, rounding of the rotation
/// gives their axis an error of more than 2.4e-7 of the boxes' reach; the faces decide there.
constexpr std::int64_t sin2_min_60 = std::int64_t{1} << 44;

/// The axis of greatest separation, after the bias for faces. `separation` has 30 fraction bits and excludes
/// the bias.
struct Axis {
    enum Kind { face_a, face_b, edges } kind;
    int i, j; // A's face or edge axis, B's
    std::int64_t separation;
    bool parts; // by more than the margin: there is no contact
};

struct FaceAxis {
    std::int64_t separation; // 54 fraction bits
    int axis;
};

FaceAxis best_face_of_a(const BoxPair& g) {
    FaceAxis best{std::numeric_limits<std::int64_t>::min(), 0};
    for_axes([&](auto i) {
        const std::int64_t s = up(absolute(g.t[i]) - g.a[i], 30) - g.abs[0][i] * g.b[0] -
                               g.abs[1][i] * g.b[1] - g.abs[2][i] * g.b[2];
        if (s > best.separation) best = {s, i};
    });
    return best;
}

FaceAxis best_face_of_b(const BoxPair& g) {
    FaceAxis best{std::numeric_limits<std::int64_t>::min(), 0};
    for_axes([&](auto j) {
        const std::int64_t s = absolute(dot(g.t, g.r[j])) - up(g.b[j], 30) - dot(g.abs[j], g.a);
        if (s > best.separation) best = {s, j};
    });
    return best;
}

/// The separation along e_i x r_j = (0, -r[i2], r[i1]) times that axis's length, 54 fraction bits.
template <int i, int j> std::int64_t edge_separation(const BoxPair& g) {
    constexpr int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return absolute(g.t[i2] * g.r[j][i1] - g.t[i1] * g.r[j][i2]) - g.abs[j][i2] * g.a[i1] -
           g.abs[j][i1] * g.a[i2] - g.abs[j2][i] * g.b[j1] - g.abs[j1][i] * g.b[j2];
}

/// Replaces `best` by the edge axis that exceeds it by more than the bias. `best.separation` excludes the bias.
void try_edges(const BoxPair& g, std::int64_t bias_30, std::int64_t margin_30, Axis& best) {
    std::int64_t to_beat = best.separation + bias_30;
    for_axes([&](auto i) {
        for_axes([&](auto j) {
            // sin <= (1 + sin^2) / 2, so for s_54 < 0 most axes are rejected before the root and the division.
            const std::int64_t s_54 = edge_separation<i, j>(g);
            const std::int64_t r1 = g.r[j][(i + 1) % 3], r2 = g.r[j][(i + 2) % 3],
                               sin2_60 = r1 * r1 + r2 * r2;
            const std::int64_t sin_above_20 = ((std::int64_t{1} << 20) + (sin2_60 >> 40) + 2) >> 1;
            if (s_54 <= 0 && (s_54 >> 24) <= (to_beat * sin_above_20) >> 20) return;
            if (sin2_60 < sin2_min_60) return;
            const int spare =
                std::countl_zero(static_cast<std::uint64_t>(sin2_60)) / 2; // for all 32 bits of the root
            const std::int64_t sin = isqrt(static_cast<std::uint64_t>(sin2_60) << (2 * spare));
            const std::int64_t s = divide_shifted(s_54, sin, 6 + spare);
            if (s <= to_beat) return;
            to_beat = s;
            // to_beat only grows, so a separated pair stays separated.
            best = {Axis::edges, i, j, s, s > margin_30};
        });
    });
}

Axis find_axis(const BoxPair& g, std::int64_t bias_30, std::int64_t margin_30) {
    const FaceAxis of_a = best_face_of_a(g);
    if ((of_a.separation >> 24) > margin_30) return {Axis::face_a, of_a.axis, 0, 0, true};
    const FaceAxis of_b = best_face_of_b(g);
    if ((of_b.separation >> 24) > margin_30) return {Axis::face_b, 0, of_b.axis, 0, true};
    Axis best{Axis::face_a, of_a.axis, 0, shift_right_rounded(of_a.separation, 24), false};
    if (of_b.separation > of_a.separation + up(bias_30, 24))
        best = {Axis::face_b, 0, of_b.axis, shift_right_rounded(of_b.separation, 24), false};
    try_edges(g, bias_30, margin_30, best);
    return best;
}

/// e_i x r_j, directed from A to B, not normalized.
Long3 across_edges(const BoxPair& g, int i, int j) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    const Long3& r = g.r[j];
    const std::int64_t sign = sign_of(g.t[i2] * r[i1] - g.t[i1] * r[i2]);
    Long3 across{};
    across[i1] = -sign * r[i2];
    across[i2] = sign * r[i1];
    return across;
}

/// The unit direction of an axis, from A to B.
Long3 direction_of(const BoxPair& g, const Axis& axis) {
    if (axis.kind == Axis::edges) return direction_of_30(across_edges(g, axis.i, axis.j)).unit;
    if (axis.kind == Axis::face_b) return g.r[axis.j] * sign_of(dot(g.t, g.r[axis.j]));
    Long3 normal{};
    normal[axis.i] = sign_of(g.t[axis.i]) << 30;
    return normal;
}

/// Adds the contact of two edges: the edge of each box that faces the other along the axis, and the closest
/// points of their lines.
void collide_edges(const BoxPair& g, const Axis& axis, Length margin, Manifold& out) {
    const int i = axis.i, i1 = (i + 1) % 3, i2 = (i + 2) % 3, j = axis.j, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    const Long3& r = g.r[j];
    const std::int64_t sign = sign_of(g.t[i2] * r[i1] - g.t[i1] * r[i2]);
    const Long3 normal = direction_of_30(across_edges(g, i, j)).unit;
    // (e_i x r_j) . r_j1 = r_j2[i] and (e_i x r_j) . r_j2 = -r_j1[i]
    const bool a1 = normal[i1] >= 0, a2 = normal[i2] >= 0, b1 = sign * g.r[j2][i] < 0,
               b2 = sign * g.r[j1][i] >= 0;
    Long3 on_a{};
    on_a[i1] = a1 ? g.a[i1] : -g.a[i1];
    on_a[i2] = a2 ? g.a[i2] : -g.a[i2];
    const Long3 on_b =
        shifted(up(g.t, 30) + g.r[j1] * (b1 ? g.b[j1] : -g.b[j1]) + g.r[j2] * (b2 ? g.b[j2] : -g.b[j2]), 30);

    const Long3 between = on_b - on_a;
    const std::int64_t sin2_60 = r[i1] * r[i1] + r[i2] * r[i2],
                       along_b = shift_right_rounded(dot(between, r), 30);
    const std::int64_t line_s = divide_shifted(up(between[i], 30) - r[i] * along_b, sin2_60, 30);
    const std::int64_t line_u = divide_shifted(r[i] * between[i] - up(along_b, 30), sin2_60, 30);
    const std::int64_t s = clamped(line_s, -g.a[i], g.a[i]), u = clamped(line_u, -g.b[j], g.b[j]);
    // Two separated boxes whose edges miss each other beyond their ends are further apart than along the axis.
    if (axis.separation > 0 && (s != line_s || u != line_u)) return;
    Long3 middle = up(on_a, 30) + up(on_b, 30) + r * u;
    middle[i] += up(s, 30);

    const auto bit = [](bool positive, int at) { return positive ? 1u << at : 0u; };
    out.normal = unit_of_30(normal);
    add_point(out, shifted(middle, 25), axis.separation, margin,
              edge_feature(edge_id(i, bit(a1, i1) | bit(a2, i2)), edge_id(j, bit(b1, j1) | bit(b2, j2))));
}

/// Handles boxes beside each other's faces and edges: near a corner, or at two edges too close to parallel for
/// an axis.
void collide_beside(const Geometry& a, const Geometry& b, const RelativePose& pose, Length margin,
                    Manifold& out) {
    collide_convex(convex_of({a}, Rotation::identity(), CoordinateVec3{}),
                   convex_of({b}, pose.rotation, pose.position), margin, out);
    for (std::uint32_t k = 0; k < out.count; ++k)
        out.points[k].position = to<Length>(to<Coordinate>(out.points[k].position) + pose.position);
}

} // namespace

void collide_box_box(const Geometry& geometry_a, const Geometry& geometry_b, const RelativePose& pose,
                     Length margin, Manifold& out) {
    BoxPair g{raw(geometry_a.half_extent),
              raw(geometry_b.half_extent),
              raw(pose.position),
              {raw(pose.rotation.x), raw(pose.rotation.y), raw(pose.rotation.z)},
              {}};
    for_axes([&](auto j) { g.abs[j] = {absolute(g.r[j][0]), absolute(g.r[j][1]), absolute(g.r[j][2])}; });
    std::int64_t thinnest = up(face_bias.raw, 3); // 30 fraction bits; half_24 / 64 is the same number in 30
    for (int i = 0; i < 3; ++i) thinnest = smaller(thinnest, smaller(g.a[i], g.b[i]));
    const Axis axis = find_axis(g, thinnest, up(margin.raw, 6));
    if (axis.parts) {
        out.normal = unit_of_30(direction_of(g, axis));
        return;
    }
    switch (axis.kind) {
    case Axis::face_a:
        clip_faces(g, false, axis.i, margin, out);
        break;
    case Axis::face_b:
        clip_faces(g, true, axis.j, margin, out);
        break;
    case Axis::edges:
        collide_edges(g, axis, margin, out);
        break;
    }
    if (out.count == 0) collide_beside(geometry_a, geometry_b, pose, margin, out);
}

} // namespace lockstone::collide
