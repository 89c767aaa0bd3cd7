// Argument reduction by tables, then short Taylor series with integer coefficients; one rounding at the end.
#include "math/elementary.h"

#include "math/tables.h"

namespace lockstone {
namespace detail {
namespace {

constexpr std::int64_t one = std::int64_t{1} << 62;

constexpr std::int64_t low_half(Wide w) { return static_cast<std::int64_t>(w.low_bits()); }

constexpr std::int64_t factorial(int n) { return n <= 1 ? 1 : n * factorial(n - 1); }

/// c[0] - z (c[1] - z (c[2] - ...))
template <std::size_t N>
constexpr std::int64_t alternating(const std::array<std::int64_t, N>& c, std::int64_t z) {
    std::int64_t sum = c[N - 1];
    for (std::size_t i = N - 1; i-- > 0;) sum = c[i] - mul62(z, sum);
    return sum;
}

// 1/1!, 1/3!, .. 1/15! and 1/0!, 1/2!, .. 1/16!: the remaining terms are below 2^-54.
constexpr std::array<std::int64_t, 8> sin_series = [] {
    std::array<std::int64_t, 8> c{};
    for (int i = 0; i < 8; ++i) c[static_cast<std::size_t>(i)] = one / factorial(2 * i + 1);
    return c;
}();
constexpr std::array<std::int64_t, 9> cos_series = [] {
    std::array<std::int64_t, 9> c{};
    for (int i = 0; i < 9; ++i) c[static_cast<std::size_t>(i)] = one / factorial(2 * i);
    return c;
}();
constexpr std::array<std::int64_t, 6> atan_series = {one, one / 3, one / 5, one / 7, one / 9, one / 11};

/// 2^(n / 16) e^r for |r| <= ln(2) / 32 with 62 fraction bits, rounded into a Real.
Real exp_from(std::int64_t n, std::int64_t r) {
    std::int64_t series = one / factorial(8); // (e^r - 1) / r
    for (int k = 7; k >= 1; --k) series = one / factorial(k) + mul62(r, series);
    const std::int64_t scale = table::exp2_16ths[n & 15];
    const std::int64_t m = scale + mul62(scale, mul62(r, series));
    const std::int64_t shift = (n >> 4) + Real::fraction_bits - 62;
    if (shift >= 0) return Real::from_raw(shift_left_saturated(m, static_cast<int>(shift > 62 ? 62 : shift)));
    if (shift < -63) return Real{};
    return Real::from_raw(shift_right_rounded(m, static_cast<int>(-shift)));
}

/// x = 2^exponent e^ln, |ln| <= ln(2) / 2 with 62 fraction bits.
struct Logarithm {
    int exponent;
    std::int64_t ln;
};
/// Needs raw > 0; raw counts steps of a Real.
Logarithm logarithm(std::uint64_t raw) {
    const int bits = bit_length(raw);
    std::uint64_t m = bits > 63 ? raw >> 1 : raw << (63 - bits); // in [1, 2) with 62 fraction bits
    int exponent = bits - 1 - Real::fraction_bits, fraction_bits = 62;
    if (m >= static_cast<std::uint64_t>(table::sqrt2))
        fraction_bits = 63, ++exponent; // in [sqrt(1/2), sqrt(2))
    // ln m = ln c + 2 atanh((m - c) / (m + c)) with c = i / 32 nearest to m; h is twice the quotient.
    const std::uint64_t i = ((m >> (fraction_bits - 6)) + 1) >> 1, c = i << (fraction_bits - 5);
    const std::int64_t difference = static_cast<std::int64_t>(m - c);
    const std::int64_t h = divide_shifted(difference, static_cast<std::int64_t>((m >> 1) + (c >> 1)), 62);
    const std::int64_t z = mul62(h, h);
    std::int64_t series = one / 448 + mul62(z, one / 2304);
    series = one / 12 + mul62(z, one / 80 + mul62(z, series));
    return {exponent, table::ln_32nds[i - table::ln_32nds_first] + h + mul62(mul62(h, z), series)};
}

} // namespace

SinCos62 sin_cos_62(std::int64_t raw, int fraction_bits) {
    // raw = quadrant * pi / 2 + r with |r| <= pi / 4; pi / 2 has 124 bits.
    const std::int64_t quadrant = narrow_rounded(Wide::product(raw, table::two_over_pi), 62 + fraction_bits);
    const std::int64_t r =
        low_half((Wide::from(raw) << (62 - fraction_bits)) - Wide::product(quadrant, table::half_pi) -
                 (Wide::product(quadrant, table::half_pi_rest) >> 62));
    const std::int64_t z = mul62(r, r);
    const std::int64_t s = mul62(r, alternating(sin_series, z)), c = alternating(cos_series, z);
    switch (quadrant & 3) {
    case 0:
        return {s, c};
    case 1:
        return {c, -s};
    case 2:
        return {-s, -c};
    default:
        return {-c, s};
    }
}

std::int64_t atan2_60(std::int64_t y, std::int64_t x) {
    const std::uint64_t my = magnitude(y), mx = magnitude(x);
    const bool steep = my > mx;
    std::uint64_t den = steep ? my : mx, num = steep ? mx : my;
    if (den == 0) return 0;
    const int shift = 58 - bit_length(den);
    den = shift >= 0 ? den << shift : den >> -shift;
    num = shift >= 0 ? num << shift : num >> -shift;
    // atan(t) = atan(i/16) + atan((16 t - i) / (16 + i t)), with i nearest to 16 t.
    const std::uint64_t i = (16 * num + den / 2) / den;
    const std::int64_t u = divide_shifted(static_cast<std::int64_t>(16 * num - i * den),
                                          static_cast<std::int64_t>(16 * den + i * num), 62);
    std::int64_t angle = table::atan_16ths[i] + mul62(u, alternating(atan_series, mul62(u, u)));
    if (steep) angle = table::half_pi - angle;
    angle = shift_right_rounded(angle, 2);
    if (x < 0) angle = (table::half_pi >> 1) - angle;
    return y < 0 ? -angle : angle;
}

} // namespace detail

SinCos sin_cos(Real radians) {
    const detail::SinCos62 t = detail::sin_cos_62(radians.raw, Real::fraction_bits);
    return {round_from<Unit>(t.sin, 62), round_from<Unit>(t.cos, 62)};
}
Real sin(Real radians) {
    return round_from<Real>(detail::sin_cos_62(radians.raw, Real::fraction_bits).sin, 62);
}
Real cos(Real radians) {
    return round_from<Real>(detail::sin_cos_62(radians.raw, Real::fraction_bits).cos, 62);
}
Real tan(Real radians) {
    const detail::SinCos62 t = detail::sin_cos_62(radians.raw, Real::fraction_bits);
    return Real::from_raw(divide_shifted(t.sin, t.cos, Real::fraction_bits));
}

Real atan2(Real y, Real x) { return round_from<Real>(detail::atan2_60(y.raw, x.raw), 60); }
Real atan(Real x) { return atan2(x, Real(1)); }

namespace {
/// sqrt(1 - x^2) with 60 fraction bits, for |x| <= 1: exact until the root.
std::int64_t cosine_of_arcsine(Real x) {
    const std::int64_t unit = Real(1).raw;
    const Wide n = Wide::product(unit - x.raw, unit + x.raw) << 56;
    return static_cast<std::int64_t>(isqrt(n));
}
} // namespace

Real asin(Real x) {
    const Real c = clamp(x, Real(-1), Real(1));
    return round_from<Real>(detail::atan2_60(c.raw * (1 << 28), cosine_of_arcsine(c)), 60);
}
Real acos(Real x) {
    const Real c = clamp(x, Real(-1), Real(1));
    return round_from<Real>(detail::atan2_60(cosine_of_arcsine(c), c.raw * (1 << 28)), 60);
}

Real exp(Real x) {
    namespace table = detail::table;
    if (x >= Real(22)) return Real::max();
    if (x <= Real(-24)) return Real{};
    const std::int64_t n = narrow_rounded(Wide::product(x.raw, table::log2_e), 62 + Real::fraction_bits - 4);
    const Wide r = (Wide::from(x.raw) << (62 - Real::fraction_bits)) - Wide::product(n, table::ln2_16th) -
                   (Wide::product(n, table::ln2_16th_rest) >> 62);
    return detail::exp_from(n, detail::low_half(r));
}

Real exp2(Real x) {
    if (x >= Real(31)) return Real::max();
    if (x <= Real(-34)) return Real{};
    constexpr int sixteenth = Real::fraction_bits - 4;
    const std::int64_t n = shift_right_rounded(x.raw, sixteenth);
    const std::int64_t rest = (x.raw - n * (std::int64_t{1} << sixteenth)) * (std::int64_t{1} << 30);
    return detail::exp_from(n, detail::mul62(rest, detail::table::ln2));
}

Real log(Real x) {
    if (x.raw <= 0) return Real::min();
    const detail::Logarithm l = detail::logarithm(static_cast<std::uint64_t>(x.raw));
    return round_from<Real>(Wide::product(l.exponent, detail::table::ln2) + Wide::from(l.ln), 62);
}

Real log2(Real x) {
    if (x.raw <= 0) return Real::min();
    const detail::Logarithm l = detail::logarithm(static_cast<std::uint64_t>(x.raw));
    return round_from<Real>(
        (Wide::from(l.exponent) << 62) + Wide::from(detail::mul62(l.ln, detail::table::log2_e)), 62);
}

namespace {
/// (raw / 2^32)^y for raw > 0.
Real pow_positive(std::uint64_t raw, Real y) {
    namespace table = detail::table;
    const detail::Logarithm l = detail::logarithm(raw);
    // With an exponent, |log2 x| is at least 1/2, so such a y is out of range already; below it, all products fit.
    if (l.exponent != 0 && (y >= Real(256) || y <= Real(-256)))
        return (l.exponent > 0) == (y.raw > 0) ? Real::max() : Real{};
    const std::int64_t fraction = detail::mul62(l.ln, table::log2_e);
    const Wide p =
        (Wide::product(y.raw, l.exponent) << 62) + Wide::product(y.raw, fraction); // y log2(x), 94 bits
    const std::int64_t whole = narrow_rounded(p, 94);
    if (whole >= 32) return Real::max();
    if (whole <= -35) return Real{};
    const std::int64_t n = narrow_rounded(p, 90);
    const std::int64_t rest = detail::low_half((p - (Wide::from(n) << 90)) >> 32);
    return detail::exp_from(n, detail::mul62(rest, table::ln2));
}
} // namespace

Real pow(Real x, Real y) {
    if (y.raw == 0) return Real(1);
    if (x.raw == 0) return y.raw > 0 ? Real{} : Real::max();
    if (x.raw > 0) return pow_positive(static_cast<std::uint64_t>(x.raw), y);
    if (y != floor(y)) return Real{};
    const Real p = pow_positive(magnitude(x.raw), y);
    return (floor_to_int(y) & 1) != 0 ? -p : p;
}

} // namespace lockstone
