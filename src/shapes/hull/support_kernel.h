// The support mapping of hulls by an instruction set; src/solve/pairs has a kernel for each set.
#pragma once

#include <cstdint>

namespace lockstone::shapes {

/// Corners of a hull lie side by side in blocks of so many: the widest instruction set takes one at once.
inline constexpr std::uint32_t corner_block = 8;

/// `corners`: x of all of them, then y, then z, `stride` of each, a multiple of `corner_block`; 24 fraction bits. No sum of three
/// products with a direction exceeds 63 bits.
struct SupportKernel {
    /// Which corner lies furthest along a direction, of several equally far ones the first.
    std::uint32_t (*furthest)(const std::int32_t* corners, std::uint32_t stride,
                              const std::int32_t (&direction)[3]);
    /// The least and the greatest sum of products along each of three directions.
    void (*reach)(const std::int32_t* corners, std::uint32_t stride, const std::int32_t (&directions)[3][3],
                  std::int64_t (&low)[3], std::int64_t (&high)[3]);
};

} // namespace lockstone::shapes
