// Bounds of turned capsules and boxes by an instruction set, many at once.
#pragma once

#include <cstdint>

namespace lockstone::collide {

/// Capsules and boxes of scale 1 side by side: what their axes and bounds are made of, and where those go.
struct RoundBoxes {
    static constexpr std::uint32_t room = 32, lanes_max = 4; ///< no kernel takes more at once

    const std::int32_t* rotation[room];      ///< a Quat
    std::int32_t *axes[room], *bounds[room]; ///< a Rotation and a Bounds
    std::int64_t position[3][room];          ///< [m], Real
    std::int64_t margin[room];               ///< with all that roundings may add: Length steps
    std::int64_t radius[room];               ///< Length
    std::int32_t half[3][room];              ///< [m] along the axes, Length
};

struct BoundsKernel {
    /// Writes axes and bounds of the first `count`, to the bits of to_rotation() and bounds_of(), with steps of 2^(drop - 32) m. Entries up to
    /// the next multiple of `lanes_max` may be read and written too. Returns a bit for each entry whose quaternion is far from unit length, or that
    /// reaches further than 16 km from the origin: what was written of it means nothing.
    std::uint32_t (*place)(const RoundBoxes& boxes, std::uint32_t count, int drop);
};

} // namespace lockstone::collide
