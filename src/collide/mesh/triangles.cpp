#include "collide/mesh/triangles.h"

#include "collide/merge_manifolds.h"
#include "collide/mesh/triangle_contact.h"
#include "collide/pairs/pairs.h"
#include "shapes/mesh/mesh.h"
#include "shapes/mesh/surfaces.h"

#include <algorithm>

namespace lockstone::collide {
namespace {

Coordinate coordinate(std::int64_t raw_24) { return Coordinate::from_raw(raw_24); }

/// B rests on a border while it is up to this deep below it: 1 cm, or a quarter of B's inner ball when that is
/// less.
std::int64_t border_bias_30(Length inner) { return smaller(up(inner.raw, 4), std::int64_t{10737418}); }

shapes::Extent extent_in(const shapes::Extent& local, const RelativePose& pose, Length margin) {
    const Long3 lower = raw(local.lower), upper = raw(local.upper);
    const Long3 columns[3] = {raw(pose.rotation.x), raw(pose.rotation.y), raw(pose.rotation.z)};
    shapes::Extent out;
    const std::int64_t margin_24 = std::int64_t{margin.raw} + 2;
    // The sum of three products with units stays below 2^63.
    constexpr std::int64_t small = std::int64_t{1} << 31;
    if (larger(widest(lower), widest(upper)) < small) {
        for (int i = 0; i < 3; ++i) {
            std::int64_t least = 0, most = 0;
            for (int j = 0; j < 3; ++j) {
                const std::int64_t x = columns[j][i] * lower[j], y = columns[j][i] * upper[j];
                least += smaller(x, y);
                most += larger(x, y);
            }
            const std::int64_t at = raw(pose.position)[i];
            out.lower[i] = coordinate(at + (least >> 30) - margin_24);
            out.upper[i] = coordinate(at + (most >> 30) + margin_24);
        }
        return out;
    }
    for (int i = 0; i < 3; ++i) {
        Wide least = Wide::from(0), most = least; // 54 fraction bits; a scaled primitive reaches 1.4 km: 2^65
        for (int j = 0; j < 3; ++j) {
            const Wide x = Wide::product(columns[j][i], lower[j]), y = Wide::product(columns[j][i], upper[j]);
            least = least + (y < x ? y : x);
            most = most + (x < y ? y : x);
        }
        const std::int64_t at = raw(pose.position)[i];
        out.lower[i] = coordinate(at + saturate_to_int64(least >> 30) - margin_24);
        out.upper[i] = coordinate(at + saturate_to_int64(most >> 30) + margin_24);
    }
    return out;
}

/// Collides one pair: a mesh or height field A and a convex shape B.
class TriangleCollision {
  public:
    TriangleCollision(const shapes::Solid& solid, const shapes::Solid& other, const shapes::Extent& extent,
                      const RelativePose& relative, Length margin, NarrowScratch& memory)
        : a(solid), local(extent), pose(relative), context(other, extent, relative, margin), scratch(memory),
          first_piece(memory.pieces.size()), two_sided(shapes::is_two_sided(solid)),
          is_small(solid.mesh != nullptr && context.shape.core == Convex::Core::point) {
        for (int i = 0; i < 3; ++i) furthest_24[i] = larger(-context.lower_24[i], context.upper_24[i]);
        has_planes = solid.mesh != nullptr && !two_sided && solid.geometry.scale == scale_one &&
                     widest(furthest_24) < std::int64_t{1} << 31;
    }

