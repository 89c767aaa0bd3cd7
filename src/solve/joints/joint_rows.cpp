#include "solve/joints/joint_rows.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

Share share_of(Real numerator, Real sum) {
    const std::int64_t q = divide_shifted(numerator.raw, sum.raw, 62); // below 1
    const int length = bit_length(magnitude(q));
    if (length == 0) return {0, 0};
    if (length > 62) return {1 << 30, 0};
    return {static_cast<std::int32_t>(shifted(q, length - 30)), 62 - length};
}

int top_bit(const Scaled3& v) {
    const std::uint64_t any = magnitude(v.m[0]) | magnitude(v.m[1]) | magnitude(v.m[2]);
    return any == 0 ? -1000 : bit_length(any) - v.fraction_bits;
}

void write(std::int32_t out[3], const Scaled3& v, int exponent) {
    const int shift = v.fraction_bits + exponent - row_bits;
    if (shift > 0 && shift <= 62)
        for (int i = 0; i < 3; ++i)
            out[i] = static_cast<std::int32_t>((v.m[i] >> shift) + ((v.m[i] >> (shift - 1)) & 1));
    else
        for (int i = 0; i < 3; ++i) out[i] = static_cast<std::int32_t>(shifted(v.m[i], shift));
}

} // namespace

Shares joint_shares(const BodyMass& a, const BodyStep& sa, const BodyMass& b, const BodyStep& sb) {
    constexpr Share whole{1 << 30, 0}, none{0, 0};
    if (!sa.movable && !sb.movable) return {none, none};
    if (!sa.movable) return {none, whole};
    if (!sb.movable) return {whole, none};
    if (a.mass == b.mass) return {{1 << 29, 0}, {1 << 29, 0}}; // equal to the result of the division
    const Real sum = a.mass + b.mass;
    return {share_of(b.mass, sum), share_of(a.mass, sum)};
}

Scaled3 turning(const BodyInertia& body, const std::int64_t arm[3], int fraction_bits) {
    if (!body.moves) return {};
    const std::int64_t x = body.angular_mask & 1u ? arm[0] : 0;
    const std::int64_t y = body.angular_mask & 2u ? arm[1] : 0;
    const std::int64_t z = body.angular_mask & 4u ? arm[2] : 0;
    const Symmetric<std::int32_t>& m = body.inv_mantissa;
    // 30 bits times 31 bits, three times: below 2^63.
    return {{m.xx * x + m.xy * y + m.xz * z, m.xy * x + m.yy * y + m.yz * z, m.xz * x + m.yz * y + m.zz * z},
            body.inv_exponent + fraction_bits};
}

int set_turning_rows(Row* rows, const WideRow* wide, int count) {
    int top = -1000;
    for (int i = 0; i < count; ++i) top = std::max({top, top_bit(wide[i].xa), top_bit(wide[i].xb)});
    const int exponent = top == -1000 ? 0 : top - 1;
    for (int i = 0; i < count; ++i) {
        write(rows[i].ja + 3, wide[i].xa, exponent);
        write(rows[i].jb + 3, wide[i].xb, exponent);
    }
    return exponent;
}

int set_rows(Row* rows, const WideRow* wide, int count) {
    int top = -1000;
    for (int i = 0; i < count; ++i)
        top = std::max(
            {top, top_bit(wide[i].da), top_bit(wide[i].xa), top_bit(wide[i].db), top_bit(wide[i].xb)});
    const int exponent = top == -1000 ? 0 : top - 1;
    for (int i = 0; i < count; ++i) {
        write(rows[i].ja, wide[i].da, exponent), write(rows[i].ja + 3, wide[i].xa, exponent);
        write(rows[i].jb, wide[i].db, exponent), write(rows[i].jb + 3, wide[i].xb, exponent);
    }
    return exponent;
}

static void respond(std::int32_t r[6], std::int32_t& shift, const std::int32_t j[6], Share share,
                    const SolverBody& body) {
    shift = share.shift;
    for (int i = 0; i < 6; ++i) {
        // 29 bits times 30 bits
        const std::int64_t one = shift_right_rounded(std::int64_t{j[i]} * share.mantissa, 30);
        r[i] = static_cast<std::int32_t>(i < 3 ? one & body.keep[i] : one);
    }
}

