// What of a convex solid is below a plane: for buoyancy.
#pragma once

#include "lockstone/shape.h"
#include "shapes/asset/asset.h"

namespace lockstone::shapes {

/// The part below a plane.
struct Submerged {
    Unit fraction; ///< of the volume, 0..1
    Vec3 center;   ///< of the part's volume, in the solid's frame [m]; of the whole where the fraction is 0
};

/// The part at n . x < offset [m], |n| = 1, of any solid but compounds, meshes, height fields and planes.
/// Spheres by the closed form, boxes and hulls by clipping: to 1e-7 of the volume. Cylinders and cones are clipped as prisms of
/// 16 sides, capsules as polytopes of 12, of the same volume: see submerged_error. A rounded solid is taken as its core with
/// the plane moved in proportion, so that it is dry and under where it should be; exact for faces that lie level, else the
/// error is within radius / (size of the core).
Submerged submerged(const Solid& convex, UnitVec3 n, Real offset);
/// Bound of the error of `fraction` for cylinders, cones and capsules.
inline constexpr Real submerged_error = 0.004_r;

Vec3 volume_center(const Solid& convex); ///< in the solid's frame [m]
/// [m^3]: to half a step of a Real, of kilograms at 100,000 kg/m^3 below 21,474 m^3 and of cubic metres above, and to 2^-58.
Scaled volume_of(const Solid& convex);

} // namespace lockstone::shapes
