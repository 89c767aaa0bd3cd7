// One triangle against one convex shape: the functions that triangles.cpp calls for each candidate triangle.
//
// The working frame has A's axes and B's origin, so all relevant coordinates are small however large A is.
#pragma once

#include "collide/core.h"
#include "shapes/mesh/face.h"

#include <optional>
#include <span>

namespace lockstone::collide {

/// Coordinates up to this limit need no 128-bit products.
inline constexpr std::int64_t near_24 = std::int64_t{256} << 24;

/// A triangle in the frame of shape B. Side k is the plane through edge k (from corner k to k + 1) that bounds
/// the region in which contacts have the triangle's own normal. It is perpendicular to the triangle where the
/// edge is felt (contacts may have normals of their own) or concave. At a slightly bent edge that is not felt
/// it bisects the angle to the neighbour: the neighbours on a flat mesh then divide the space above them
/// without a gap.
struct LocalTriangle {
    Long3 corners_24[3];       ///< may be far away: up to 2^21 m
    std::int64_t widest_24[3]; ///< largest absolute coordinate of each corner
    Long3 normal_30;
    std::int64_t offset_30; ///< normal . x on the plane; clamped to +-1024 m
    std::uint32_t index;
    bool is_far; ///< a corner is too far away for 64-bit products
    bool is_flipped;

    // Set by set_edges:
    Long3 beyond_30[3];   ///< normal of the neighbour at edge k; at a border the triangle's own, reversed
    std::uint32_t felt;   ///< bit k: contacts at edge k may have normals of their own
    std::uint32_t border; ///< bit k: edge k has no neighbour
    std::uint32_t sides;  ///< bit k: set_side has computed side k

    // Set by need_side on first use:
    Long3 sides_27[3];         ///< outward, of length 2^25 .. 2^28
    std::int64_t limits_51[3]; ///< side . x for points x on the side; clamped to +-2^61
};
/// Computes the corners and the plane, which suffice for height_30 and is_apart. `flipped`: the triangle seen
/// from behind.
LocalTriangle local_triangle(const shapes::Face& face, CoordinateVec3 origin, bool flipped);
/// Computes the members that all other functions need, except the sides.
void set_edges(LocalTriangle& t, const shapes::FaceEdges& edges);
/// Computes side k. need_side calls it on first use only, because many triangles are dropped before all sides
/// are needed.
void set_side(LocalTriangle& t, int k);
inline void need_side(LocalTriangle& t, int k) {
    if ((t.sides >> k & 1u) == 0) set_side(t, k);
}

/// The position of B relative to an edge.
struct EdgeGap {
    bool overlap;
    std::int64_t separation_30; ///< radius included
    Long3 normal_30;            ///< from the edge to B
    Long3 on_edge_30;           ///< nearest point; not set when they overlap
    bool at_from, at_to;        ///< that point is an end of the edge
};
/// Cache of the gaps of the last edges tested: each edge belongs to two triangles.
struct KnownEdges {
    static constexpr int max = 24;
    struct Entry {
        Long3 from_24, to_24;
        EdgeGap gap;
        bool written; ///< a contact at this edge was already appended
    };
    Entry entries[max];
    int count = 0, oldest = 0;
    bool all_fit = false; ///< the pair has at most `max` edges, so no entry is ever replaced
};

/// Shape B and the values derived from it once per pair.
struct TriangleContext {
    TriangleContext(const shapes::Solid& b, const shapes::Extent& extent, const RelativePose& pose,
                    Length limit);
    TriangleContext(const TriangleContext&) = delete; // `core` points to `shape`
    TriangleContext& operator=(const TriangleContext&) = delete;

