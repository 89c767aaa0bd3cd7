// Signed 128-bit integers with the operations that fixed-point arithmetic needs: exact products of 64-bit
// integers.
//
// Two implementations with one interface and equal bits: WideNative uses the compiler's 128-bit integer,
// WidePortable two 64-bit halves, for MSVC, 32-bit targets and WebAssembly. `Wide` is the selected one;
// -DLOCKSTONE_PORTABLE_WIDE=1 selects the portable one. Tests compare both. All functions are pure and
// thread-safe.
#pragma once

#include "lockstone/compiler.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace lockstone {

/// Number of significant bits, floor(log2(v)) + 1; 0 for 0.
constexpr int bit_length(std::uint64_t v) { return 64 - std::countl_zero(v); }

/// |v| as an unsigned integer; correct for the most negative v too.
constexpr std::uint64_t magnitude(std::int64_t v) {
    return v < 0 ? 0 - static_cast<std::uint64_t>(v) : static_cast<std::uint64_t>(v);
}

namespace detail {
/// Out of line, so that the usual path has one comparison and no select instruction.
#if LOCKSTONE_GNU
[[gnu::noinline, gnu::cold]]
#endif
constexpr std::int32_t
end_of_int32(std::int64_t v) {
    return v < 0 ? std::numeric_limits<std::int32_t>::min() : std::numeric_limits<std::int32_t>::max();
}
} // namespace detail

/// v clamped to [-2^31, 2^31 - 1].
constexpr std::int32_t saturate_to_int32(std::int64_t v) {
    const std::int32_t low = static_cast<std::int32_t>(v);
    if (low == v) [[likely]]
        return low;
    return detail::end_of_int32(v);
}

/// a + b clamped to the range of int64.
constexpr std::int64_t add_saturated(std::int64_t a, std::int64_t b) {
    std::int64_t sum = 0;
#if LOCKSTONE_GNU
    const bool overflows = __builtin_add_overflow(a, b, &sum);
#else
    sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
    // Overflow: both terms have another sign than the sum.
    const bool overflows = ((a ^ sum) & (b ^ sum)) < 0;
#endif
    if (overflows) [[unlikely]]
        return a < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
    return sum;
}

/// a - b clamped to the range of int64.
constexpr std::int64_t sub_saturated(std::int64_t a, std::int64_t b) {
    std::int64_t difference = 0;
#if LOCKSTONE_GNU
    const bool overflows = __builtin_sub_overflow(a, b, &difference);
#else
    difference = static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
    const bool overflows = ((a ^ b) & (a ^ difference)) < 0;
#endif
    if (overflows) [[unlikely]]
        return a < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
    return difference;
}

/// floor(v / 2^shift + 1/2), the rounding of the library. 0 <= shift <= 62; no intermediate overflow.
constexpr std::int64_t shift_right_rounded(std::int64_t v, int shift) {
    if (shift == 0) return v;
#if LOCKSTONE_GNU
    if (__builtin_constant_p(shift) && shift > 1)
        return ((v >> (shift - 1)) + 1) >> 1; // equal, two instructions less
#endif
    return (v >> shift) + ((v >> (shift - 1)) & 1);
}

/// v * 2^shift clamped to the range of int64. 0 <= shift <= 63.
constexpr std::int64_t shift_left_saturated(std::int64_t v, int shift) {
    const std::int64_t shifted = static_cast<std::int64_t>(static_cast<std::uint64_t>(v) << shift);
    if ((shifted >> shift) != v)
        return v < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
    return shifted;
}

/// A signed 128-bit integer in two halves. Arithmetic wraps, as that of WideNative.
struct WidePortable {
    std::uint64_t low; ///< bits 0..63
    std::int64_t high; ///< bits 64..127

    /// The integer v.
    static constexpr WidePortable from(std::int64_t v) {
        return {static_cast<std::uint64_t>(v), v < 0 ? -1 : 0};
    }

