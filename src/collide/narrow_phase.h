// Contact manifolds of two shapes, computed in the frame of the first on integers.
//
//   const RelativePose pose = relative_pose(world_pose_of_box, world_pose_of_sphere);
//   Manifolds m;
//   collide(box_solid, sphere_solid, pose, margin, scratch, m);    // the greater kind is shape A
//
// Every result is a pure function of the arguments: no history, no hysteresis.
#pragma once

#include "shapes/asset/asset.h"

#include <vector>

namespace lockstone::collide {

/// Shape B's frame seen from shape A's: a point p of B is rotation p + position in A.
/// A component of `position` at +-relative_position_max means "too far away": such a pair never touches.
struct RelativePose {
    Rotation rotation;
    CoordinateVec3 position; ///< [m], each component rounded once
};
inline constexpr Coordinate relative_position_max = Coordinate(16384);
RelativePose relative_pose(const Transform& a, const Transform& b);
/// A world vector in A's axes, rounded once to Coordinate; beyond 32 km "too far away".
CoordinateVec3 into_frame(const Rotation& axes_of_a, Vec3 d);
/// A plane has no useful origin: seen from it, B is straight above the origin of its frame.
/// position is (0, height of B's origin, 0), the height clamped to +-16000 m.
RelativePose plane_relative_pose(const Transform& plane, const Transform& b);
/// Its position alone. `normal`: the plane's +y in the world.
CoordinateVec3 plane_relative_position(UnitVec3 normal, Vec3 on_plane, Vec3 b);

struct ManifoldPoint {
    LengthVec3 position;   ///< midway between the two surfaces, from B's origin, in A's axes [m]
    Separation separation; ///< along the normal; negative is penetration, clamped at 16 m [m]
    /// What touches what: the same while the contact moves a little, unique in its manifold
    std::uint32_t feature;
};

struct Manifold {
    UnitVec3 normal; ///< from A to B, in A's axes
    std::uint32_t count;
    ManifoldPoint points[4]; ///< beyond `count`: zero
    // Of shapes of many pieces: which of them touch most deeply.
    std::uint32_t piece_a; ///< triangle or part of A
    std::uint32_t piece_b; ///< part of B
    /// Of A's triangle, shapes::surface_number: manifolds of different ones stay apart
    std::uint32_t surface;
    /// 1: the normal is a flat face's, of all points to half a degree. It then turns with that face and hangs on nothing
    /// else; of edges, corners and round shapes it also depends on where they are to each other.
    std::uint32_t on_face;
};
static_assert(std::has_unique_object_representations_v<Manifold>);

/// One manifold for a pair of convex shapes; one for each distinct normal where a shape has many parts or triangles.
struct Manifolds {
    static constexpr std::uint32_t max = 8;
    std::uint32_t count; ///< 0: apart
    Manifold items[max]; ///< deepest first; beyond `count`: unspecified
    /// When `count` is 0: a direction from A to B that parts them, in A's axes; zero: not known
    UnitVec3 apart{};
};

/// Memory that `collide` uses again from call to call; no trace of earlier calls shows.
struct NarrowScratch {
    std::vector<std::uint32_t> triangles, parts;
    std::vector<Manifold> pieces;
    std::vector<std::uint32_t> order;
};

/// Points whose separation is at most `margin` (>= 0). Needs valid solids and a.geometry.kind >= b.geometry.kind, but
/// two convex shapes may come in any order: positions end at 128 m from B's origin, so a shape of scale > 1 wants to be
/// A. Of two of height_field, mesh and plane there is no contact. Shapes that overlap always yield a point, shapes
/// further apart than `margin` never do.
void collide(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
             NarrowScratch& scratch, Manifolds& out);
/// What is known of a pair from before, in A's axes. Zero: nothing.
struct PairHints {
    UnitVec3 apart;      ///< a direction that may part the two
    UnitVec3 normal;     ///< of the last manifold
    std::uint32_t edges; ///< name of its first point, where the normal was no face's
};
/// The same, sooner when `apart` parts the two: whatever it is, the result is the same but for Manifolds::apart. The face or the two
/// crossing edges that the last normal was that of are kept without a search while they are as good as any other to within
/// `face_bias`, so which of several good ones serves may depend on it.
void collide(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
             const PairHints& hints, NarrowScratch& scratch, Manifolds& out);

/// Where two shapes are in the world: what are_parted needs of them.
struct PlacedSolid {
    const shapes::Solid& solid;
    const Rotation& axes;
    Vec3 position; ///< [m]
};
/// True if the unit direction `axis`, from A to B in A's axes, parts two spheres, capsules, cylinders, boxes or hulls by more than `margin`
/// and a millimetre, which is more than collide rounds and prefers: then it finds no points. False of all other shapes,
/// and where it is not known.
bool are_parted(const PlacedSolid& a, const PlacedSolid& b, UnitVec3 axis, Length margin);

/// A face contact is preferred to an edge or a corner contact, A's face to B's, and two points along a capsule to one,
/// unless the other is better by this much: stacks then keep their kind of contact. Small shapes use 1/64 of their
/// smallest half extent or radius when that is less.
inline constexpr Separation face_bias = decimal<Separation>("0.0005");

} // namespace lockstone::collide