    Convex shape;
    std::optional<Core> core; ///< of `shape`; furthest_24 creates it on first use
    Long3 center_24; ///< the core's centre, which decides whether B is in front of a triangle or behind it
    Long3 lower_24, upper_24; ///< in B's own axes, radius included
    Length margin;
    std::int64_t radius_30;
    std::int64_t face_bias_30;   ///< the triangle's normal is preferred by this much
    std::int64_t border_bias_30; ///< B rests on a border while it reaches no deeper than this
    /// The direction whose opposite `face` is the supporting face for. Zero: no face computed yet, and face.id
    /// is 0.
    Long3 face_normal_30{};
    SupportingFace face;
    /// Outward normals of the face's sides; valid when `has_outline`.
    Long3 outline_27[SupportingFace::corners_max];
    std::int64_t outline_51[SupportingFace::corners_max]; ///< outline . x for points x on the side
    bool has_outline = false;
    KnownEdges edges;
};

/// The point of B's core that is furthest along a direction with components of at most 2^31.
Long3 furthest_24(TriangleContext& c, const Long3& direction);

/// Height of a point above the triangle's plane, 30 fraction bits.
inline std::int64_t height_30(const LocalTriangle& t, Long3 x_24) {
    return shift_right_rounded(dot(t.normal_30, x_24), 24) - t.offset_30;
}

/// The manifolds of one triangle. More than four points need two manifolds with one normal.
struct TriangleContact {
    Manifold items[2];
    int count;
};

/// True when one of B's own three axes separates the triangle from B's box grown by the margin; for a ball,
/// when the ball and the margin do not reach the triangle's bounds.
bool is_apart(const TriangleContext& c, const LocalTriangle& t);

/// Computes contacts with the triangle's own normal, at the points of B that are within the triangle's sides.
void face_contact(TriangleContext& c, LocalTriangle& t, TriangleContact& out);
/// True when a triangle without felt edges lies within the outline of B's supporting face, and no point of that
/// face is deeper than the deepest contact so far, up to noise. The triangle's contacts then lie between those
/// of its neighbours and may be skipped.
bool is_covered(TriangleContext& c, const LocalTriangle& t, std::int64_t deepest_30);
/// Computes one contact with the triangle's own normal at B's deepest point, even outside of the triangle.
void forced_contact(const TriangleContext& c, const LocalTriangle& t, TriangleContact& out);

/// The result for the felt edges of a triangle: whether B touches one of them, or an end of it, along a normal
/// within the edge's range.
struct EdgeContact {
    enum class Verdict : std::uint8_t {
        none,    ///< no edge touches B
        contact, ///< edge `edge` touches B
        upright, ///< B overlaps a border by little: the contact has the triangle's normal
        beyond,  ///< B overlaps the edge from the neighbour's side
    };
    Verdict verdict;
    int edge;
    std::int64_t separation_30; ///< separation of B and the edge; not set for `none`
    EdgeGap gap;
};
/// `lowest_30`: separation of B and the triangle's plane. `has_face`: some point already has a contact with the
/// triangle's own normal; borders on which B rests are then skipped.
EdgeContact edge_contact(TriangleContext& c, LocalTriangle& t, std::int64_t lowest_30, bool has_face);
/// The manifold of a result `contact`. It has no points when the other triangle of the edge already appended it
/// and the edge is still in the cache.
Manifold edge_manifold(TriangleContext& c, const LocalTriangle& t, const EdgeContact& contact);

/// Clips a segment to within 256 m of the origin on each axis. Returns false when no part remains.
bool near_part(Long3& from_24, Long3& to_24);

/// Distance of the triangle from a point near the origin, and height of the point above the triangle's plane.
/// Both have 20 fraction bits and are at most 2^30.
struct PointDistance {
    std::int64_t distance_20, height_20;
};
PointDistance distance_from(LocalTriangle& t, Long3 point_24);

/// Feature names: equal numbers give equal names, different numbers nearly always different names.
constexpr std::uint32_t feature_of(std::uint32_t kind, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t h = kind * 0x9e3779b1u ^ a * 0x85ebca77u ^ b * 0xc2b2ae3du ^ c * 0x27d4eb2fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    return h ^ (h >> 13);
}

} // namespace lockstone::collide