    /// The product of two unsigned 64-bit integers, from four 32-bit products.
    static constexpr WidePortable product_unsigned(std::uint64_t a, std::uint64_t b) {
        const std::uint64_t a0 = a & 0xffffffffu, a1 = a >> 32, b0 = b & 0xffffffffu, b1 = b >> 32;
        const std::uint64_t p00 = a0 * b0, p01 = a0 * b1, p10 = a1 * b0, p11 = a1 * b1;
        const std::uint64_t middle = (p00 >> 32) + (p01 & 0xffffffffu) + (p10 & 0xffffffffu);
        return {(middle << 32) | (p00 & 0xffffffffu),
                static_cast<std::int64_t>(p11 + (p01 >> 32) + (p10 >> 32) + (middle >> 32))};
    }
    /// The product of two signed 64-bit integers.
    static constexpr WidePortable product(std::int64_t a, std::int64_t b) {
        WidePortable p = product_unsigned(static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(b));
        // A negative factor was used as itself + 2^64: subtract 2^64 times the other factor.
        std::uint64_t high = static_cast<std::uint64_t>(p.high);
        if (a < 0) high -= static_cast<std::uint64_t>(b);
        if (b < 0) high -= static_cast<std::uint64_t>(a);
        return {p.low, static_cast<std::int64_t>(high)};
    }

    /// Arithmetic and comparison.
    ///@{
    friend constexpr WidePortable operator+(WidePortable a, WidePortable b) {
        const std::uint64_t sum = a.low + b.low;
        return {sum, static_cast<std::int64_t>(static_cast<std::uint64_t>(a.high) +
                                               static_cast<std::uint64_t>(b.high) + (sum < a.low ? 1u : 0u))};
    }
    friend constexpr WidePortable operator-(WidePortable a, WidePortable b) {
        return {a.low - b.low,
                static_cast<std::int64_t>(static_cast<std::uint64_t>(a.high) -
                                          static_cast<std::uint64_t>(b.high) - (a.low < b.low ? 1u : 0u))};
    }
    friend constexpr bool operator==(WidePortable a, WidePortable b) {
        return a.low == b.low && a.high == b.high;
    }
    friend constexpr bool operator<(WidePortable a, WidePortable b) {
        return a.high != b.high ? a.high < b.high : a.low < b.low;
    }
    ///@}
    constexpr bool is_negative() const { return high < 0; } ///< True below 0.

    /// Shifts by 0..127; the right shift is arithmetic.
    ///@{
    friend constexpr WidePortable operator<<(WidePortable a, int n) {
        if (n == 0) return a;
        if (n >= 64) return {0, static_cast<std::int64_t>(a.low << (n - 64))};
        return {a.low << n,
                static_cast<std::int64_t>((static_cast<std::uint64_t>(a.high) << n) | (a.low >> (64 - n)))};
    }
    friend constexpr WidePortable operator>>(WidePortable a, int n) {
        if (n == 0) return a;
        if (n >= 64) return {static_cast<std::uint64_t>(a.high >> (n - 64)), a.high < 0 ? -1 : 0};
        return {(a.low >> n) | (static_cast<std::uint64_t>(a.high) << (64 - n)), a.high >> n};
    }
    ///@}
    constexpr std::uint64_t low_bits() const { return low; }  ///< Bits 0..63.
    constexpr std::int64_t high_bits() const { return high; } ///< Bits 64..127.
};

#if LOCKSTONE_HAS_INT128
__extension__ typedef __int128 int128_t;           ///< the compiler's signed type
__extension__ typedef unsigned __int128 uint128_t; ///< the compiler's unsigned type

namespace detail {
/// Returns v and hides its origin from g++. Otherwise g++ widens a common factor of several products once,
/// and then uses three multiplications for each product in place of one.
constexpr std::int64_t kept_narrow(std::int64_t v) {
#if !defined(__clang__)
    if (!std::is_constant_evaluated() && !__builtin_constant_p(v)) asm("" : "+r"(v));
#endif
    return v;
}
} // namespace detail

/// A signed 128-bit integer of the compiler's type. Arithmetic wraps. Members as those of WidePortable.
struct WideNative {
    int128_t value; ///< the integer