    void run() {
        scratch.parts.clear();
        find_triangles(is_small ? ball_extent() : whole_extent());
        context.edges.all_fit = 3 * scratch.triangles.size() <= KnownEdges::max;
        std::vector<std::uint32_t>& behind = scratch.order;
        behind.clear();
        for (const std::uint32_t index : scratch.triangles) {
            if (is_above(index)) continue;
            const shapes::Face face = shapes::face_at(a, index);
            LocalTriangle t = view(face);
            const bool is_behind = height_30(t, context.center_24) < 0;
            const std::int64_t lowest = lowest_30(t);
            below_plane = below_plane || lowest <= 0;
            if (lowest > up(context.margin.raw, 6)) continue;
            if (is_behind && a.height_field != nullptr) {
                behind.push_back(index);
                continue;
            }
            if (is_apart(context, t) || (is_behind && highest_30(t) < 0)) continue;
            if (is_behind) behind.push_back(index);
            set_edges(t, shapes::edges_at(a, face));
            if (!is_behind)
                from_front(t, lowest);
            else if (t.border != 0)
                from_behind(t, lowest);
        }
        drop_hidden();
        if (!behind.empty()) push_out(behind);
        if (below_plane && scratch.pieces.size() == first_piece) any_overlap();
    }

  private:
    void find_triangles(const shapes::Extent& where) {
        scratch.triangles.clear();
        shapes::find_triangles(a, where, scratch.triangles);
    }
    shapes::Extent whole_extent() const {
        shapes::Extent where = extent_in(local, pose, context.margin);
        // Height fields are solid below the surface: the surface above a shape counts at any height.
        if (a.height_field != nullptr) where.upper.y = coordinate(std::int64_t{1} << 44);
        return where;
    }
    /// A ball's own box, smaller than the box of its turned bounds. It meets all triangles that are not
    /// `is_apart`; the guard exceeds the rounding.
    shapes::Extent ball_extent() const {
        constexpr std::int64_t guard_24 = 1 << 10;
        const std::int64_t reach_24 = context.shape.radius.raw + context.margin.raw + guard_24;
        shapes::Extent where;
        for (int i = 0; i < 3; ++i) {
            where.lower[i] = coordinate(pose.position[i].raw - reach_24);
            where.upper[i] = coordinate(pose.position[i].raw + reach_24);
        }
        return where;
    }
    /// True when B is certainly above the triangle's plane by more than the margin. Needs only one corner of
    /// the triangle, and drops many triangles early. The guard of a tenth of a millimetre is far more than all
    /// roundings.
    bool is_above(std::uint32_t index) const {
        constexpr std::int64_t guard_24 = 1 << 11;
        if (!has_planes) return false;
        const shapes::FacePlane plane = a.mesh->plane(index);
        const Long3 off = raw(pose.position) - raw(plane.on), n = raw(plane.normal);
        if (!is_within(off, 32)) return false;
        std::int64_t reach_54 = context.radius_30 << 24;
        if (context.shape.core != Convex::Core::point) {
            reach_54 = 0;
            for (int i = 0; i < 3; ++i)
                reach_54 += (absolute(dot(n, context.shape.axes_30[i])) >> 30) * furthest_24[i];
        }
        return (dot(n, off) >> 24) - (reach_54 >> 24) > up(context.margin.raw + guard_24, 6);
    }
    LocalTriangle view(const shapes::Face& face) const {
        LocalTriangle t = local_triangle(face, pose.position, false);
        if (two_sided && height_30(t, context.center_24) < 0) t = local_triangle(face, pose.position, true);
        return t;
    }
    LocalTriangle view(std::uint32_t index) const { return view(shapes::face_at(a, index)); }
    LocalTriangle view_with_edges(std::uint32_t index) const {
        const shapes::Face face = shapes::face_at(a, index);
        LocalTriangle t = view(face);
        set_edges(t, shapes::edges_at(a, face));
        return t;
    }
    std::int64_t lowest_30(const LocalTriangle& t) const {
        const Convex& s = context.shape;
        if (s.core == Convex::Core::point) return height_30(t, s.center_24) - context.radius_30;
        if (s.core == Convex::Core::box || s.core == Convex::Core::segment) { // half extents are below 2^31
            std::int64_t reach_54 = 0;
            for (int i = 0; i < 3; ++i)
                reach_54 += shift_right_rounded(absolute(dot(t.normal_30, s.axes_30[i])), 30) * s.half_24[i];
            return height_30(t, s.center_24) - shift_right_rounded(reach_54, 24) - context.radius_30;
        }
        return height_30(t, shifted(support(context.shape, -t.normal_30).at_30, 6)) - context.radius_30;
    }
    std::int64_t highest_30(const LocalTriangle& t) const {
        return height_30(t, shifted(support(context.shape, t.normal_30).at_30, 6)) + context.radius_30;
    }
    /// Appends a manifold to scratch.pieces and its triangle to scratch.parts.
    void append(const LocalTriangle& t, const Manifold& m) {
        if (m.count == 0) return;
        scratch.pieces.push_back(m);
        name_piece(scratch.pieces.back(), t.index);
        scratch.parts.push_back(t.index);
        found_30 = smaller(found_30, deepest_30(m));
    }
    void append(const LocalTriangle& t, const TriangleContact& contact) {
        for (int i = 0; i < contact.count; ++i) append(t, contact.items[i]);
    }

