// Reduces the manifolds of many triangles or parts to the few that the solver takes.
#pragma once

#include "collide/narrow_phase.h"

#include <span>

namespace lockstone::collide {

/// Merges manifolds whose normals are within 3.6 degrees of the deepest one's; each point keeps its separation.
/// At most four points remain: the deepest, the one furthest from it, and those that add most area on both
/// sides. Differences below noise (0.12 mm of depth, 2 mm of position, 1/16 of other measures) do not change
/// the choice: the earlier point stays. Manifolds with other normals or other surfaces are merged separately,
/// the deepest first, at most Manifolds::max. `one_point`: each result keeps only its deepest point, because a
/// ball has no other. `order` is scratch. All points of the result have different features.
void merge_manifolds(std::span<const Manifold> pieces, bool one_point, std::vector<std::uint32_t>& order,
                     Manifolds& out);

} // namespace lockstone::collide
