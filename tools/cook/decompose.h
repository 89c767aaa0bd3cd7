// A solid cut into convex parts.
//
// The solid is cut by planes across the three axes. A piece is the solid within a box of those planes, and the hull of
// a piece is that of its clipped triangles and of the box's corners that are inside the solid: where a cut runs
// through the inside, nothing else can be a corner. The piece whose hull reaches farthest beyond the solid is cut
// again, along the plane that leaves the least volume to hulls; pieces that fit together convexly are joined at the end.
//
// Cuts and the greedy order are those of approximate convex decomposition. Source: Lien, Amato, "Approximate convex
// decomposition of polyhedra", 2007; the candidates and the measure are simpler here. Debian's HACD clusters surface
// triangles and bounds no distance, hence this.
#pragma once

#include "cook/convex.h"
#include "cook/surface.h"

#include <vector>

namespace lockstone::cook {

struct DecomposeOptions {
    double deviation; ///< how far a part may reach beyond the solid, at most [m]
    std::uint32_t parts_max;
    double width_min = 0.01; ///< no piece is cut thinner than this [m]
};

/// Parts that cover the solid. More deviation than asked for is left only where parts_max or width_min end the cuts.
/// Error when there is no volume.
Result<std::vector<Convex>> decompose(const Soup& solid, const Surface& surface,
                                      const DecomposeOptions& options);

/// How far the hull reaches beyond the solid: the greatest distance to its surface of sample points on and in the hull
/// that are outside of the solid [m].
double excess(const Convex& hull, const Surface& solid, std::size_t samples);

/// Points of the hull on the normals of the solid's surface: where the hull ends, halfway to there, and so on. What lies farthest beyond the solid is
/// near such points. Those that are no more than `distance` from the surface are left out.
std::vector<Point> points_between(const Convex& hull, const Surface& solid, double distance);

} // namespace lockstone::cook
