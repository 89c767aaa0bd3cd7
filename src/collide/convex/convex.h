// The generic narrow phase: convex cores, exact closest points, penetration, supporting faces, and the manifold that
// comes of them. Whatever is convex goes through here unless a pair has a routine of its own.
//
// All of it happens in one working frame (that of shape A, or that of a mesh with its origin moved near shape B), on
// 64-bit integers; a name's suffix tells the fraction bits. A core is the shape without its rounding radius.
#pragma once

#include "collide/integer.h"
#include "shapes/asset/asset.h"

namespace lockstone::collide {

/// A convex core placed in the working frame. Cheap to copy; points into the solid it was made of.
struct Convex {
    enum class Core : std::uint8_t { point, segment, triangle, box, cylinder, cone, hull };
    Core core;
    Coordinate radius; ///< rounding [m]; at the shape's scale, like all below
    Long3 center_24;   ///< the shape's origin
    Long3 axes_30[3];  ///< the shape's axes
    Long3 half_24; ///< at the shape's scale; segment: y; box; cylinder and cone: x = z radius, y half height
    const shapes::Hull* hull;            ///< of a hull
    const shapes::SupportKernel* kernel; ///< of a hull; may be null
    bool upright;                        ///< its axes are those of the working frame
    Long3 corners_24[3];                 ///< of a triangle, in the working frame
};

/// A sphere, capsule, cylinder, cone, box or hull. `position` and `rotation`: its frame seen from the working frame.
Convex convex_of(const shapes::Solid& solid, const Rotation& rotation, CoordinateVec3 position);
/// The corners must lie within 2^9 m of the origin of the working frame.
Convex convex_of_triangle(const Long3 (&corners_24)[3]);

/// The core's point furthest along a direction, and what it is called: a corner of a polytope; for a smooth core 0.
struct SupportPoint {
    Long3 at_30;
    std::uint32_t id;
};
SupportPoint support(const Convex& shape, Long3 direction_30);

/// Where two cores are nearest to each other.
struct Gap {
    bool overlap;             ///< the cores touch or intersect: nothing below is set
    Long3 normal_30;          ///< unit, from a to b
    std::int64_t distance_30; ///< of the cores, > 0
    Long3 on_a_30, on_b_30;   ///< the nearest points
};
/// Exact for polytopes up to the rounding of their corners into the working frame and one rounding of the result;
/// for cylinders and cones to a relative 2^-24 or a step of the pair's scale. Pure: no history. Never fails to end.
Gap closest_points(const Convex& a, const Convex& b);
/// As closest_points, but may stop as soon as it is known that the distance is more than `limit_30`; then
/// `distance_30` is a lower bound above the limit.
Gap closest_points_within(const Convex& a, const Convex& b, std::int64_t limit_30);

/// The least move that parts two overlapping cores.
struct Penetration {
    Long3 normal_30;       ///< unit, from a to b: moving b along it by depth parts them
    std::int64_t depth_30; ///< >= 0
};
/// Of polytopes exact as closest_points; of cylinders and cones the least nearby, and less by at most 2^-12 of it
/// elsewhere. Round shapes about one centre, for which all directions are nearly as good: up to 1 % too deep. Defined
/// for flat cores (segments, triangles) too; of several directions that are as good, the first that is found, which
/// depends on the arguments alone: coincident points part along y, crossing segments across both. Cores that are apart:
/// depth 0.
Penetration penetration(const Convex& a, const Convex& b);

/// Separation of the cores along a unit direction from a to b: negative when they overlap along it.
/// The greatest n . v of a hull's corners, 54 fraction bits. |n| <= 2^30, to a rounding.
std::int64_t furthest_along_54(const shapes::Hull& hull, const shapes::SupportKernel* kernel, Long3 n_30);
std::int64_t separation_along_30(const Convex& a, const Convex& b, Long3 normal_30);

/// Of the faces about the corner that lies furthest along a direction the one that looks most along it: a polygon; of a
/// cylinder's or cone's side the generator, of a segment both ends, of a point itself.
struct SupportingFace {
    static constexpr int corners_max = 32;
    int count; ///< 1, 2, or 3..corners_max, counter-clockwise about `normal_30`
    Long3 corners_30[corners_max];
    std::uint32_t ids[corners_max]; ///< name the corner, or the generator of a smooth core
    Long3 normal_30;                ///< of the face when count >= 3, else the direction
    std::uint32_t id;               ///< names the face or edge; 0 for a point
    bool flat;                      ///< a true face of the shape: its normal may become the contact's
};
/// The corner of a hull that is furthest along a direction, where it has been found before.
constexpr std::uint32_t unknown_corner = ~std::uint32_t{0};
SupportingFace supporting_face(const Convex& shape, Long3 direction_30,
                               std::uint32_t corner = unknown_corner);
/// Which face that is, without its corners; and the face, from this and the direction that it was found along.
struct Facing {
    Long3 normal_30;
    std::uint32_t id;
    bool flat;
    std::uint32_t corner = unknown_corner; ///< of a hull, the furthest
};
Facing facing(const Convex& shape, const Long3& direction_30, std::uint32_t corner = unknown_corner);
SupportingFace face_at(const Convex& shape, const Facing& at, const Long3& direction_30);

/// Fills the manifold from the two supporting faces along `normal_30`: the better one is the reference, the other is
/// clipped against its sides; up to four points within `margin`. Radii are taken into account; `separation_30` is
/// the shapes' separation along the normal, radii included. Always at least one point when separation_30 <= margin.
void manifold_from_faces(const Convex& a, const Convex& b, Long3 normal_30, std::int64_t separation_30,
                         Length margin, Manifold& out);

/// The manifold of two convex shapes: closest points or penetration, faces preferred by `face_bias`, then clipping.
/// Positions are relative to the origin of the working frame moved to b.center_24 (see Manifold). Shapes that are apart
/// leave the normal that parts them. Where `hints.apart` parts them, no other is looked for: what is apart along it by more than
/// the margin and `hint_guard` is so along the one that would be found.
void collide_convex(const Convex& a, const Convex& b, Length margin, Manifold& out,
                    const PairHints& hints = {});
/// [m], 30 fraction bits: a hundred times the error of closest_points.
inline constexpr std::int64_t hint_guard_30 = std::int64_t{1} << 17;

/// True when the shapes (radii included) are nearer than `margin`, or overlap.
bool within_distance(const Convex& a, const Convex& b, Length margin);

} // namespace lockstone::collide
