// Cylinders, cones and triangles against points, that is against spheres: exact where the general search only comes nearer, and
// quick.
#pragma once

#include "collide/core.h"

namespace lockstone::collide {

/// One of the two is a point, the other a cylinder or cone.
bool has_point_form(const Convex& a, const Convex& b);

struct PointForm {
    Long3 normal_30;          ///< from a to b
    std::int64_t distance_30; ///< negative: the point is inside, and this is the least move out
    Long3 on_a_30, on_b_30;
};
/// Deep inside of several nearest places: the cap or base before the side; from the axis out along local x.
PointForm point_form(const Convex& a, const Convex& b);

/// The gap of a triangle and a point, in either order, as closest_points finds it, to a step of 30 fraction bits. False, and nothing
/// is set, for other cores, where a corner is 32 m away on an axis or more, and nearer than 1 mm to the
/// face or 16 mm to an edge.
bool triangle_gap(const Convex& a, const Convex& b, Gap& out);

} // namespace lockstone::collide