    static constexpr WideNative from(std::int64_t v) { return {v}; } ///< The integer v.
    /// The product of two signed 64-bit integers.
    static constexpr WideNative product(std::int64_t a, std::int64_t b) {
        return {static_cast<int128_t>(detail::kept_narrow(a)) * detail::kept_narrow(b)};
    }
    /// The product of two unsigned 64-bit integers.
    static constexpr WideNative product_unsigned(std::uint64_t a, std::uint64_t b) {
        return {static_cast<int128_t>(static_cast<uint128_t>(a) * b)};
    }
    /// Arithmetic, comparison and shifts.
    ///@{
    friend constexpr WideNative operator+(WideNative a, WideNative b) {
        return {static_cast<int128_t>(static_cast<uint128_t>(a.value) + static_cast<uint128_t>(b.value))};
    }
    friend constexpr WideNative operator-(WideNative a, WideNative b) {
        return {static_cast<int128_t>(static_cast<uint128_t>(a.value) - static_cast<uint128_t>(b.value))};
    }
    friend constexpr bool operator==(WideNative a, WideNative b) { return a.value == b.value; }
    friend constexpr bool operator<(WideNative a, WideNative b) { return a.value < b.value; }
    ///@}
    constexpr bool is_negative() const { return value < 0; } ///< True below 0.
    /// Shifts by 0..127; the right shift is arithmetic.
    ///@{
    friend constexpr WideNative operator<<(WideNative a, int n) {
        return {static_cast<int128_t>(static_cast<uint128_t>(a.value) << n)};
    }
    friend constexpr WideNative operator>>(WideNative a, int n) { return {a.value >> n}; }
    ///@}
    /// Bits 0..63.
    constexpr std::uint64_t low_bits() const { return static_cast<std::uint64_t>(value); }
    /// Bits 64..127.
    constexpr std::int64_t high_bits() const { return static_cast<std::int64_t>(value >> 64); }
};
#endif

#if LOCKSTONE_HAS_INT128 && !LOCKSTONE_PORTABLE_WIDE
using Wide = WideNative; ///< the selected 128-bit integer
#else
using Wide = WidePortable; ///< the selected 128-bit integer
#endif

/// a + b and a - b, clamped to 128 bits: three squares of 64-bit integers can reach 3 * 2^126.
///@{
template <class W>
requires requires(W w) { w.high_bits(); }
constexpr W add_saturated(W a, W b) {
    const W sum = a + b;
    if (((a.high_bits() ^ sum.high_bits()) & (b.high_bits() ^ sum.high_bits())) >= 0) return sum;
    const W smallest = W::from(1) << 127;
    return a.is_negative() ? smallest : smallest - W::from(1);
}
template <class W>
requires requires(W w) { w.high_bits(); }
constexpr W sub_saturated(W a, W b) {
    const W difference = a - b;
    if (((a.high_bits() ^ b.high_bits()) & (a.high_bits() ^ difference.high_bits())) >= 0) return difference;
    const W smallest = W::from(1) << 127;
    return a.is_negative() ? smallest : smallest - W::from(1);
}

///@}

/// w clamped to the range of int64.
template <class W> constexpr std::int64_t saturate_to_int64(W w) {
    const std::int64_t low = static_cast<std::int64_t>(w.low_bits());
    if (w.high_bits() == (low < 0 ? -1 : 0)) return low;
    return w.is_negative() ? std::numeric_limits<std::int64_t>::min()
                           : std::numeric_limits<std::int64_t>::max();
}

/// floor(w / 2^shift + 1/2), clamped to int64. 0 <= shift <= 126.
template <class W> constexpr std::int64_t narrow_rounded(W w, int shift) {
    if (shift == 0) return saturate_to_int64(w);
#if LOCKSTONE_GNU
    if (__builtin_constant_p(shift) && shift > 1) {
        const W twice = (w >> (shift - 1)) + W::from(1);
        if (static_cast<std::uint64_t>(twice.high_bits()) + 1 <= 1) [[likely]] // at most 65 bits
            return static_cast<std::int64_t>((twice >> 1).low_bits());
        return w.is_negative() ? std::numeric_limits<std::int64_t>::min()
                               : std::numeric_limits<std::int64_t>::max();
    }
#endif
    const W half_bit = W::from(static_cast<std::int64_t>((w >> (shift - 1)).low_bits() & 1u));
    return saturate_to_int64((w >> shift) + half_bit);
}

