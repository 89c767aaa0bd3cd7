// Contact manifolds of two shapes, computed in integers in the frame of the first shape.
//
//   const RelativePose pose = relative_pose(world_pose_of_box, world_pose_of_sphere);
//   Manifolds m;
//   collide(box_solid, sphere_solid, pose, margin, scratch, m);    // the greater kind is shape A
//
// Every result is a pure function of the arguments, without history.
#pragma once

#include "shapes/asset/asset.h"

#include <vector>

namespace lockstone::collide {

/// The pose of shape B in the frame of shape A: a point p of B is at rotation p + position in A. A component of
/// `position` at +-relative_position_max means "too far away": such a pair never touches.
struct RelativePose {
    Rotation rotation;
    CoordinateVec3 position; ///< [m], each component rounded once
};
inline constexpr Coordinate relative_position_max = Coordinate(16384);
RelativePose relative_pose(const Transform& a, const Transform& b);
/// A world vector in A's axes, rounded once to Coordinate. Components beyond 32 km give "too far away".
CoordinateVec3 into_frame(const Rotation& axes_of_a, Vec3 d);
/// Pose of B relative to a plane. A plane has no useful origin, so B is straight above the origin of its frame:
/// position is (0, height of B's origin, 0), the height clamped to +-16000 m.
RelativePose plane_relative_pose(const Transform& plane, const Transform& b);
/// The position of plane_relative_pose only. `normal`: the plane's +y axis in the world.
CoordinateVec3 plane_relative_position(UnitVec3 normal, Vec3 on_plane, Vec3 b);

struct ManifoldPoint {
    LengthVec3 position;   ///< midway between the two surfaces, from B's origin, in A's axes [m]
    Separation separation; ///< along the normal; negative is penetration, clamped at 16 m [m]
    /// Name of the touching features: stable while the contact moves a little, unique in its manifold
    std::uint32_t feature;
};

struct Manifold {
    UnitVec3 normal; ///< from A to B, in A's axes
    std::uint32_t count;
    ManifoldPoint points[4]; ///< entries from `count` on are zero
    // For shapes of several pieces, the pieces that touch most deeply:
    std::uint32_t piece_a; ///< triangle or part of A
    std::uint32_t piece_b; ///< part of B
    /// shapes::surface_number of A's triangle: manifolds of different surfaces are not merged
    std::uint32_t surface;
    /// 1: the normal is that of a flat face, for all points up to half a degree. It then turns with that face
    /// and depends on nothing else. 0: the normal also depends on the relative position of edges, corners and
    /// round shapes.
    std::uint32_t on_face;
};
static_assert(std::has_unique_object_representations_v<Manifold>);

/// One manifold for a pair of convex shapes; one for each distinct normal for shapes with several parts or
/// triangles.
struct Manifolds {
    static constexpr std::uint32_t max = 8;
    std::uint32_t count; ///< 0: no contact
    Manifold items[max]; ///< deepest first; entries from `count` on are unspecified
    /// When `count` is 0: a direction from A to B that separates them, in A's axes; zero: unknown
    UnitVec3 apart{};
};

/// Memory that `collide` reuses between calls. It has no effect on results.
struct NarrowScratch {
    std::vector<std::uint32_t> triangles, parts;
    std::vector<Manifold> pieces;
    std::vector<std::uint32_t> order;
};

/// Computes the contact points whose separation is at most `margin` (>= 0) [m]. Needs valid solids and
/// a.geometry.kind >= b.geometry.kind (asserted), except that two convex shapes may come in either order.
/// Positions are clamped at 128 m from B's origin, so a shape of scale > 1 should be A. Two shapes of the kinds
/// height_field, mesh and plane have no contacts. Shapes that overlap always yield a point, shapes further
/// apart than `margin` never do.
void collide(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
             NarrowScratch& scratch, Manifolds& out);
/// Results of earlier calls for a pair, in A's axes. Zero: unknown.
struct PairHints {
    UnitVec3 apart;      ///< a direction that may separate the two shapes
    UnitVec3 normal;     ///< of the last manifold
    std::uint32_t edges; ///< feature of its first point, if the normal was not that of a face
};
/// As above, but faster when `apart` separates the shapes: the value of `apart` changes no result except
/// Manifolds::apart. The face or the two crossing edges that gave the last normal are kept without a search
/// while they are as good as any other to within `face_bias`. So among several good normals the choice may
/// depend on `normal` and `edges`.
void collide(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
             const PairHints& hints, NarrowScratch& scratch, Manifolds& out);

/// A solid and its world pose, for are_parted.
struct PlacedSolid {
    const shapes::Solid& solid;
    const Rotation& axes;
    Vec3 position; ///< [m]
};
/// True if the unit direction `axis`, from A to B in A's axes, separates two spheres, capsules, cylinders,
/// boxes or hulls by more than `margin` plus a millimetre. A millimetre is more than the roundings and
/// preferences of collide, so collide then finds no points. False for all other shapes, and when it is unknown.
bool are_parted(const PlacedSolid& a, const PlacedSolid& b, UnitVec3 axis, Length margin);

/// Bias for the kind of a contact. A face contact is preferred to an edge or a corner contact, A's face to B's,
/// and two points along a capsule to one, unless the other is better by more than this: stacks then keep their
/// kind of contact. Small shapes use 1/64 of their smallest half extent or radius when that is less.
inline constexpr Separation face_bias = decimal<Separation>("0.0005");

} // namespace lockstone::collide
