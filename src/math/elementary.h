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

/// sqrt(n / 2^60) with 60 fraction bits.
inline std::int64_t sqrt_60(std::uint64_t n) { return static_cast<std::int64_t>(isqrt(n >> 4, n << 60)); }

} // namespace lockstone::detail