    void name_piece(Manifold& m, std::uint32_t index) const {
        m.piece_a = index, m.piece_b = 0, m.surface = shapes::surface_number(a, index);
    }

    void from_front(LocalTriangle& t, std::int64_t lowest) {
        if (t.felt == 0 && is_covered(context, t, found_30)) return;
        TriangleContact face;
        face_contact(context, t, face);
        if (t.felt == 0 || face_is_best(t, face, lowest)) return append(t, face);
        const EdgeContact edge = edge_contact(context, t, lowest, face.count > 0);
        const std::int64_t enough = edge.separation_30 + context.face_bias_30;
        const bool face_serves = lowest >= edge.separation_30 - context.face_bias_30 && reaches(face, enough);
        switch (edge.verdict) {
        case EdgeContact::Verdict::none:
            return append(t, face);
        case EdgeContact::Verdict::upright:
            if (face.count == 0) forced_contact(context, t, face);
            return append(t, face);
        case EdgeContact::Verdict::contact:
            return face_serves ? append(t, face) : append(t, edge_manifold(context, t, edge));
        case EdgeContact::Verdict::beyond:
            if (face_serves) append(t, face);
            return;
        }
    }

    /// True when B's deepest point is within the sides, and one of two holds: no core overlaps the plane, so
    /// that the plane's normal is the direction between the nearest points; or B is no deeper than the bias by
    /// which faces are preferred.
    bool face_is_best(const LocalTriangle& t, const TriangleContact& face, std::int64_t lowest) const {
        if (face.count == 0) return false;
        if ((t.felt & ~t.border) == 0 && lowest >= -context.border_bias_30) return true;
        if (lowest < -context.face_bias_30 && lowest + context.radius_30 <= 0) return false;
        return reaches(face, lowest + context.face_bias_30);
    }
    static bool reaches(const TriangleContact& contact, std::int64_t depth_30) {
        for (int i = 0; i < contact.count; ++i)
            if (deepest_30(contact.items[i]) <= depth_30) return true;
        return false;
    }

    /// The core's centre is behind the triangle: from there B can touch only the border without being inside.
    void from_behind(LocalTriangle& t, std::int64_t lowest) {
        t.felt = t.border;
        const EdgeContact edge = edge_contact(context, t, lowest, false);
        if (edge.verdict == EdgeContact::Verdict::contact) append(t, edge_manifold(context, t, edge));
    }