void set_turning_responses(Row& row, const Shares& shares) {
    row.shift_a = shares.a.shift, row.shift_b = shares.b.shift;
    for (int i = 3; i < 6; ++i) {
        row.ra[i] =
            static_cast<std::int32_t>(shift_right_rounded(std::int64_t{row.ja[i]} * shares.a.mantissa, 30));
        row.rb[i] =
            static_cast<std::int32_t>(shift_right_rounded(std::int64_t{row.jb[i]} * shares.b.mantissa, 30));
    }
}

void set_responses(Row& row, const Shares& shares, const SolverBody& a, const SolverBody& b) {
    respond(row.ra, row.shift_a, row.ja, shares.a, a);
    respond(row.rb, row.shift_b, row.jb, shares.b, b);
}

// ---- inverse ------------------------------------------------------------------------------------------------------

namespace {

constexpr int k_bits = 46; ///< fraction bits of k after scaling its largest diagonal entry to [1/2, 1)
constexpr int l_bits = 36; ///< fraction bits of L, of its inverse and of 1 / D
constexpr std::int64_t pivot_min = std::int64_t{1} << (k_bits - 26);

/// j . r with 48 fraction bits: six products of 29 bits each way stay below 2^61
std::int64_t product(const Row& j, const Row& r) {
    std::int64_t a = 0, b = 0;
    for (int i = 0; i < 6; ++i) {
        a += std::int64_t{j.ja[i]} * r.ra[i];
        b += std::int64_t{j.jb[i]} * r.rb[i];
    }
    return shifted(a, 8 + r.shift_a) + shifted(b, 8 + r.shift_b);
}

std::int64_t mul(std::int64_t a, std::int64_t b, int bits) {
    return narrow_rounded(Wide::product(a, b), bits);
}

/// 1 / d with l_bits; 0 if d is below the smallest pivot
std::int64_t pivot_inverse(std::int64_t d) {
    return d < pivot_min ? 0 : divide_shifted(std::int64_t{1} << k_bits, d, l_bits);
}

/// Scales to mantissas of 30 bits with a common shift.
Inverse with_common_shift(const std::int64_t m[6], int fraction_bits) {
    std::uint64_t any = 0;
    for (int i = 0; i < 6; ++i) any |= magnitude(m[i]);
    if (any == 0) return {};
    const int drop = bit_length(any) - 30;
    Inverse inverse{};
    inverse.shift = fraction_bits - drop;
    for (int i = 0; i < 6; ++i) inverse.m[i] = static_cast<std::int32_t>(shifted(m[i], drop));
    return inverse;
}

} // namespace

std::int64_t turning_product(const Row& j, const Row& r) {
    std::int64_t a = 0, b = 0;
    for (int i = 3; i < 6; ++i) {
        a += std::int64_t{j.ja[i]} * r.ra[i];
        b += std::int64_t{j.jb[i]} * r.rb[i];
    }
    return shifted(a, 8 + r.shift_a) + shifted(b, 8 + r.shift_b);
}

Inverse invert_mobility(std::int64_t k) {
    if (k <= 0) return {};
    const int up = 62 - bit_length(magnitude(k));
    const std::int64_t normal = k << up;                             // [2^61, 2^62)
    const std::int64_t q = (std::int64_t{1} << 62) / (normal >> 30); // 2^62 / [2^31, 2^32) = (2^30, 2^31]
    Inverse inverse{};
    inverse.m[0] = static_cast<std::int32_t>(q >> 1);
    // 1 / (k 2^-48) = 2^(48 + up) / normal = 2^(48 + up) q / 2^92, and q = 2 m
    inverse.shift = 92 - 48 - up - 1;
    return inverse;
}

static Stiffness stiffness(const Row* rows, int count) {
    Stiffness s{};
    for (int i = 0; i < count; ++i) {
        for (int j = 0; j <= i; ++j) s.k[i][j] = product(rows[i], rows[j]);
        s.largest = std::max(s.largest, s.k[i][i]);
    }
    return s;
}

