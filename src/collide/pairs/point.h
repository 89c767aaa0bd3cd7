// Closest points of cylinders, cones and triangles against points (spheres) in closed form: exact, where the
// general search only converges, and fast.
#pragma once

#include "collide/core.h"

namespace lockstone::collide {

/// True when one of the two is a point and the other a cylinder or cone.
bool has_point_form(const Convex& a, const Convex& b);

struct PointForm {
    Long3 normal_30;          ///< from a to b
    std::int64_t distance_30; ///< negative: the point is inside, and this is minus the least depth
    Long3 on_a_30, on_b_30;
};
/// When the point is inside and several places are equally near, a cap or base comes before the side; a point
/// on the axis leaves along local x.
PointForm point_form(const Convex& a, const Convex& b);

/// The gap of a triangle and a point, in either order, equal to that of closest_points up to a step of 30
/// fraction bits. Returns false and sets nothing for other cores, when a corner is 32 m or more away on an
/// axis, and when the point is nearer than 1 mm to the face or 16 mm to an edge.
bool triangle_gap(const Convex& a, const Convex& b, Gap& out);

} // namespace lockstone::collide
