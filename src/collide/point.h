// Cylinders and cones against points, that is against spheres: exact where the general search only comes nearer.
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

} // namespace lockstone::collide