    /// Pushes out a shape whose core's centre is inside. The triangle nearest to the centre decides whether it
    /// is. Of two equally near, at an edge or corner, the one with the larger height of the centre above or
    /// below its plane decides.
    /// source: Baerentzen, Aanaes, Signed distance computation using the angle weighted pseudonormal, 2005.
    void push_out(std::span<const std::uint32_t> behind) {
        constexpr std::int64_t same_20 = 16;          // 16 um
        if (is_small) find_triangles(whole_extent()); // a triangle further away may be the nearest
        PointDistance best{std::int64_t{1} << 40, 0};
        LocalTriangle nearest{};
        for (const std::uint32_t index : scratch.triangles) {
            const shapes::Face face = shapes::face_at(a, index);
            if (is_further(face, best.distance_20 + same_20)) continue;
            LocalTriangle t = view(face);
            set_edges(t, shapes::edges_at(a, face));
            const PointDistance d = distance_from(t, context.center_24);
            if (d.distance_20 > best.distance_20 + same_20) continue;
            if (d.distance_20 < best.distance_20 - same_20 ||
                absolute(d.height_20) > absolute(best.height_20))
                best = d, nearest = t;
        }
        if (best.height_20 >= 0 || border_is_nearest(nearest, best)) return;
        const std::size_t before = scratch.pieces.size();
        TriangleContact contact;
        for (const std::uint32_t index : behind) {
            LocalTriangle t = view_with_edges(index);
            if (dot(t.normal_30, nearest.normal_30) < std::int64_t{1} << 59) continue; // 60 degrees
            face_contact(context, t, contact);
            append(t, contact);
        }
        if (scratch.pieces.size() > before) return;
        forced_contact(context, nearest, contact);
        append(nearest, contact);
    }
    /// True when the bounds of a triangle are further from the core's centre than a limit [m, 20 fraction bits].
    bool is_further(const shapes::Face& face, std::int64_t limit_20) const {
        if (limit_20 > std::int64_t{1} << 31) return false; // so that the squares below fit
        std::uint64_t square_40 = 0;
        for (int i = 0; i < 3; ++i) {
            const std::int64_t x = face.corner[0][i].raw, y = face.corner[1][i].raw,
                               z = face.corner[2][i].raw;
            const std::int64_t at = pose.position[i].raw + context.center_24[i];
            const std::int64_t below = smaller(x, smaller(y, z)) - at, above = at - larger(x, larger(y, z));
            const std::int64_t off_20 = larger(0, larger(below, above)) >> 4;
            if (off_20 > limit_20) return true;
            square_40 += static_cast<std::uint64_t>(off_20 * off_20);
        }
        return square_40 > static_cast<std::uint64_t>(limit_20 * limit_20);
    }
    /// True when the nearest point is on the border of an open mesh: the mesh has no inside there.
    bool border_is_nearest(const LocalTriangle& t, const PointDistance& d) const {
        return t.border != 0 && d.distance_20 > absolute(d.height_20) + 16;
    }

    /// Called when no triangle yielded a contact. If a triangle overlaps B nevertheless, adds one contact along
    /// the direction of least penetration.
    void any_overlap() {
        Manifold best{};
        for (const std::uint32_t index : scratch.triangles) {
            const LocalTriangle t = view(index);
            if (t.is_far || lowest_30(t) > 0 || is_apart(context, t)) continue;
            const Convex triangle = convex_of_triangle(t.corners_24);
            const Gap gap = closest_points_within(triangle, context.shape, context.radius_30);
            Long3 normal = gap.normal_30, on_b = gap.on_b_30;
            std::int64_t separation = gap.distance_30 - context.radius_30;
            if (!gap.overlap && separation > 0) continue;
            if (gap.overlap) {
                const Penetration p = penetration(triangle, context.shape);
                normal = p.normal_30;
                separation = -p.depth_30 - context.radius_30;
                on_b = support(context.shape, -normal).at_30;
            }
            Manifold m{};
            m.normal = unit_of_30(normal);
            const std::int64_t down_30 = context.radius_30 + (separation >> 1);
            add_point(m, on_b - shifted(normal * (down_30 >> 6), 24), separation, context.margin,
                      feature_of(6, index, 0, 0));
            if (m.count == 0) continue;
            name_piece(m, index);
            if (best.count == 0 || deepest_30(m) < deepest_30(best)) best = m;
        }
        if (best.count > 0) scratch.pieces.push_back(best);
    }

