// Decomposes a solid into convex parts.
//
// Planes across the three axes cut the solid. A piece is the part of the solid within a box of such planes. Its hull
// contains the clipped triangles and those corners of the box that are inside the solid; no other point can be a corner
// where a cut passes through the inside. The piece whose hull extends farthest beyond the solid is cut again, along the
// plane that leaves the least volume to hulls. At the end neighbouring pieces are joined if their common hull is close
// enough to the solid.
//
// The cuts and their greedy order are those of approximate convex decomposition. Source: Lien, Amato, "Approximate
// convex decomposition of polyhedra", 2007; the candidates and the measure are simpler here. Debian's HACD is no
// alternative: it clusters surface triangles and gives no bound for the distance.
#pragma once

#include "cook/convex.h"
#include "cook/surface.h"

#include <vector>

namespace lockstone::cook {

struct DecomposeOptions {
    double deviation; ///< largest distance that a part may extend beyond the solid [m]
    std::uint32_t parts_max;
    double width_min = 0.01; ///< no piece becomes thinner than this [m]
};

/// Convex parts that cover the solid. The deviation may exceed the limit only if parts_max or width_min end the cuts.
/// An error if the solid has no volume.
Result<std::vector<Convex>> decompose(const Soup& solid, const Surface& surface,
                                      const DecomposeOptions& options);

/// How far the hull extends beyond the solid [m]: the greatest distance to the solid of sample points that are in or on
/// the hull and outside of the solid.
double excess(const Convex& hull, const Surface& solid, std::size_t samples);

/// Sample points in the hull along the normals of the solid's surface: at the end of the hull, halfway to it, and so
/// on. The points that lie farthest beyond the solid are near such samples. Leaves out points within `distance` of the
/// surface.
std::vector<Point> points_between(const Convex& hull, const Surface& solid, double distance);

} // namespace lockstone::cook
