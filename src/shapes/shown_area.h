// The area that a convex solid shows to a direction: for drag and blasts.
#pragma once

#include "shapes/asset/asset.h"

namespace lockstone::shapes {

struct ShownArea {
    Real area;   ///< of the shadow on a plane across the direction [m^2]
    Vec3 center; ///< of that shadow, somewhere along the direction, in the solid's frame [m]
};

/// |direction| = 1, in the solid's frame; any solid but compounds, meshes, height fields and planes. Spheres, capsules,
/// boxes, cylinders and hulls exactly, but for rounding: rounded boxes, cylinders and cones count as grown by their radius to
/// all sides, which is at most (4 - pi) radius^2 too much a corner; rounded hulls as scaled up to their reach. A cone is a
/// pyramid of 16 sides with the same base area.
/// source: Cauchy, the shadow of a convex body is half the sum of its faces' shadows.
ShownArea shown_area(const Solid& convex, UnitVec3 direction);

} // namespace lockstone::shapes
