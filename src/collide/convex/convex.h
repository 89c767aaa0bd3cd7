// The generic narrow phase: convex cores, exact closest points, penetration, supporting faces, and the manifold
// made from them. It handles all convex shapes except pairs with a special routine.
//
// All computations use one working frame (that of shape A, or that of a mesh with its origin moved near shape
// B) and 64-bit integers. A name's suffix gives its fraction bits. A core is the shape without its rounding
// radius.
#pragma once

#include "collide/integer.h"
#include "shapes/asset/asset.h"

namespace lockstone::collide {

/// A convex core placed in the working frame. Cheap to copy; holds pointers into its solid, which must outlive
/// it.
struct Convex {
    enum class Core : std::uint8_t { point, segment, triangle, box, cylinder, cone, hull };
    Core core;
    Coordinate radius; ///< radius of the rounding [m]; this and all lengths below include the shape's scale
    Long3 center_24;   ///< the shape's origin
    Long3 axes_30[3];  ///< the shape's axes
    Long3 half_24;     ///< segment: y; box: all; cylinder and cone: x = z radius, y half height
    const shapes::Hull* hull;            ///< for a hull
    const shapes::SupportKernel* kernel; ///< for a hull; may be null
    bool upright;                        ///< the shape's axes are those of the working frame
    Long3 corners_24[3];                 ///< for a triangle, in the working frame
};

/// For a sphere, capsule, cylinder, cone, box or hull. `position` and `rotation`: its pose in the working
/// frame.
Convex convex_of(const shapes::Solid& solid, const Rotation& rotation, CoordinateVec3 position);
/// The corners must be within 2^9 m of the origin of the working frame.
Convex convex_of_triangle(const Long3 (&corners_24)[3]);

/// The core's point furthest along a direction, and its id: the corner of a polytope; 0 for a smooth core.
struct SupportPoint {
    Long3 at_30;
    std::uint32_t id;
};
SupportPoint support(const Convex& shape, Long3 direction_30);

/// The nearest points of two cores.
struct Gap {
    bool overlap;             ///< the cores touch or intersect; the members below are then not set
    Long3 normal_30;          ///< unit, from a to b
    std::int64_t distance_30; ///< of the cores, > 0
    Long3 on_a_30, on_b_30;   ///< the nearest points
};
/// Exact for polytopes, up to the rounding of their corners into the working frame and one rounding of the
/// result. For cylinders and cones the relative error is 2^-24, or one step of the pair's scale. A pure
/// function. Always terminates.
Gap closest_points(const Convex& a, const Convex& b);
/// As closest_points, but may stop as soon as the distance is known to be more than `limit_30`. `distance_30`
/// is then a lower bound above the limit.
Gap closest_points_within(const Convex& a, const Convex& b, std::int64_t limit_30);

/// The shortest move that separates two overlapping cores.
struct Penetration {
    Long3 normal_30;       ///< unit, from a to b: moving b along it by the depth separates them
    std::int64_t depth_30; ///< >= 0
};
/// For polytopes as exact as closest_points. For cylinders and cones a local minimum, greater than the least
/// depth anywhere by at most 2^-12 of it. For round shapes around one centre, where all directions are nearly
/// equal, up to 1 % too deep. Also defined for flat cores (segments, triangles). Of several equally good
/// directions it returns the first one found, which depends on the arguments only: coincident points separate
/// along y, crossing segments along their common normal. For cores that are apart the depth is 0.
Penetration penetration(const Convex& a, const Convex& b);

/// The greatest n . v over a hull's corners v, 54 fraction bits. |n| <= 2^30, up to rounding.
std::int64_t furthest_along_54(const shapes::Hull& hull, const shapes::SupportKernel* kernel, Long3 n_30);
/// Separation of the cores along a unit direction from a to b: negative when they overlap along it.
std::int64_t separation_along_30(const Convex& a, const Convex& b, Long3 normal_30);

/// Among the faces around the corner furthest along a direction, the face whose normal is nearest to that
/// direction, as a polygon. For the side of a cylinder or cone it is the generator, for a segment both ends,
/// for a point the point itself.
struct SupportingFace {
    static constexpr int corners_max = 32;
    int count; ///< 1, 2, or 3..corners_max, counter-clockwise about `normal_30`
    Long3 corners_30[corners_max];
    std::uint32_t ids[corners_max]; ///< name of each corner, or of the generator of a smooth core
    Long3 normal_30;                ///< of the face when count >= 3, else the direction
    std::uint32_t id;               ///< name of the face or edge; 0 for a point
    bool flat;                      ///< a true face of the shape: its normal may become the contact's normal
};
/// The corner of a hull that is furthest along a direction, when it is known from an earlier search.
constexpr std::uint32_t unknown_corner = ~std::uint32_t{0};
SupportingFace supporting_face(const Convex& shape, Long3 direction_30,
                               std::uint32_t corner = unknown_corner);
/// Identifies that face without computing its corners. face_at computes them from this and the direction of the
/// search.
struct Facing {
    Long3 normal_30;
    std::uint32_t id;
    bool flat;
    std::uint32_t corner = unknown_corner; ///< for a hull: the furthest corner
};
Facing facing(const Convex& shape, const Long3& direction_30, std::uint32_t corner = unknown_corner);
SupportingFace face_at(const Convex& shape, const Facing& at, const Long3& direction_30);

/// Fills the manifold from the two supporting faces along `normal_30`. The better face is the reference; the
/// other is clipped against its sides. Gives up to four points within `margin`. `separation_30` is the
/// separation of the shapes along the normal, radii included. Gives at least one point when separation_30 <=
/// margin.
void manifold_from_faces(const Convex& a, const Convex& b, Long3 normal_30, std::int64_t separation_30,
                         Length margin, Manifold& out);

/// The manifold of two convex shapes: closest points or penetration, faces preferred by `face_bias`, then
/// clipping. Positions have the axes of the working frame and b.center_24 as origin (see Manifold). For shapes
/// that are apart, the manifold has no points, and its normal separates them. If `hints.apart` separates the
/// shapes by more than the margin and `hint_guard_30`, no search runs: the search would find them apart, too.
void collide_convex(const Convex& a, const Convex& b, Length margin, Manifold& out,
                    const PairHints& hints = {});
/// [m], 30 fraction bits: a hundred times the error of closest_points.
inline constexpr std::int64_t hint_guard_30 = std::int64_t{1} << 17;

/// True when the shapes (radii included) are nearer than `margin`, or overlap.
bool within_distance(const Convex& a, const Convex& b, Length margin);

} // namespace lockstone::collide
