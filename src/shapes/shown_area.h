// The projected area of a convex solid along a direction, for drag and blasts.
#pragma once

#include "shapes/asset/asset.h"

namespace lockstone::shapes {

struct ShownArea {
    Real area; ///< of the projection on a plane perpendicular to the direction [m^2]
    /// Centroid of the projection, at some position along the direction, in the solid's frame [m].
    Vec3 center;
};

/// |direction| = 1, in the solid's frame. For any solid except compounds, meshes, height fields and planes.
/// Spheres, capsules, boxes, cylinders and hulls are exact without rounding. Rounded boxes, cylinders and
/// cones count as grown by their radius on all sides, which is at most (4 - pi) radius^2 too much for each
/// corner. Rounded hulls count as scaled up to their reach. A cone is a pyramid of 16 sides with equal base
/// area.
/// source: Cauchy, the shadow of a convex body is half the sum of its faces' shadows.
ShownArea shown_area(const Solid& convex, UnitVec3 direction);

} // namespace lockstone::shapes
