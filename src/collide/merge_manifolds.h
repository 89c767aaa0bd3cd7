// From the manifolds of many triangles or parts to the few that the solver gets.
#pragma once

#include "collide/narrow_phase.h"

#include <span>

namespace lockstone::collide {

/// Manifolds whose normals are within 3.6 degrees of a deepest one join it, each keeping the separations of its
/// points; of the points at most four are kept: the deepest, the one furthest from it, and those that span most
/// area to both sides. Differences below noise (0.12 mm of depth, 2 mm of place, 1/16 of the rest) do not change
/// the choice: the earlier point stays. Further normals make manifolds of their own, the deepest first, at most
/// Manifolds::max. `one_point`: of each manifold only the deepest point is kept, since a ball has no other.
/// `order` is scratch. No two points of the result have the same feature.
void merge_manifolds(std::span<const Manifold> pieces, bool one_point, std::vector<std::uint32_t>& order,
                     Manifolds& out);

} // namespace lockstone::collide