/// narrow_rounded() of a product, faster: a product plus half a step cannot overflow. 0 <= shift <= 63.
constexpr std::int64_t product_rounded(std::int64_t a, std::int64_t b, int shift) {
    if (shift == 0) return saturate_to_int64(Wide::product(a, b));
    const Wide w = Wide::product(a, b) + Wide::from(std::int64_t{1} << (shift - 1));
    const std::int64_t high = w.high_bits();
    const int left = 64 - shift;
    if ((high << left >> left) == high) [[likely]]
        return static_cast<std::int64_t>((w >> shift).low_bits());
    return high < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
}

/// Result of a division.
struct QuotientRemainder {
    std::uint64_t quotient, ///< floor of the quotient
        remainder;          ///< below the divisor
};

/// divide_128_by_64() with 64-bit integers: Knuth's algorithm D with two 32-bit digits. Source: Knuth, TAOCP
/// vol. 2, 4.3.1; Warren, Hacker's Delight, 9-4.
constexpr QuotientRemainder divide_128_by_64_portable(std::uint64_t high, std::uint64_t low,
                                                      std::uint64_t divisor) {
    const int shift = std::countl_zero(divisor);
    const std::uint64_t d = divisor << shift;
    const std::uint64_t d1 = d >> 32, d0 = d & 0xffffffffu;
    const std::uint64_t n32 = shift == 0 ? high : (high << shift) | (low >> (64 - shift));
    const std::uint64_t n10 = low << shift;
    const std::uint64_t digits[2] = {n10 >> 32, n10 & 0xffffffffu};
    std::uint64_t rest = n32, quotient = 0;
    for (std::uint64_t digit : digits) {
        std::uint64_t q = rest / d1, r = rest % d1;
        while (q > 0xffffffffu || q * d0 > ((r << 32) | digit)) {
            --q;
            r += d1;
            if (r > 0xffffffffu) break;
        }
        rest = ((rest << 32) | digit) - q * d;
        quotient = (quotient << 32) | q;
    }
    return {quotient, rest >> shift};
}

/// (high * 2^64 + low) / divisor. Requires high < divisor.
constexpr QuotientRemainder divide_128_by_64(std::uint64_t high, std::uint64_t low, std::uint64_t divisor) {
#if LOCKSTONE_HAS_INT128 && !LOCKSTONE_PORTABLE_WIDE
    const uint128_t n = (static_cast<uint128_t>(high) << 64) | low;
    const auto quotient = static_cast<std::uint64_t>(n / divisor); // n % divisor would be a second division
    return {quotient, low - quotient * divisor};
#else
    return divide_128_by_64_portable(high, low, divisor);
#endif
}

/// floor(n * 2^shift / d + 1/2), clamped to int64. For d = 0 the largest or smallest int64 by the sign of n,
/// or 0 for n = 0. 0 <= shift <= 63.
constexpr std::int64_t divide_shifted(std::int64_t n, std::int64_t d, int shift) {
    constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();
    constexpr std::int64_t smallest = std::numeric_limits<std::int64_t>::min();
    if (n == 0) return 0;
    if (d == 0) return n < 0 ? smallest : largest;
    const bool negative = (n < 0) != (d < 0);
    const std::uint64_t nm = magnitude(n), dm = magnitude(d);
    const std::uint64_t high = shift == 0 ? 0 : nm >> (64 - shift), low = nm << shift;
    if (high >= dm) return negative ? smallest : largest;
    const QuotientRemainder qr =
        high == 0 ? QuotientRemainder{low / dm, low % dm} : divide_128_by_64(high, low, dm);
    // Ties round towards plus infinity: up if positive, down in magnitude if negative.
    const std::uint64_t rest = dm - qr.remainder;
    const std::uint64_t q = qr.quotient + ((negative ? qr.remainder > rest : qr.remainder >= rest) ? 1u : 0u);
    if (!negative)
        return q > static_cast<std::uint64_t>(largest) || q < qr.quotient ? largest
                                                                          : static_cast<std::int64_t>(q);
    return q > static_cast<std::uint64_t>(largest) || q < qr.quotient ? smallest
                                                                      : -static_cast<std::int64_t>(q);
}

} // namespace lockstone
