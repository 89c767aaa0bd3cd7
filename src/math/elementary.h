// The elementary functions before their last rounding, in 60 to 62 fraction bits. Shared inside src/math.
#pragma once

#include "lockstone/math/math.h"

namespace lockstone::detail {

/// floor(a * b / 2^62).
constexpr std::int64_t mul62(std::int64_t a, std::int64_t b) {
    return static_cast<std::int64_t>((Wide::product(a, b) >> 62).low_bits());
}

struct SinCos62 {
    std::int64_t sin, cos; ///< 62 fraction bits, within 2^-59
};
/// raw / 2^fraction_bits in radians; fraction_bits in 16..62.
SinCos62 sin_cos_62(std::int64_t raw, int fraction_bits);

/// The angle of (x, y) with 60 fraction bits, within 2^-57; x and y share any scale. 0 for (0, 0).
std::int64_t atan2_60(std::int64_t y, std::int64_t x);

/// Constants of integrate_rotation for rotations whose components are all below 1 / 8. The solver's lanes use them
/// too.
struct SmallTurn {
    static constexpr int least_bits = 3;
    /// coefficients of the series, with 30 fraction bits
    static constexpr std::int64_t half = 1 << 29, sixth = 178956971, one_of_24 = 44739243,
                                  one_of_120 = 8947849, one_of_720 = 1491308, one_of_5040 = 213044;
    /// The greatest difference of |q|^2 from 1, with 60 fraction bits; beyond it, a square root normalizes q.
    static constexpr std::int64_t length_error = std::int64_t{1} << 40;
};

/// sqrt(n / 2^60) with 60 fraction bits.
inline std::int64_t sqrt_60(std::uint64_t n) { return static_cast<std::int64_t>(isqrt(n >> 4, n << 60)); }

} // namespace lockstone::detail
