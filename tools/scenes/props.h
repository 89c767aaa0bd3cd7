// Small bodies of many shapes, shared by the scenes that drop them.
#pragma once

#include "scenes/scene.h"

#include <vector>

namespace lockstone::scenes_detail {

/// Bakes five hulls: a gem, an icosahedron, a wedge, a tetrahedron and a rock of 40 random corners. Each fits a ball of
/// radius `size` [m].
std::vector<Geometry> bake_hulls(Shelf& shelf, Real size);

/// Cylinder, cone, capsule, rounded box, rounded cylinder, rounded cone; each fits a ball of radius `size` [m].
std::vector<Geometry> round_shapes(Real size);

} // namespace lockstone::scenes_detail
