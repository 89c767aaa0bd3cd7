// Small matrices as block floating point: 61-bit integers with one common power of two, so masses of grams and of
// kilotons keep their digits until the one rounding at the end.
#include "math/elementary.h"

#include <algorithm>
#include <utility>

namespace lockstone {
namespace {

using Integers3x3 = std::array<std::array<std::int64_t, 3>, 3>; // [column][row]

/// v * 2^shift; right shifts are rounded.
std::int64_t shifted(std::int64_t v, int shift) {
    return shift >= 0 ? v * (std::int64_t{1} << shift) : shift_right_rounded(v, -shift);
}
std::int64_t shifted(Wide v, int shift) {
    return shift >= 0 ? static_cast<std::int64_t>((v << shift).low_bits()) : narrow_rounded(v, -shift);
}

int bit_length_of(Wide v) {
    if (v.is_negative()) v = Wide::from(0) - v;
    return v.high_bits() != 0 ? 64 + bit_length(static_cast<std::uint64_t>(v.high_bits()))
                              : bit_length(v.low_bits());
}

struct Scaled3x3 {
    Integers3x3 m;
    int shift; ///< m = raw * 2^shift
};

/// Scales the matrix so that its largest entry has `bits` bits.
Scaled3x3 scaled_to(const Mat3& a, int bits) {
    std::uint64_t all = 0;
    for (const Vec3& c : {a.x, a.y, a.z}) all |= magnitude(c.x.raw) | magnitude(c.y.raw) | magnitude(c.z.raw);
    Scaled3x3 s{{}, all == 0 ? 0 : bits - bit_length(all)};
    const auto column = [&](Vec3 c) {
        return std::array{shifted(c.x.raw, s.shift), shifted(c.y.raw, s.shift), shifted(c.z.raw, s.shift)};
    };
    s.m = {column(a.x), column(a.y), column(a.z)};
    return s;
}

struct Adjugate {
    Integers3x3 cofactors; ///< m^-1 = transpose of (cofactors by columns) / determinant
    int shift;             ///< cofactors = exact cofactors of the scaled matrix * 2^shift
    Wide determinant;      ///< of the scaled matrix * 2^shift
};

Adjugate adjugate(const Integers3x3& m) {
    std::array<std::array<Wide, 3>, 3> exact{};
    int bits = 0;
    for (std::size_t i = 0; i < 3; ++i) { // column i: the cross product of the other two columns
        const auto &a = m[(i + 1) % 3], &b = m[(i + 2) % 3];
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t k = (j + 1) % 3, l = (j + 2) % 3;
            exact[i][j] = Wide::product(a[k], b[l]) - Wide::product(a[l], b[k]);
            bits = std::max(bits, bit_length_of(exact[i][j]));
        }
    }
    Adjugate result{{}, 61 - bits, Wide::from(0)};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) result.cofactors[i][j] = shifted(exact[i][j], result.shift);
    for (std::size_t j = 0; j < 3; ++j)
        result.determinant = result.determinant + Wide::product(m[0][j], result.cofactors[0][j]);
    return result;
}

/// w * 2^shift as a Real's raw value, for any shift.
std::int64_t narrowed(Wide w, int shift) {
    if (w == Wide::from(0)) return 0;
    if (shift > 126 - bit_length_of(w)) return w.is_negative() ? Real::min().raw : Real::max().raw;
    if (shift >= 0) return saturate_to_int64(w << shift);
    return shift < -126 ? 0 : narrow_rounded(w, -shift);
}

} // namespace

Real determinant(const Mat3& a) {
    const Scaled3x3 s = scaled_to(a, 61);
    const Adjugate adj = adjugate(s.m);
    if (adj.determinant == Wide::from(0)) return Real{};
    return Real::from_raw(narrowed(adj.determinant, -(3 * s.shift + adj.shift) - 2 * Real::fraction_bits));
}

Mat3 inverse(const Mat3& a) {
    const Scaled3x3 s = scaled_to(a, 61);
    const Adjugate adj = adjugate(s.m);
    if (adj.determinant == Wide::from(0)) return Mat3{};
    const int drop = bit_length_of(adj.determinant) - 62; // the determinant in 62 bits
    const std::int64_t determinant = shifted(adj.determinant, -drop);
    // entry = cofactor / determinant * 2^up, first with 62 more bits of quotient than the cofactor has.
    const int up = s.shift - drop + 2 * Real::fraction_bits;
    const auto entry = [&](std::size_t i, std::size_t j) {
        const std::int64_t cofactor = adj.cofactors[i][j];
        if (up >= 0 && up <= 63) return Real::from_raw(divide_shifted(cofactor, determinant, up));
        if (up < 0)
            return Real::from_raw(
                -up > 62 ? 0 : shift_right_rounded(divide_shifted(cofactor, determinant, 0), -up));
        return Real::from_raw(narrowed(Wide::from(divide_shifted(cofactor, determinant, 62)), up - 62));
    };
    return {{entry(0, 0), entry(1, 0), entry(2, 0)},
            {entry(0, 1), entry(1, 1), entry(2, 1)},
            {entry(0, 2), entry(1, 2), entry(2, 2)}};
}

