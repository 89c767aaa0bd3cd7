// The triangle in the working frame, and the contacts with its own normal: B's supporting face clipped to the
// triangle's sides.
//
// source: Sutherland, Hodgman, Reentrant Polygon Clipping, CACM 1974.
#include "collide/mesh/triangle_contact.h"

#include <limits>

namespace lockstone::collide {
namespace {

constexpr std::int64_t limit_max_51 = std::int64_t{1} << 61;
/// Sides that are not felt are moved outward by this much, so that roundings leave no gap between neighbours.
constexpr std::int64_t overlap_24 = 64; // 4 um

/// a . x / 2^drop for an x of any length, clamped to +-limit.
std::int64_t far_dot(Long3 a, Long3 x, int drop, std::int64_t limit) {
    return clamped(narrow_rounded(wide_dot(a, x), drop), -limit, limit);
}

} // namespace

void set_side(LocalTriangle& t, int k) {
    t.sides |= 1u << k;
    const Long3 from = t.corners_24[k], to = t.corners_24[(k + 1) % 3];
    const Long3 edge = with_bits(to - from, 27); // < 2^27.8, so the products stay below 2^59
    const Long3 own = shifted(cross(edge, t.normal_30), 30);
    const std::int64_t bend = dot(own, t.beyond_30[k]); // its sine, 56 to 58 fraction bits
    const std::uint32_t bit = 1u << k;
    // An edge that is concave in front is convex from behind. The triangle's bits describe the front only, so
    // the sine of the bend decides here; the threshold is between 1/64 and 1/16.
    if (t.is_flipped && (t.border & bit) == 0)
        t.felt = (t.felt & ~bit) | (bend > std::int64_t{1} << 52 ? bit : 0u);
    const bool halfway = bend > 0 && (t.felt & bit) == 0;
    t.sides_27[k] = halfway ? shifted(cross(edge, shifted(t.normal_30 + t.beyond_30[k], 1)), 30) : own;
    // The nearer end has the shorter lever for rounding errors.
    const Long3 at = t.widest_24[k] < t.widest_24[(k + 1) % 3] ? from : to;
    t.limits_51[k] = t.is_far ? far_dot(t.sides_27[k], at, 0, limit_max_51) : dot(t.sides_27[k], at);
}

namespace {

/// How far outside of a side a point at `height` above the plane may be, 51 fraction bits. Where several
/// slightly bent edges meet in a corner, the bisecting sides leave a cone above it that belongs to no triangle,
/// as wide as the bend. 1/64 of the height covers that cone.
std::int64_t tolerance_51(const LocalTriangle& t, int k, std::int64_t height) {
    if ((t.felt >> k & 1u) != 0) return 0;
    return ((absolute(height) >> 12) + overlap_24) << 27;
}

struct CutCorner {
    Long3 at_24;
    std::int64_t height;   // above the plane, 30 fraction bits
    int line_in, line_out; // the lines that meet here: polygon edges 0.., triangle sides side_first..
};
constexpr int side_first = SupportingFace::corners_max;
constexpr int clip_max = SupportingFace::corners_max + 3;

struct CutPolygon {
    CutCorner points[clip_max];
    int count;
    bool is_open; // a segment
};

/// Distance inside of side k. Within +-2^62: a limit is at most 2^61, B's points are within 2^8.8 m and sides
/// below 2^28.
std::int64_t inside_51(const LocalTriangle& t, int k, Long3 x_24) {
    const std::int64_t tolerance = (t.felt >> k & 1u) != 0 ? 0 : overlap_24 << 27;
    return t.limits_51[k] - dot(t.sides_27[k], x_24) + tolerance;
}

/// The intersection with a side, between a, which is inside, and b, which is outside.
CutCorner cut_between(const CutCorner& a, const CutCorner& b, std::int64_t inside_a, std::int64_t inside_b) {
    // Reduced to 33 bits: the fraction then takes one 64-bit division.
    const std::int64_t whole = (inside_a >> 1) - (inside_b >> 1);
    const int drop = bit_length(static_cast<std::uint64_t>(whole)) - 33;
    const int n = drop > 0 ? drop : 0;
    const std::int64_t part_30 = whole >> n == 0 ? 0 : ((inside_a >> 1 >> n) << 30) / (whole >> n);
    CutCorner x = a;
    for (int i = 0; i < 3; ++i) x.at_24[i] += shift_right_rounded((b.at_24[i] - a.at_24[i]) * part_30, 30);
    x.height += shift_right_rounded((b.height - a.height) * (part_30 >> 6), 24);
    return x;
}

void clip_segment(const LocalTriangle& t, int k, CutPolygon& polygon) {
    CutCorner &a = polygon.points[0], &b = polygon.points[1];
    const std::int64_t inside_a = inside_51(t, k, a.at_24), inside_b = inside_51(t, k, b.at_24);
    if (inside_a < 0 && inside_b < 0) {
        polygon.count = 0;
    } else if (inside_b < 0) {
        b = cut_between(a, b, inside_a, inside_b);
        b.line_in = 1;
        b.line_out = side_first + k;
    } else if (inside_a < 0) {
        a = cut_between(b, a, inside_b, inside_a);
        a.line_in = 0;
        a.line_out = side_first + k;
    }
}

void clip_polygon(const LocalTriangle& t, int k, CutPolygon& polygon) {
    std::int64_t inside[clip_max], least = 0, most = std::numeric_limits<std::int64_t>::min();
    const int count = polygon.count;
    for (int i = 0; i < count; ++i) {
        inside[i] = inside_51(t, k, polygon.points[i].at_24);
        least = smaller(least, inside[i]);
        most = larger(most, inside[i]);
    }
    if (least >= 0) return;
    if (most < 0) {
        polygon.count = 0;
        return;
    }
    CutCorner whole[clip_max];
    for (int i = 0; i < count; ++i) whole[i] = polygon.points[i];
    int n = 0;
    for (int i = 0; i < count && n < clip_max; ++i) {
        const int next = i + 1 == count ? 0 : i + 1;
        if (inside[i] >= 0) polygon.points[n++] = whole[i];
        if ((inside[i] >= 0) == (inside[next] >= 0) || n == clip_max) continue;
        const bool leaves = inside[i] >= 0;
        CutCorner cut = leaves ? cut_between(whole[i], whole[next], inside[i], inside[next])
                               : cut_between(whole[next], whole[i], inside[next], inside[i]);
        cut.line_in = leaves ? whole[i].line_out : side_first + k;
        cut.line_out = leaves ? side_first + k : whole[i].line_out;
        polygon.points[n++] = cut;
    }
    polygon.count = n;
}

/// A corner of B keeps its name from triangle to triangle. A point on a side or corner of the triangle is named
/// by the triangle, too.
std::uint32_t name_of_point(const SupportingFace& face, const LocalTriangle& t, const CutCorner& x) {
    const bool side_in = x.line_in >= side_first, side_out = x.line_out >= side_first;
    const auto u32 = [](int i) { return static_cast<std::uint32_t>(i); };
    if (side_in && side_out) return feature_of(3, t.index, u32(x.line_in), u32(x.line_out));
    if (!side_in && !side_out) return feature_of(1, face.ids[x.line_out], 0, 0);
    const int edge = side_in ? x.line_out : x.line_in, side = side_in ? x.line_in : x.line_out;
    return feature_of(2, t.index, u32(side), face.ids[edge]);
}

void add_face_point(const TriangleContext& c, const LocalTriangle& t, Long3 at_24, std::int64_t height,
                    std::uint32_t feature, TriangleContact& out) {
    const std::int64_t separation = height - c.radius_30;
    if (separation > up(c.margin.raw, 6)) return;
    if (out.count == 0 || out.items[out.count - 1].count == 4) {
        if (out.count == 2) return;
        out.items[out.count] = Manifold{};
        out.items[out.count].on_face = has_discs(c.shape) ? 0 : 1;
        out.items[out.count++].normal = unit_of_30(t.normal_30);
    }
    // From the core's point down by the radius and half the gap.
    const std::int64_t down_30 = c.radius_30 + (separation >> 1);
    const Long3 position = up(at_24, 6) - shifted(t.normal_30 * (down_30 >> 6), 24);
    add_point(out.items[out.count - 1], position, separation, c.margin, feature);
}

/// Adds all points within the margin. Of more than eight it adds eight: the lowest and others at even steps
/// from it.
void add_polygon(const TriangleContext& c, const LocalTriangle& t, const SupportingFace& face,
                 const CutPolygon& polygon, TriangleContact& out) {
    int near[clip_max], count = 0, lowest = 0;
    const std::int64_t limit = c.radius_30 + up(c.margin.raw, 6);
    for (int i = 0; i < polygon.count; ++i) {
        if (polygon.points[i].height > limit) continue;
        near[count++] = i;
        if (polygon.points[i].height < polygon.points[near[lowest]].height) lowest = count - 1;
    }
    const int kept = count < 8 ? count : 8;
    for (int k = 0; k < kept; ++k) {
        const CutCorner& x = polygon.points[near[(lowest + k * count / kept) % count]];
        add_face_point(c, t, x.at_24, x.height, name_of_point(face, t, x), out);
    }
}

const SupportingFace& face_against(TriangleContext& c, Long3 normal) {
    const Long3 d = normal - c.face_normal_30;
    if ((d[0] | d[1] | d[2]) != 0) {
        if (c.shape.core == Convex::Core::box || c.shape.core == Convex::Core::hull) {
            const Facing at = facing(c.shape, -normal);
            if (at.id != c.face.id) c.face = face_at(c.shape, at, -normal);
        } else {
            c.face = supporting_face(c.shape, -normal);
        }
        c.face_normal_30 = normal;
        c.has_outline = false;
    }
    return c.face;
}

/// The side opposite to the corner furthest from B's origin: the side that a ball is most likely outside of.
int side_before(const LocalTriangle& t) {
    const std::int64_t* w = t.widest_24;
    if (w[0] > w[1]) return w[0] > w[2] ? 1 : 0;
    return w[1] > w[2] ? 2 : 0;
}

/// Computes the outward normals of the supporting face's sides, perpendicular to the triangle's normal.
void set_outline(TriangleContext& c) {
    const SupportingFace& face = c.face;
    Long3 sum{};
    for (int i = 0; i < face.count; ++i) sum = sum + shifted(face.corners_30[i], 6);
    for (int i = 0; i < face.count; ++i) {
        const Long3 from = shifted(face.corners_30[i], 6),
                    to = shifted(face.corners_30[(i + 1) % face.count], 6);
        Long3 out = shifted(cross(with_bits(to - from, 27), c.face_normal_30), 30);
        std::int64_t limit = dot(out, from);
        // The middle of the face is inside, for either winding of its corners.
        if (dot(out, {sum[0] / face.count, sum[1] / face.count, sum[2] / face.count}) > limit)
            out = -out, limit = -limit;
        c.outline_27[i] = out;
        c.outline_51[i] = limit;
    }
    c.has_outline = true;
}

} // namespace

LocalTriangle local_triangle(const shapes::Face& face, CoordinateVec3 origin, bool flipped) {
    constexpr int corner_of[2][3] = {{0, 1, 2}, {0, 2, 1}};
    LocalTriangle t;
    t.index = face.index;
    t.normal_30 = flipped ? -raw(face.normal) : raw(face.normal);
    t.is_flipped = flipped;
    std::int64_t reach = 0, nearest = std::numeric_limits<std::int64_t>::max();
    int nearest_corner = 0;
    for (int k = 0; k < 3; ++k) {
        t.corners_24[k] = raw(face.corner[corner_of[flipped][k]]) - raw(origin);
        const std::int64_t w = widest(t.corners_24[k]);
        t.widest_24[k] = w;
        reach = larger(reach, w);
        if (w < nearest) nearest = w, nearest_corner = k;
    }
    t.is_far = reach > near_24;
    const Long3 at = t.corners_24[nearest_corner];
    t.offset_30 = t.is_far ? far_dot(t.normal_30, at, 24, std::int64_t{1} << 40)
                           : shift_right_rounded(dot(t.normal_30, at), 24);
    return t;
}

void set_edges(LocalTriangle& t, const shapes::FaceEdges& edges) {
    // From behind the corners are 0 2 1: edge 0 runs from corner 0 to 2 and is edge 2 from the front.
    constexpr int edge_of[2][3] = {{0, 1, 2}, {2, 1, 0}};
    t.felt = t.border = t.sides = 0;
    for (int k = 0; k < 3; ++k) {
        const int edge = edge_of[t.is_flipped][k];
        t.beyond_30[k] = t.is_flipped ? -raw(edges.beyond[edge]) : raw(edges.beyond[edge]);
        const bool is_border = is_same(t.beyond_30[k], -t.normal_30);
        t.felt |= static_cast<std::uint32_t>(is_border || (edges.sharp >> edge & 1u) != 0) << k;
        t.border |= static_cast<std::uint32_t>(is_border) << k;
    }
    if (t.is_flipped) // set_side also decides which edges are felt
        for (int k = 0; k < 3; ++k) set_side(t, k);
}

bool is_apart(const TriangleContext& c, const LocalTriangle& t) {
    const std::int64_t margin = c.margin.raw;
    if (c.shape.core == Convex::Core::point) { // the ball against the triangle's bounds, 16 fraction bits
        const std::int64_t reach_16 = ((margin + (c.radius_30 >> 6)) >> 8) + 1;
        std::int64_t square_32 = 0;
        for (int i = 0; i < 3; ++i) {
            const std::int64_t x = t.corners_24[0][i], y = t.corners_24[1][i], z = t.corners_24[2][i];
            const std::int64_t at = c.shape.center_24[i];
            const std::int64_t below = smaller(x, smaller(y, z)) - at, above = at - larger(x, larger(y, z));
            const std::int64_t off_16 = larger(0, larger(below, above)) >> 8;
            if (off_16 > reach_16) return true; // so the squares below are small
            square_32 += off_16 * off_16;
        }
        return square_32 > reach_16 * reach_16;
    }
    for (int i = 0; i < 3; ++i) {
        const Long3 axis = c.shape.axes_30[i];
        std::int64_t least = std::numeric_limits<std::int64_t>::max(), most = -least;
        for (const Long3& corner : t.corners_24) {
            const std::int64_t x = widest(corner) <= near_24
                                       ? dot(axis, corner) >> 30
                                       : far_dot(axis, corner, 30, std::int64_t{1} << 50);
            least = smaller(least, x);
            most = larger(most, x);
        }
        if (least > c.upper_24[i] + margin || most < c.lower_24[i] - margin) return true;
    }
    return false;
}

void face_contact(TriangleContext& c, LocalTriangle& t, TriangleContact& out) {
    out.count = 0;
    if (c.shape.core == Convex::Core::point) {
        const Long3 at = c.shape.center_24;
        const std::int64_t height = height_30(t, at);
        int k = side_before(t);
        for (int i = 0; i < 3; ++i, k = k == 2 ? 0 : k + 1) {
            need_side(t, k);
            if (dot(t.sides_27[k], at) > t.limits_51[k] + tolerance_51(t, k, height)) return;
        }
        return add_face_point(c, t, at, height, feature_of(1, 0, 0, 0), out);
    }
    const SupportingFace& face = face_against(c, t.normal_30);
    CutPolygon polygon;
    polygon.count = face.count;
    polygon.is_open = face.count == 2;
    for (int i = 0; i < face.count; ++i) {
        CutCorner& x = polygon.points[i];
        const Long3 at = face.corners_30[i], high{at[0] >> 6, at[1] >> 6, at[2] >> 6};
        const std::int64_t low = dot(t.normal_30, {at[0] & 63, at[1] & 63, at[2] & 63}) >> 6;
        x.at_24 = shifted(at, 6);
        x.height = shift_right_rounded(dot(t.normal_30, high) + low, 24) - t.offset_30;
        x.line_in = polygon.is_open ? i : (i + face.count - 1) % face.count;
        x.line_out = i;
    }
    if (face.count == 1) {
        for (int k = 0; k < 3; ++k) {
            need_side(t, k);
            if (dot(t.sides_27[k], polygon.points[0].at_24) >
                t.limits_51[k] + tolerance_51(t, k, polygon.points[0].height))
                return;
        }
    } else {
        for (int k = 0; k < 3 && polygon.count > 0; ++k) {
            need_side(t, k);
            if (polygon.is_open)
                clip_segment(t, k, polygon);
            else
                clip_polygon(t, k, polygon);
        }
    }
    add_polygon(c, t, face, polygon, out);
}

bool is_covered(TriangleContext& c, const LocalTriangle& t, std::int64_t deepest_30) {
    constexpr std::int64_t noise_30 = 1 << 17; // 0.12 mm
    const SupportingFace& face = face_against(c, t.normal_30);
    if (face.count < 3 || t.is_far) return false;
    if (!c.has_outline) set_outline(c);
    for (int i = 0; i < face.count; ++i)
        for (const Long3& corner : t.corners_24)
            if (dot(c.outline_27[i], corner) >= c.outline_51[i]) return false;
    // The height of the face's plane above the triangle's: the two normals are nearly opposite, so the least
    // height of the face's corners bounds the height above the triangle.
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (int i = 0; i < face.count; ++i) least = smaller(least, height_30(t, shifted(face.corners_30[i], 6)));
    return least - c.radius_30 >= deepest_30 - noise_30;
}

Long3 furthest_24(TriangleContext& c, const Long3& direction) {
    if (c.shape.core == Convex::Core::point) return c.shape.center_24;
    // Among equally far corners of a hull, the result of a Core depends on its last search; this one does not.
    if (c.shape.core == Convex::Core::hull) return shifted(support(c.shape, direction).at_30, 6);
    if (!c.core) c.core.emplace(c.shape);
    return shifted(c.core->support(direction).at_30, 6);
}

void forced_contact(const TriangleContext& c, const LocalTriangle& t, TriangleContact& out) {
    out.count = 0;
    const SupportPoint deepest = support(c.shape, -t.normal_30);
    const Long3 at = shifted(deepest.at_30, 6);
    add_face_point(c, t, at, height_30(t, at), feature_of(1, deepest.id, 0, 0), out);
}

} // namespace lockstone::collide
