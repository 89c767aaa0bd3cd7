// Symmetric systems of one to six rows in integers, for the direct solver of joints.
//
//   A          = m / 2^60 2^exponent; m of the largest diagonal entry is in [2^59, 2^60): all |m| / 2^60 are below 1
//   A          = L D L^T, L unit lower             source: Golub, Van Loan, Matrix Computations, 4.1
//   pivots     at least 2^-24, so that |L| <= 2^12 and 1 / D <= 2^24
//   B^T A^-1 B = X^T D^-1 X, X = L^-1 B            for B with entries below 2
//
// Values are clamped to 2^61, so that nothing overflows; a clamped solution is wrong. Entries of L and X are below
// 2^58 if the pivots of A are as above.
#pragma once

#include "lockstone/compiler.h"
#include "lockstone/math/wide.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace lockstone::solve {

inline constexpr int block_bits = 60;         ///< fraction bits of mantissas
inline constexpr int block_factor_bits = 44;  ///< fraction bits of L
inline constexpr int block_inverse_bits = 36; ///< fraction bits of 1 / D
inline constexpr int block_arm_bits = 40;     ///< fraction bits of X = L^-1 B
inline constexpr int block_column_bits = 34;  ///< fraction bits of Z = D^-1 X
inline constexpr int block_speed_bits = 36;   ///< fraction bits of right sides and solutions [m/s]

/// A positive number, m / 2^60 2^exponent with m in [2^59, 2^60); or zero, with m = 0.
struct Scaled {
    std::int64_t m;
    int exponent;
};
/// Converts v / 2^fraction_bits, v >= 0.
Scaled scaled(std::int64_t v, int fraction_bits);

/// Lower triangle by rows: entry (i, j) is at block_index(i, j). `zero`: all entries are zero.
struct SymmetricBlock {
    std::int64_t m[21];
    int exponent;
    bool zero;
};
constexpr int block_index(int i, int j) { return i * (i + 1) / 2 + j; }

/// L without its diagonal by rows, entry (i, j) at block_index(i - 1, j); and 1 / D.
struct BlockFactor {
    std::int64_t l[15];
    std::int64_t inverse[6];
};

/// value times the unit matrix
SymmetricBlock block_of(Scaled value, int n);
/// a += b
void add(SymmetricBlock& a, const SymmetricBlock& b, int n);
/// a += diag(d)
void add_diagonal(SymmetricBlock& a, const Scaled* d, int n);

/// A = L D L^T. Returns false if a pivot is too small.
bool factorise(const SymmetricBlock& a, int n, BlockFactor& out);
/// As factorise(), but raises small pivots to the smallest allowed one, and leaves out rows of zeros.
void factorise_raised(const SymmetricBlock& a, int n, BlockFactor& out);

/// condense_rows() computes J^T A^-1 J, for A with `rows` rows; condense_columns() computes J A^-1 J^T, for A with
/// six rows. J has `rows` rows of six entries below 2, 28 fraction bits. condense_columns() also returns Z = D^-1
/// L^-1 J^T for the solution: z[row of J][entry].
void condense_rows(const BlockFactor& a, int exponent, const std::int32_t (*j)[6], int rows,
                   SymmetricBlock& out);
void condense_columns(const BlockFactor& a, int exponent, const std::int32_t (*j)[6], int rows,
                      std::int64_t (*z)[6], SymmetricBlock& out);

inline constexpr std::int64_t block_value_max = std::int64_t{1} << 61;

/// a b. If a factor is used twice, GCC 12 computes its sign in advance and then multiplies by the signs as well,
/// which takes three times as long. The assembler statements hide that it is the same factor.
inline Wide block_product(std::int64_t a, std::int64_t b) {
#if LOCKSTONE_GNU && !defined(__clang__)
    __asm__("" : "+r"(a));
    __asm__("" : "+r"(b));
#endif
    return Wide::product(a, b);
}

/// floor(sum / 2^Shift), clamped to block_value_max. The lost bits are far below those of a Speed.
template <int Shift> std::int64_t block_narrow(Wide sum) {
    static_assert(Shift > 3 && Shift < 64);
    // Within the bounds the high half is less than this, and the low one is shifted into it.
    constexpr std::uint64_t reach = std::uint64_t{1} << (Shift - 3);
    const auto high = static_cast<std::uint64_t>(sum.high_bits());
    if (high + reach < 2 * reach)
        return static_cast<std::int64_t>((high << (64 - Shift)) | (sum.low_bits() >> Shift));
    return sum.is_negative() ? -block_value_max : block_value_max;
}

std::int64_t block_shift_far(Wide sum, int shift);
/// sum / 2^shift for any shift, clamped to block_value_max. A negative shift multiplies.
inline std::int64_t block_shift(Wide sum, int shift) {
    if (shift < 4 || shift > 63) return block_shift_far(sum, shift);
    const std::uint64_t reach = std::uint64_t{1} << (shift - 3);
    const auto high = static_cast<std::uint64_t>(sum.high_bits());
    if (high + reach < 2 * reach)
        return static_cast<std::int64_t>((high << (64 - shift)) | (sum.low_bits() >> shift));
    return sum.is_negative() ? -block_value_max : block_value_max;
}

/// Calls f(0), f(1), ... f(N - 1), unrolled.
template <int N, class F> constexpr void each(F&& f) {
    [&]<int... I>(std::integer_sequence<int, I...>) { (f(std::integral_constant<int, I>{}), ...); }
    (std::make_integer_sequence<int, N>{});
}

/// a . b of six entries: six products of two values stay below 2^125.
template <class T> Wide block_dot(const T* a, const std::int64_t* b) {
    Wide sum = block_product(a[0], b[0]);
    each<5>([&](auto i) { sum = sum + block_product(a[i + 1], b[i + 1]); });
    return sum;
}

/// x := A^-1 x
void solve(const BlockFactor& a, int n, std::int64_t* x);
/// x := L^-1 x of six rows
void solve_lower(const BlockFactor& a, std::int64_t* x);
/// x := L^-T x of six rows
void solve_upper(const BlockFactor& a, std::int64_t* x);

} // namespace lockstone::solve
