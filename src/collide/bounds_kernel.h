// Bounds of many turned capsules and boxes at once, by SIMD instructions.
#pragma once

#include <cstdint>

namespace lockstone::collide {

/// A batch of capsules and boxes of scale 1, in arrays [entry]: inputs, and where to write axes and bounds.
struct RoundBoxes {
    static constexpr std::uint32_t room = 32, lanes_max = 4; ///< no kernel takes more at once

    const std::int32_t* rotation[room];      ///< a Quat
    std::int32_t *axes[room], *bounds[room]; ///< a Rotation and a Bounds
    std::int64_t position[3][room];          ///< [m], Real
    std::int64_t margin[room];               ///< includes the bound of the rounding errors: Length steps
    std::int64_t radius[room];               ///< Length
    std::int32_t half[3][room];              ///< [m] along the axes, Length
};

struct BoundsKernel {
    /// Writes axes and bounds of the first `count` entries, bit for bit as to_rotation() and bounds_of() do, in
    /// steps of 2^(drop - 32) m. It may also read and write the entries up to the next multiple of `lanes_max`.
    /// Returns one bit for each entry that it cannot compute: its quaternion is far from unit length, or it
    /// reaches further than 16 km from the origin. The values written for such an entry are invalid.
    std::uint32_t (*place)(const RoundBoxes& boxes, std::uint32_t count, int drop);
};

} // namespace lockstone::collide
