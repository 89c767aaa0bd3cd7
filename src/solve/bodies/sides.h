// Regions of space for workers: one worker solves the constraints of a region, as far as the order of solving allows.
#pragma once

#include "base/strands.h"
#include "lockstone/math/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lockstone::solve {

/// Slabs with an equal part of the sample in each. They lie across the direction along which the sample is spread most:
/// an axis, or a diagonal of two. Directions from early to late constraints count less: in a pile that is solved from
/// the top down, the lower half would wait until the upper one is done.
class Sides {
  public:
    static constexpr std::size_t samples_max = 256;
    /// The stride that takes at most samples_max of many items in order.
    static constexpr std::size_t stride_of(std::size_t items) { return items / samples_max + 1; }

    /// `sample`: positions in the order of solving, at most samples_max. `count`: 1 to base::strands_max.
    Sides(std::span<const Vec3> sample, std::uint32_t count);
    /// The number of the slab at a position, below `count`.
    std::uint32_t side_of(const Vec3& position) const {
        std::uint32_t side = 0;
        const std::int64_t at = along(position, direction);
        while (side < cut_count && at >= cuts[side]) ++side;
        return side;
    }

  private:
    /// Factors of x, y and z, each -1, 0 or 1.
    using Direction = std::array<std::int8_t, 3>;
    static constexpr int drop = 12; ///< bits that coordinates lose, so that sums have room
    static std::int64_t along(const Vec3& position, Direction d) {
        return d[0] * (position.x.raw >> drop) + d[1] * (position.y.raw >> drop) +
               d[2] * (position.z.raw >> drop);
    }
    static std::int64_t width_of(std::span<const std::int64_t> x);

    Direction direction{1, 0, 0};
    std::uint32_t cut_count = 0;
    std::int64_t cuts[base::strands_max] = {};
};

} // namespace lockstone::solve