    /// A triangle that meets a sharp edge only with one corner has no data of that edge. It would report the
    /// part of B that hangs past the edge as deep inside. Where the normal of another contact separates B from
    /// the triangle with far less depth than the triangle's own normal, that contact suffices and the
    /// triangle's is dropped.
    void drop_hidden() {
        const std::span<Manifold> pieces = std::span(scratch.pieces).subspan(first_piece);
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            if (pieces[i].count == 0) continue;
            const std::int64_t deepest = deepest_30(pieces[i]);
            if (deepest > -context.border_bias_30) continue;
            const LocalTriangle t = view(scratch.parts[i]);
            if (t.is_far || unit_of_30(t.normal_30) != pieces[i].normal) continue;
            for (std::size_t j = 0; j < pieces.size(); ++j) {
                if (j == i || pieces[j].count == 0 || deepest_30(pieces[j]) <= deepest / 2) continue;
                if (separation_along(t, raw(pieces[j].normal)) <= deepest / 2) continue;
                pieces[i].count = 0;
                break;
            }
        }
    }
    static std::int64_t deepest_30(const Manifold& m) {
        std::int32_t least = m.points[0].separation.raw;
        for (std::uint32_t k = 1; k < m.count; ++k) least = std::min(least, m.points[k].separation.raw);
        return up(least, 3);
    }
    std::int64_t separation_along(const LocalTriangle& t, Long3 normal_30) const {
        std::int64_t most = std::numeric_limits<std::int64_t>::min();
        for (const Long3& corner : t.corners_24) most = larger(most, dot(normal_30, corner));
        const Long3 nearest = shifted(support(context.shape, -normal_30).at_30, 6);
        return ((dot(normal_30, nearest) >> 1) - (most >> 1)) / (1 << 23) - context.radius_30;
    }

    const shapes::Solid& a;
    const shapes::Extent& local; ///< of B, in B's own axes
    const RelativePose& pose;
    TriangleContext context;
    NarrowScratch& scratch;
    std::size_t first_piece;
    bool two_sided;
    bool is_small;            ///< the first search covers only ball_extent
    bool has_planes;          ///< is_above may be used
    Long3 furthest_24;        ///< reach of B along its own axes
    bool below_plane = false; ///< B reaches the plane of a triangle that meets its bounds
    std::int64_t found_30 = std::numeric_limits<std::int64_t>::max() / 2; ///< the deepest separation so far
};

} // namespace

shapes::Extent extent_in(const shapes::Solid& b, const RelativePose& pose, Length margin) {
    return extent_in(shapes::extent_of(b), pose, margin);
}

TriangleContext::TriangleContext(const shapes::Solid& b, const shapes::Extent& extent,
                                 const RelativePose& pose, Length limit)
    : shape(convex_of(b, pose.rotation, CoordinateVec3{})),
      center_24(raw(mul<Coordinate>(pose.rotation, shapes::core_center(b)))), lower_24(raw(extent.lower)),
      upper_24(raw(extent.upper)), margin(limit), radius_30(up(shape.radius.raw, 6)) {
    face.id = 0;
    const Length inner = shapes::inner_radius(b);
    face_bias_30 = smaller(up(face_bias.raw, 3), inner.raw);
    border_bias_30 = collide::border_bias_30(inner);
}

void append_triangle_pieces(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                            Length margin, NarrowScratch& scratch) {
    const shapes::Extent local = shapes::extent_of(b);
    TriangleCollision(a, b, local, pose, margin, scratch).run();
}

void collide_triangles(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                       Length margin, NarrowScratch& scratch, Manifolds& out) {
    scratch.pieces.clear();
    append_triangle_pieces(a, b, pose, margin, scratch);
    merge_manifolds(scratch.pieces, b.geometry.kind == ShapeKind::sphere, scratch.order, out);
}

} // namespace lockstone::collide
