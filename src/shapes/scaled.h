// A number mantissa * 2^exponent with 62 significant bits, for volumes and moments, which range from 1e-17 to
// 1e12 in SI units.
#pragma once

#include "lockstone/math/fixed.h"

#include <cstdint>

namespace lockstone::shapes {

/// Not normalised: equal numbers may have different members.
struct Scaled {
    std::int64_t mantissa; ///< |mantissa| < 2^62: `reduced` ensures it, and the shifts below rely on it
    int exponent;
};

/// Reduces any mantissa to below 2^62, rounded. Loops a second time when rounding gives 2^62 itself; that
/// halving is exact.
constexpr Scaled reduced(std::int64_t mantissa, int exponent) {
    for (; bit_length(magnitude(mantissa)) > 62; ++exponent) mantissa = shift_right_rounded(mantissa, 1);
    return {mantissa, exponent};
}

/// A 128-bit value (not the most negative) reduced to 62 significant bits, rounded.
constexpr Scaled scaled(Wide value, int exponent) {
    const Wide positive = value.is_negative() ? Wide::from(0) - value : value;
    const std::uint64_t high = static_cast<std::uint64_t>(positive.high_bits());
    const int length = high != 0 ? 64 + bit_length(high) : bit_length(positive.low_bits());
    const int shift = length > 62 ? length - 62 : 0;
    return reduced(narrow_rounded(value, shift), exponent + shift);
}
constexpr Scaled scaled(std::int64_t raw, int fraction_bits) { return reduced(raw, -fraction_bits); }
template <FixedPoint T> constexpr Scaled scaled(T x) { return scaled(std::int64_t{x.raw}, T::fraction_bits); }

constexpr Scaled operator*(Scaled a, Scaled b) {
    return scaled(Wide::product(a.mantissa, b.mantissa), a.exponent + b.exponent);
}
constexpr Scaled operator*(std::int32_t n, Scaled a) { return scaled(std::int64_t{n}, 0) * a; }
constexpr Scaled operator-(Scaled a) { return {-a.mantissa, a.exponent}; }
constexpr Scaled operator+(Scaled a, Scaled b) {
    if (a.exponent < b.exponent) return b + a;
    if (a.mantissa == 0) return b;
    const int apart = a.exponent - b.exponent; // 2^62 * 2^64 and 2^62 more: below 2^127
    if (apart <= 64) return scaled((Wide::from(a.mantissa) << apart) + Wide::from(b.mantissa), b.exponent);
    const int drop = apart - 64 < 62 ? apart - 64 : 62;
    return scaled((Wide::from(a.mantissa) << 64) + Wide::from(shift_right_rounded(b.mantissa, drop)),
                  a.exponent - 64);
}
constexpr Scaled operator-(Scaled a, Scaled b) { return a + -b; }
/// The divisor must not be 0. Both mantissas are shifted into 2^61 .. 2^62, so the quotient is in 2^59 .. 2^61.
constexpr Scaled operator/(Scaled a, Scaled b) {
    if (a.mantissa == 0) return a;
    const auto zeros = [](std::int64_t m) { return 62 - bit_length(magnitude(m)); };
    const int up_a = zeros(a.mantissa), up_b = zeros(b.mantissa);
    const std::int64_t n = a.mantissa * (std::int64_t{1} << up_a), d = b.mantissa * (std::int64_t{1} << up_b);
    return {divide_shifted(n, d, 60), a.exponent - up_a - (b.exponent - up_b) - 60};
}
constexpr bool operator<(Scaled a, Scaled b) { return (a - b).mantissa < 0; }

/// Rounds and clamps to a fixed-point format.
template <FixedPoint T> constexpr T unscaled(Scaled s) {
    const int shift = -s.exponent - T::fraction_bits;
    if (s.mantissa == 0 || shift > 62) return T{};
    const std::int64_t raw = shift >= 0    ? shift_right_rounded(s.mantissa, shift)
                             : shift < -62 ? shift_left_saturated(s.mantissa, 63)
                                           : shift_left_saturated(s.mantissa, -shift);
    if constexpr (sizeof(typename T::rep) == 8)
        return T::from_raw(raw);
    else
        return T::from_raw(saturate_to_int32(raw));
}

} // namespace lockstone::shapes
