// Samples a model from above on a grid.
#pragma once

#include "cook/surface.h"
#include "lockstone/asset.h"

namespace lockstone::cook {

struct Heights {
    std::uint32_t columns, rows;
    Length spacing;
    Point origin; ///< the first sample in the model's axes; heights are relative to it
    std::vector<Length> heights;
    std::vector<std::uint8_t> cells; ///< 255 if a corner of the cell lies outside of the model, else 0
};

/// The highest surface at each sample. The grid begins at the model's least x and z. The last row and column may lie up
/// to one spacing beyond the model; they repeat its edge. An error if a side needs more samples, or the heights need a
/// larger range, than an asset may have.
Result<Heights> sample_heights(const Soup& model, const Surface& surface, double spacing);

} // namespace lockstone::cook
