// Integers of the scalar reference of the contact solver. Sums wrap, as in lanes.
#pragma once

#include "solve/contacts/pack.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace lockstone::test::reference {

using namespace solve; // formats and limits of pack.h
using i32 = std::int32_t;
using i64 = std::int64_t;
using u64 = std::uint64_t;

inline constexpr i32 one = 1 << unit_bits;
inline constexpr i32 speed_limit = 1 << 28;  ///< 512 m/s, of an error of speed
inline constexpr i32 answer_limit = 1 << 29; ///< of an impulse that corrects such an error
inline constexpr i32 impact_speed = 1 << 17; ///< 0.25 m/s: a faster impact is a hit
inline constexpr i32 pull_tolerance = 16;    ///< 3e-5 m/s: a smaller pull is rounding
inline constexpr i32 overlap_max = 1 << gap_bits;
inline constexpr i32 gap_limit = 0x7fffffff;
/// Index of entry (i, j) of a symmetric matrix that is stored by rows of the lower triangle.
inline constexpr int lower[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};

inline i64 plus(i64 a, i64 b) { return i64(u64(a) + u64(b)); }
inline i64 minus(i64 a, i64 b) { return i64(u64(a) - u64(b)); }
inline i64 plus(i64 a, i64 b, i64 c) { return plus(plus(a, b), c); }
inline i32 low(i64 x) { return static_cast<i32>(x); }
inline i64 times(i32 a, i32 b) { return i64{a} * b; }
/// x / 2^drop to the nearest, halves upwards.
inline i32 rounded(i64 x, int drop) { return low(plus(x, i64{1} << (drop - 1)) >> drop); }
inline i32 rounded_within(i64 x, int drop, i32 limit) {
    const i64 least = -(i64{limit} << drop), most = (i64{limit} << drop) + (i64{1} << (drop - 1)) - 1;
    return rounded(std::clamp(x, least, most), drop);
}
inline i32 bounded(i32 x) { return std::clamp(x, -speed_limit, speed_limit); }
/// floor(sqrt(x)) for 0 <= x < 2^62.
inline i64 root(i64 x) {
    i64 r = static_cast<i64>(std::sqrt(static_cast<double>(x)));
    while (r * r > x) --r;
    while ((r + 1) * (r + 1) <= x) ++r;
    return r;
}
/// Shifts values right, alike, until they have at most `bits` bits.
inline void shorten(i64 (&x)[6], int bits) {
    i64 most = 0;
    for (const i64 i : x) most |= std::abs(i);
    for (; most >> bits != 0; most >>= 1)
        for (i64& i : x) i >>= 1;
}

} // namespace lockstone::test::reference
