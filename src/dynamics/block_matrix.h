// Symmetric systems of one to six rows in integers, for the direct solver of joints.
//
//   A          = m / 2^60 2^exponent; the largest diagonal entry's m is in [2^59, 2^60): magnitudes stay below 1
//   A          = L D L^T, L unit lower             source: Golub, Van Loan, Matrix Computations, 4.1
//   pivots     at least 2^-24, so that |L| <= 2^12 and 1 / D <= 2^24
//   B^T A^-1 B = X^T D^-1 X, X = L^-1 B            of B with entries below 2
//
// What cannot be within these bounds is clamped to them: then a solution is wrong, but nothing overflows.
#pragma once

#include "lockstone/wide.h"

#include <algorithm>
#include <cstdint>

namespace lockstone::dynamics {

inline constexpr int block_bits = 60;         ///< of mantissas
inline constexpr int block_factor_bits = 44;  ///< of L
inline constexpr int block_inverse_bits = 36; ///< of 1 / D
inline constexpr int block_arm_bits = 40;     ///< of X = L^-1 B
inline constexpr int block_column_bits = 34;  ///< of Z = D^-1 X
inline constexpr int block_speed_bits = 36;   ///< of right sides and solutions [m/s]

/// A number above zero: m / 2^60 2^exponent, m in [2^59, 2^60). Zero: m is 0.
struct Scaled {
    std::int64_t m;
    int exponent;
};
/// v / 2^fraction_bits of v >= 0.
Scaled scaled(std::int64_t v, int fraction_bits);

/// Lower triangle by rows: entry (i, j) is at block_index(i, j). Of zeros where `zero`.
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

/// False when a pivot is too small.
bool factorise(const SymmetricBlock& a, int n, BlockFactor& out);
/// Pivots that are too small are raised to the least; rows of zeros are left out.
void factorise_raised(const SymmetricBlock& a, int n, BlockFactor& out);

/// B^T A^-1 B of A with n rows; B has `columns` columns, given one after another with 28 fraction bits and below 2.
/// One of n and columns is 6. Z = D^-1 L^-1 B is kept for the solution, column by column.
void condense(const BlockFactor& a, int exponent, int n, const std::int32_t (*b)[6], int columns,
              std::int64_t (*z)[6], SymmetricBlock& out);

inline constexpr std::int64_t block_value_max = std::int64_t{1} << 61;

/// (a - sum) / 2^shift, within the bounds of values.
inline std::int64_t block_narrow(Wide sum, int shift) {
    return std::clamp(narrow_rounded(sum, shift), -block_value_max, block_value_max);
}
/// The same for any shift; a negative one multiplies.
std::int64_t block_shift(Wide sum, int shift);

/// x := L^-1 x
void solve_lower(const BlockFactor& a, int n, std::int64_t* x);
/// x := D^-1 x
void solve_diagonal(const BlockFactor& a, int n, std::int64_t* x);
/// x := L^-T x
void solve_upper(const BlockFactor& a, int n, std::int64_t* x);

} // namespace lockstone::dynamics
