// How far what was cooked is from what it was cooked from: asked of the bytes that were loaded again.
//
// Distances come from the nearest triangle. The greatest of each is asked of another library: libccd where the body is
// convex, FCL where it is a surface. When the two disagree that is an error, never a number. `samples` is the number of
// points that are asked between vertices.
#pragma once

#include "cook/convex.h"
#include "cook/surface.h"

#include <vector>

namespace lockstone::cook {

/// Both ways, since either can be small alone [m].
struct Deviation {
    double source_to_result = 0; ///< the farthest that a point of the source is from the result
    double result_to_source = 0; ///< the farthest that a point of the result is from the source
    double largest() const { return std::max(source_to_result, result_to_source); }
};

/// Of two convex bodies: exact up to rounding, for the greatest distance is at a corner.
Result<Deviation> deviation_of_hulls(const Convex& source, const Convex& result);

inline constexpr std::size_t samples_default = 5'000;

/// Of a solid and convex parts that stand for it, by sample points: the solid's vertices and surface against the parts;
/// the parts' corners, surface and inside against the solid.
Result<Deviation> deviation_of_solids(const Soup& source, const Surface& surface,
                                      const std::vector<Convex>& parts,
                                      std::size_t samples = samples_default);

/// Of two surfaces: all vertices (at most 50,000 of each) and as many points between them.
Result<Deviation> deviation_of_surfaces(const Soup& source, const Surface& source_surface, const Soup& result,
                                        std::size_t samples = samples_default);

/// Of a height field and what is seen of the source from above, within the source's bounds.
Result<Deviation> deviation_from_above(const Soup& source, const Surface& source_surface, const Soup& result,
                                       std::size_t samples = samples_default);

} // namespace lockstone::cook
