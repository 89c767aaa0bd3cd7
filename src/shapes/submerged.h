// Computes the part of a convex solid below a plane, for buoyancy.
#pragma once

#include "lockstone/shape.h"
#include "shapes/asset/asset.h"

namespace lockstone::shapes {

/// The part below a plane.
struct Submerged {
    Unit fraction; ///< of the volume, 0..1
    /// Centre of that part, in the solid's frame [m]; of the whole solid where the fraction is 0.
    Vec3 center;
};

/// The part at n . x < offset [m], |n| = 1, in the solid's frame. For any solid except compounds, meshes,
/// height fields and planes. Spheres use a closed form. Boxes and hulls are clipped, to 1e-7 of the volume.
/// Cylinders and cones are clipped as prisms and pyramids of 16 sides, capsules as polytopes of 12 sides,
/// with equal volume: see submerged_error. For a rounded solid the core is clipped and the plane is moved in
/// proportion, so that the solid is dry and fully submerged at the correct heights. This is exact for level
/// faces; else the error is at most radius / (size of the core).
Submerged submerged(const Solid& convex, UnitVec3 n, Real offset);
/// Bound of the error of `fraction` for cylinders, cones and capsules.
inline constexpr Real submerged_error = 0.004_r;

Vec3 volume_center(const Solid& convex); ///< in the solid's frame [m]
/// The volume [m^3]. Error: 2^-58 of it, plus half a step of a Real: for primitives below 21,474 m^3 of the
/// mass in kg at 100,000 kg/m^3, for larger ones of the volume in m^3.
Scaled volume_of(const Solid& convex);

} // namespace lockstone::shapes
