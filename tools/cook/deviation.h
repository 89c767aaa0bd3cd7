// Measures how far an asset deviates from its model. The asset is read back from its bytes first.
//
// Distances are those to the nearest triangle. The greatest distance is checked with another library: libccd for convex
// bodies, FCL for surfaces. If the two disagree, the result is an error. `samples` is the number of sample points
// between vertices.
#pragma once

#include "cook/convex.h"
#include "cook/surface.h"

#include <vector>

namespace lockstone::cook {

/// Deviation in both directions, since either may be small while the other is large [m].
struct Deviation {
    double source_to_result = 0; ///< largest distance of a point of the source from the result
    double result_to_source = 0; ///< largest distance of a point of the result from the source
    double largest() const { return std::max(source_to_result, result_to_source); }
};

/// Between two convex bodies: exact up to rounding, because a corner has the greatest distance.
Result<Deviation> deviation_of_hulls(const Convex& source, const Convex& result);

inline constexpr std::size_t samples_default = 5'000;

/// Between a solid and the convex parts that represent it, by sample points: the solid's vertices and surface against
/// the parts; the parts' corners, surface and inside against the solid.
Result<Deviation> deviation_of_solids(const Soup& source, const Surface& surface,
                                      const std::vector<Convex>& parts,
                                      std::size_t samples = samples_default);

/// Between two surfaces, by their vertices (at most 50,000 of each) and as many points between them.
Result<Deviation> deviation_of_surfaces(const Soup& source, const Surface& source_surface, const Soup& result,
                                        std::size_t samples = samples_default);

/// Between a height field and the source as seen from above, within the bounds of the source.
Result<Deviation> deviation_from_above(const Soup& source, const Surface& source_surface, const Soup& result,
                                       std::size_t samples = samples_default);

} // namespace lockstone::cook
