// A model seen from above, sampled on a grid.
#pragma once

#include "cook/surface.h"
#include "lockstone/asset.h"

namespace lockstone::cook {

struct Heights {
    std::uint32_t columns, rows;
    Length spacing;
    Point origin; ///< of the first sample in the model's axes; heights are relative to it
    std::vector<Length> heights;
    std::vector<std::uint8_t> cells; ///< 255 where a corner of the cell lies beside the model, else 0
};

/// The highest surface at each sample. The grid begins at the model's least x and z; its last row and column may lie up
/// to one spacing beyond the model and repeat its rim. Error when a side needs more samples than an asset may have, or
/// the model is higher than heights may be.
Result<Heights> sample_heights(const Soup& model, const Surface& surface, double spacing);

} // namespace lockstone::cook