namespace {

struct Turn {
    std::int64_t tangent, cosine, sine; ///< 62 fraction bits
};

/// The turn of at most 45 degrees that clears the off-diagonal entry b of [[a, b], [b, c]].
/// source: Golub and Van Loan, Matrix Computations, 8.5.2.
Turn clearing(std::int64_t a, std::int64_t b, std::int64_t c) {
    const auto root = [](Wide n) { return static_cast<std::int64_t>(isqrt(n)); };
    const std::int64_t d = c - a, one = std::int64_t{1} << 62;
    const std::int64_t md = d < 0 ? -d : d;
    const std::int64_t hypotenuse = root(Wide::product(d, d) + Wide::product(2 * b, 2 * b));
    const std::int64_t tangent = divide_shifted(d < 0 ? -2 * b : 2 * b, md + hypotenuse, 62);
    const std::int64_t secant = root((Wide::from(1) << 124) + Wide::product(tangent, tangent));
    const std::int64_t cosine = divide_shifted(one, secant, 62);
    return {tangent, cosine, detail::mul62(tangent, cosine)};
}

/// Rotates the columns p and q by t.
void turn_columns(Integers3x3& m, std::size_t p, std::size_t q, const Turn& t) {
    for (std::size_t r = 0; r < 3; ++r) {
        const std::int64_t a = m[p][r], b = m[q][r];
        m[p][r] = narrow_rounded(Wide::product(t.cosine, a) - Wide::product(t.sine, b), 62);
        m[q][r] = narrow_rounded(Wide::product(t.sine, a) + Wide::product(t.cosine, b), 62);
    }
}

} // namespace

// Jacobi's method, cyclic by rows. It converges quadratically: seven sweeps clear 58 bits with two to spare.
Diagonal diagonalize(const Mat3& symmetric) {
    constexpr int sweeps = 10, bits = 58;
    Mat3 a = symmetric;
    a.x.y = a.y.x, a.x.z = a.z.x, a.y.z = a.z.y; // only the upper triangle of the input counts
    // A diagonal matrix needs no turn, and its values are exact if the scale would shift no bit out.
    const std::uint64_t all = magnitude(a.x.x.raw) | magnitude(a.y.y.raw) | magnitude(a.z.z.raw);
    if ((a.y.x.raw | a.z.x.raw | a.z.y.raw) == 0 && (all >> bits) == 0)
        return {{a.x.x, a.y.y, a.z.z}, Quat::identity()};
    const Scaled3x3 s = scaled_to(a, bits);
    Integers3x3 m = s.m;
    const std::int64_t one = std::int64_t{1} << 60;
    Integers3x3 axes = {{{one, 0, 0}, {0, one, 0}, {0, 0, one}}};
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (const auto& [p, q] : {std::pair<std::size_t, std::size_t>{0, 1}, {0, 2}, {1, 2}}) {
            const std::int64_t b = m[q][p];
            if (b == 0) continue;
            const Turn t = clearing(m[p][p], b, m[q][q]);
            const std::int64_t change = detail::mul62(t.tangent, b);
            m[p][p] -= change;
            m[q][q] += change;
            m[p][q] = m[q][p] = 0;
            const std::size_t r = 3 - p - q;
            const std::int64_t rp = m[p][r], rq = m[q][r];
            m[p][r] = m[r][p] = narrow_rounded(Wide::product(t.cosine, rp) - Wide::product(t.sine, rq), 62);
            m[q][r] = m[r][q] = narrow_rounded(Wide::product(t.sine, rp) + Wide::product(t.cosine, rq), 62);
            turn_columns(axes, p, q, t);
        }
    }
    const auto column = [](const std::array<std::int64_t, 3>& c) {
        return UnitVec3{round_from<Unit>(c[0], 60), round_from<Unit>(c[1], 60), round_from<Unit>(c[2], 60)};
    };
    const auto value = [&](std::size_t i) { return Real::from_raw(narrowed(Wide::from(m[i][i]), -s.shift)); };
    return {{value(0), value(1), value(2)},
            from_rotation({column(axes[0]), column(axes[1]), column(axes[2])})};
}

} // namespace lockstone
