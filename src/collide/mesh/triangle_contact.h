// One triangle against one convex shape: what triangles.cpp asks for each candidate.
//
// The working frame has A's axes and B's origin, so all that matters is near the origin however large A is.
#pragma once

#include "collide/core.h"
#include "shapes/mesh/face.h"

#include <optional>
#include <span>

namespace lockstone::collide {

/// Coordinates up to it need no 128-bit products.
inline constexpr std::int64_t near_24 = std::int64_t{256} << 24;

/// A triangle seen from shape B. A side k is the plane through edge k (from corner k to k + 1) that bounds what the
/// triangle's own normal serves: at right angles to the triangle where the edge is felt or concave, halfway to the
/// neighbour where it is flat, so that neighbours on a flat mesh share out the space above them without a gap.
struct LocalTriangle {
    Long3 corners_24[3];       ///< may be far away: up to 2^21 m
    std::int64_t widest_24[3]; ///< of each corner
    Long3 normal_30;
    std::int64_t offset_30; ///< normal . x on the plane; clamped to +-1024 m
    std::uint32_t index;
    bool is_far; ///< a corner is too far away for 64-bit products
    bool is_flipped;

    // Set by set_edges:
    Long3 beyond_30[3];
    std::uint32_t felt;   ///< bit k: contacts of edge k may have normals of their own
    std::uint32_t border; ///< bit k: nothing is across edge k
    std::uint32_t sides;  ///< bit k: side k is set

    // Set by need_side:
    Long3 sides_27[3];         ///< outward, of length 2^25 .. 2^28
    std::int64_t limits_51[3]; ///< side . x on the side; clamped to +-2^61
};
/// Corners and plane: what height_30 and is_apart need. `flipped`: the same triangle seen from behind.
LocalTriangle local_triangle(const shapes::Face& face, CoordinateVec3 origin, bool flipped);
/// What everything else needs.
void set_edges(LocalTriangle& t, const shapes::FaceEdges& edges);
/// Many a triangle is done with before all its sides are looked at.
void set_side(LocalTriangle& t, int k);
inline void need_side(LocalTriangle& t, int k) {
    if ((t.sides >> k & 1u) == 0) set_side(t, k);
}

/// How B lies to an edge.
struct EdgeGap {
    bool overlap;
    std::int64_t separation_30; ///< radius included
    Long3 normal_30;            ///< from the edge to B
    Long3 on_edge_30;           ///< nearest point; not set when they overlap
    bool at_from, at_to;        ///< it is an end of the edge
};
/// Gaps of the last edges that were asked for: each edge belongs to two triangles.
struct KnownEdges {
    static constexpr int max = 24;
    struct Entry {
        Long3 from_24, to_24;
        EdgeGap gap;
        bool written; ///< a contact with it was yielded
    };
    Entry entries[max];
    int count = 0, oldest = 0;
    bool all_fit = false; ///< there are no more edges than places
};

/// Shape B and what is derived from it once a pair.
struct TriangleContext {
    TriangleContext(const shapes::Solid& b, const shapes::Extent& extent, const RelativePose& pose,
                    Length limit);
    TriangleContext(const TriangleContext&) = delete; // `core` points to `shape`
    TriangleContext& operator=(const TriangleContext&) = delete;

    Convex shape;
    std::optional<Core> core; ///< of `shape`, made by furthest_24
    Long3 center_24;          ///< the core's centre, which tells front from behind
    Long3 lower_24, upper_24; ///< in B's own axes, radius included
    Length margin;
    std::int64_t radius_30;
    std::int64_t face_bias_30;   ///< the triangle's normal is preferred by this much
    std::int64_t border_bias_30; ///< B stands on a border while it reaches no deeper than this
    Long3 face_normal_30{};      ///< `face` is the supporting face against it; zero: none yet, and its id 0
    SupportingFace face;
    Long3 outline_27[SupportingFace::corners_max]; ///< outward, of the face's sides; set when `has_outline`
    std::int64_t outline_51[SupportingFace::corners_max]; ///< outline . x on the side
    bool has_outline = false;
    KnownEdges edges;
};

/// The point of B's core furthest along a direction of at most 2^31.
Long3 furthest_24(TriangleContext& c, const Long3& direction);

/// height of a point above the triangle's plane, 30 fraction bits.
inline std::int64_t height_30(const LocalTriangle& t, Long3 x_24) {
    return shift_right_rounded(dot(t.normal_30, x_24), 24) - t.offset_30;
}

/// What one triangle yields; two manifolds of the same normal when there are more than four points.
struct TriangleContact {
    Manifold items[2];
    int count;
};

/// Whether B's box, grown by the margin, is parted from the triangle by one of its own three axes; for a ball, whether
/// it is away from the triangle's bounds.
bool is_apart(const TriangleContext& c, const LocalTriangle& t);

/// Contacts with the triangle's own normal at the points of B that are within the triangle's sides.
void face_contact(TriangleContext& c, LocalTriangle& t, TriangleContact& out);
/// Whether a triangle without felt edges lies within the outline of B's supporting face, and nothing of that face
/// is deeper than what was found already, up to noise: then its contacts are between those of its neighbours and
/// of no use.
bool is_covered(TriangleContext& c, const LocalTriangle& t, std::int64_t deepest_30);
/// One contact with the triangle's own normal at B's deepest point, wherever that is.
void forced_contact(const TriangleContext& c, const LocalTriangle& t, TriangleContact& out);

/// What the edges that are felt have to say: whether one of them, or its end, touches B along a normal that it may
/// have.
struct EdgeContact {
    enum class Verdict : std::uint8_t {
        none,    ///< nothing
        contact, ///< edge `edge` touches B
        upright, ///< on a border, hardly past it: the triangle's normal serves
        beyond,  ///< B overlaps the edge from the neighbour's side
    };
    Verdict verdict;
    int edge;
    std::int64_t separation_30; ///< of B and the edge, but for `none`
    EdgeGap gap;
};
/// `lowest_30`: separation of B and the triangle's plane. `has_face`: the triangle's own normal serves some point;
/// then a border on which B stands has no say.
EdgeContact edge_contact(TriangleContext& c, LocalTriangle& t, std::int64_t lowest_30, bool has_face);
/// The manifold of a `contact`; without points when it was written for the other triangle of the edge a short
/// while ago.
Manifold edge_manifold(TriangleContext& c, const LocalTriangle& t, const EdgeContact& contact);

/// The part of a segment within 256 m of the origin on each axis; false when there is none.
bool near_part(Long3& from_24, Long3& to_24);

/// Distance of the triangle from a point near the origin, 20 fraction bits, at most 2^30; and the height of the point
/// above its plane in the same bits.
struct PointDistance {
    std::int64_t distance_20, height_20;
};
PointDistance distance_from(LocalTriangle& t, Long3 point_24);

/// Names for features: the same numbers give the same name, different ones nearly always another.
constexpr std::uint32_t feature_of(std::uint32_t kind, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t h = kind * 0x9e3779b1u ^ a * 0x85ebca77u ^ b * 0xc2b2ae3du ^ c * 0x27d4eb2fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    return h ^ (h >> 13);
}

} // namespace lockstone::collide
