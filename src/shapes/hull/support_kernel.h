// The support mapping of hulls by SIMD instructions; src/solve/pairs has a kernel for each instruction set.
#pragma once

#include <cstdint>

namespace lockstone::shapes {

/// The corners of a hull are stored in blocks of this size: the widest instruction set reads one block at once.
inline constexpr std::uint32_t corner_block = 8;

/// `corners`: the x of all corners, then the y, then the z; `stride` values of each, a multiple of
/// `corner_block`; 24 fraction bits. No sum of three products with a direction may exceed 63 bits.
struct SupportKernel {
    /// Index of the corner furthest along a direction; of several equally far ones the first.
    std::uint32_t (*furthest)(const std::int32_t* corners, std::uint32_t stride,
                              const std::int32_t (&direction)[3]);
    /// The least and the greatest dot product along each of three directions.
    void (*reach)(const std::int32_t* corners, std::uint32_t stride, const std::int32_t (&directions)[3][3],
                  std::int64_t (&low)[3], std::int64_t (&high)[3]);
};

} // namespace lockstone::shapes