/// k = L D L^T, for parts that can hardly move in some direction. source: Golub, Van Loan, Matrix Computations, 4.1
static Inverse invert_by_pivots(Stiffness s, int count) {
    auto& k = s.k;
    const int drop = bit_length(magnitude(s.largest)) - k_bits;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j <= i; ++j) k[i][j] = shifted(k[i][j], drop);
    std::int64_t d_inv[3] = {}, l[3][3] = {};
    for (int j = 0; j < count; ++j) {
        std::int64_t d = k[j][j];
        for (int c = 0; c < j; ++c) d -= mul(l[j][c], k[j][c], l_bits);
        d_inv[j] = pivot_inverse(d);
        for (int i = j + 1; i < count; ++i) {
            for (int c = 0; c < j; ++c) k[i][j] -= mul(l[j][c], k[i][c], l_bits);
            l[i][j] = mul(k[i][j], d_inv[j], k_bits);
        }
    }
    // M = L^-1, inverse = M^T D^-1 M
    const std::int64_t one = std::int64_t{1} << l_bits;
    const std::int64_t m[3][3] = {
        {one, 0, 0}, {-l[1][0], one, 0}, {mul(l[2][1], l[1][0], l_bits) - l[2][0], -l[2][1], one}};
    std::int64_t out[6] = {};
    for (int i = 0; i < count; ++i)
        for (int j = 0; j <= i; ++j)
            for (int c = i; c < count; ++c)
                out[inverse_index[i][j]] = add_saturated(
                    out[inverse_index[i][j]], mul(mul(m[c][i], m[c][j], l_bits), d_inv[c], l_bits));
    // 1 / (k 2^drop) in units of 2^(48 - k_bits)
    return with_common_shift(out, l_bits + drop - (48 - k_bits));
}

/// adjugate / determinant, both with 62 fraction bits, of k 2^(17 - drop); the determinant is at least 2^-18
static Inverse quotient(const std::int64_t adjugate[6], std::int64_t determinant, int drop) {
    const int length = bit_length(magnitude(determinant));
    const std::uint64_t q = // in (2^31, 2^32]
        (std::uint64_t{1} << 63) / (static_cast<std::uint64_t>(determinant) >> (length - 32));
    const std::int64_t half_q = static_cast<std::int64_t>(q >> 1);
    std::uint64_t any = 0;
    for (int i = 0; i < 6; ++i) any |= magnitude(adjugate[i]);
    const int top = bit_length(any), cut = top - 31;
    Inverse inverse{};
    inverse.shift = length - top + 12 + drop;
    for (int i = 0; i < 6; ++i) // 31 bits times 31 bits
        inverse.m[i] = static_cast<std::int32_t>(shift_right_rounded(shifted(adjugate[i], cut) * half_q, 32));
    return inverse;
}

std::int64_t mobility(const Row& row) { return product(row, row); }

Inverse invert(const Row* rows, int count) {
    if (count == 1) return invert_mobility(product(rows[0], rows[0]));
    return invert(stiffness(rows, count), count);
}

Inverse invert_turning(const Row* rows, int count) {
    if (count == 1) return invert_mobility(turning_product(rows[0], rows[0]));
    Stiffness s{};
    for (int i = 0; i < count; ++i) {
        for (int j = 0; j <= i; ++j) s.k[i][j] = turning_product(rows[i], rows[j]);
        s.largest = std::max(s.largest, s.k[i][i]);
    }
    return invert(s, count);
}

Inverse invert(const Stiffness& s, int count) {
    if (s.largest == 0) return {};
    // Cramer's rule on 31 bits, if the determinant is large enough to keep most of them.
    constexpr std::int64_t determinant_min = std::int64_t{1} << 44;
    const int drop = bit_length(magnitude(s.largest)) - 31;
    const std::int64_t a = shifted(s.k[0][0], drop), b = shifted(s.k[1][0], drop),
                       c = shifted(s.k[1][1], drop);
    if (count == 2) {
        const std::int64_t adjugate[6] = {c << 31, -b * (std::int64_t{1} << 31), a << 31, 0, 0, 0};
        const std::int64_t determinant = a * c - b * b;
        return determinant >= determinant_min ? quotient(adjugate, determinant, drop)
                                              : invert_by_pivots(s, count);
    }
    const std::int64_t d = shifted(s.k[2][0], drop), e = shifted(s.k[2][1], drop),
                       f = shifted(s.k[2][2], drop);
    const std::int64_t adjugate[6] = {c * f - e * e, d * e - b * f, a * f - d * d,
                                      b * e - c * d, b * d - a * e, a * c - b * b};
    const Wide sum =
        Wide::product(a, adjugate[0]) + Wide::product(b, adjugate[1]) + Wide::product(d, adjugate[3]);
    const std::int64_t determinant = narrow_rounded(sum, 31);
    return determinant >= determinant_min ? quotient(adjugate, determinant, drop)
                                          : invert_by_pivots(s, count);
}

} // namespace lockstone::solve
