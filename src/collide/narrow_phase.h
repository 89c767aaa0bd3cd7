// Contact manifolds of two shapes, computed in the frame of the first on 32-bit integers with 64-bit products.
//
//   const RelativePose pose = relative_pose(world_pose_of_box, world_pose_of_sphere);
//   Manifold m;
//   collide(box_geometry, sphere_geometry, pose, margin, m);       // the greater kind is shape A
//
// Every result is a pure function of the arguments: no history, no hysteresis.
#pragma once

#include "lockstone/shape.h"

namespace lockstone::collide {

/// Shape B's frame seen from shape A's: a point p of B is rotation p + position in A.
/// A component of `position` at the end of its range (128 m) means "too far away": such a pair never touches. So a
/// pair is exact while B's origin is within 128 m of A's along each of A's axes; of two boxes, let the larger be A.
struct RelativePose {
    Rotation rotation;
    LengthVec3 position; ///< [m], each component rounded once
};
RelativePose relative_pose(const Transform& a, const Transform& b);

/// A plane has no useful origin: B is seen from the foot of its own origin on the plane, however far that is from the
/// plane's position. A manifold point p of this pose is at `origin + plane.rotation p` in the world.
/// The height of B's origin is clamped to +-120 m.
struct PlaneView {
    RelativePose pose; ///< in the plane's axes; position is (0, height, 0)
    Vec3 origin;       ///< the foot, in the world [m]
};
PlaneView plane_view(const Transform& plane, const Transform& b);

struct ManifoldPoint {
    LengthVec3 position;   ///< midway between the two surfaces, in A's axes from A's origin [m]
    Separation separation; ///< along the normal; negative is penetration, clamped at 16 m [m]
    std::uint32_t
        feature; ///< what touches what: the same while the contact moves a little, unique in its manifold
};

struct Manifold {
    UnitVec3 normal; ///< from A to B, in A's axes
    std::uint32_t count;
    ManifoldPoint points[4]; ///< beyond `count`: zero
};
static_assert(std::has_unique_object_representations_v<Manifold>);

/// Up to 4 points whose separation is at most `margin` (>= 0). Needs a.kind >= b.kind, b not a plane, and valid
/// geometry. Shapes that overlap always yield a point, shapes further apart than `margin` never do, and in between all
/// do but boxes that are beside each other's faces.
void collide(const Geometry& a, const Geometry& b, const RelativePose& pose, Length margin, Manifold& out);

/// A face contact is preferred to an edge or a corner contact, A's face to B's, and two points along a capsule to one,
/// unless the other is better by this much: stacks then keep their kind of contact. Small shapes use 1/64 of their
/// smallest half extent or radius when that is less.
inline constexpr Separation face_bias = decimal<Separation>("0.0005");

} // namespace lockstone::collide
