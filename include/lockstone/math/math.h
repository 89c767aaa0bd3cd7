// Roots, lengths, unit vectors, elementary functions, rotations and small matrices, all in integers.
//
// Each result is defined by mathematics and one rounding, so it is equal on every machine. A hardware
// estimate may speed up a root (src/math/estimate.h); exact integer arithmetic then corrects it. Namespace
// error_bound has the error bounds; tests check them. All functions are pure and thread-safe.
#pragma once

#include "lockstone/math/vec.h"

#include <array>
#include <type_traits>

namespace lockstone {

/// Maximum errors of results, in 1/1000 of a step of their format. Correct rounding has 500.
namespace error_bound {
inline constexpr int sqrt = 500;         ///< sqrt
inline constexpr int length = 500;       ///< length
inline constexpr int inv_sqrt = 501;     ///< inv_sqrt; besides the relative part below
inline constexpr int normalized = 501;   ///< each component of normalized, for any non-zero vector
inline constexpr int sin_cos = 501;      ///< sin, cos and sin_cos, for every Real
inline constexpr int tan = 510;          ///< while |result| < 4096; see tan_relative_bits
inline constexpr int atan = 501;         ///< atan, atan2, asin, acos
inline constexpr int log = 501;          ///< log and log2
inline constexpr int exp = 501;          ///< exp and exp2; besides the relative part below
inline constexpr int rotation = 1500;    ///< each component of a quaternion from a function below
inline constexpr int determinant = 2000; ///< determinant; besides the relative part below
inline constexpr int inverse = 3000;     ///< inverse, Frobenius norm; besides the relative part below

// Relative parts of errors, as powers of two.
inline constexpr int inv_sqrt_relative_bits = 60; ///< result * 2^-60: relevant above 2^50 steps
inline constexpr int exp_relative_bits = 59; ///< exp, exp2, pow: result * 2^-59, for pow times max(1, |y|)
inline constexpr int tan_relative_bits = 60; ///< result^2 * 2^-60
inline constexpr int determinant_relative_bits = 58; ///< |m|^3 * 2^-58
inline constexpr int inverse_relative_bits = 56;     ///< |inverse| * condition number * 2^-56
inline constexpr int eigenvalue_relative_bits = 54;  ///< |m| * 2^-54, and a step of Real
} // namespace error_bound

// ---- roots ------------------------------------------------------------------------------------------------

namespace detail {

/// floor(sqrt(n)) with integers only: isqrt_estimated() for compile time and for targets without a
/// floating-point unit. Each line doubles the number of correct bits. Source: M. Dickinson, the integer
/// square root of CPython's math module.
constexpr std::uint64_t isqrt_integer(std::uint64_t n) {
    if (n == 0) return 0;
    const int shift = std::countl_zero(n) & ~1;
    const std::uint64_t m = n << shift;
    std::uint64_t u = 1 + (m >> 62);
    u = (u << 1) + (m >> 59) / u;
    u = (u << 3) + (m >> 53) / u;
    u = (u << 7) + (m >> 41) / u;
    u = (u << 15) + (m >> 17) / u;
    const std::uint64_t root = u >> (shift / 2);
    return root > 0xffffffffu || root * root > n ? root - 1 : root;
}

/// The root of 128 bits from the root of the leading 64 bits and one division. Source: P. Zimmermann,
/// Karatsuba Square Root, 1999.
template <class Root> constexpr std::uint64_t isqrt_128(std::uint64_t high, std::uint64_t low, Root root) {
    if (high == 0) return root(low);
    const int shift = std::countl_zero(high) & ~1;
    const std::uint64_t h = shift == 0 ? high : (high << shift) | (low >> (64 - shift)), l = low << shift;
    const std::uint64_t s1 = root(h), r1 = h - s1 * s1;
    const std::uint64_t q = ((r1 << 31) + (l >> 33)) / s1;
    std::uint64_t s = (s1 << 32) + (q > 0xffffffffu ? 0xffffffffu : q);
    const Wide square = Wide::product_unsigned(s, s);
    const std::uint64_t square_high = static_cast<std::uint64_t>(square.high_bits());
    if (square_high > h || (square_high == h && square.low_bits() > l)) --s;
    return s >> (shift / 2);
}
constexpr std::uint64_t isqrt_integer(std::uint64_t high, std::uint64_t low) {
    return isqrt_128(high, low, [](std::uint64_t n) { return isqrt_integer(n); });
}

/// min(floor(2^63 / sqrt(n)), 2^32 - 1) for n in [2^62, 2^64), with integers only.
constexpr std::uint64_t inverse_root_integer(std::uint64_t n) {
    if (n == std::uint64_t{1} << 62) return 0xffffffffu;
    return isqrt_integer(divide_128_by_64(std::uint64_t{1} << 62, 0, n).quotient);
}

std::uint64_t isqrt_estimated(std::uint64_t n);
std::uint64_t isqrt_estimated(std::uint64_t high, std::uint64_t low);
std::uint64_t inverse_root_estimated(std::uint64_t n);

constexpr std::uint64_t isqrt(std::uint64_t high, std::uint64_t low) {
    if (std::is_constant_evaluated()) return isqrt_integer(high, low);
    return isqrt_estimated(high, low);
}

/// floor(sqrt(n) + 1/2) from floor(sqrt(n)).
constexpr std::uint64_t nearest_root(std::uint64_t high, std::uint64_t low, std::uint64_t root) {
    const Wide square = Wide::product_unsigned(root, root);
    const std::uint64_t rest = low - square.low_bits();
    const bool rest_is_wide =
        high - static_cast<std::uint64_t>(square.high_bits()) != (low < square.low_bits() ? 1u : 0u);
    return rest_is_wide || rest > root ? root + (root != ~std::uint64_t{0} ? 1u : 0u) : root;
}

/// 1 / sqrt(n) = mantissa * 2^(up - 125) to 61 bits, never above the exact value.
struct InverseRoot {
    std::int64_t mantissa; ///< in [2^61, 2^62]
    int up;                ///< in 0..63: sqrt(n) * 2^up is in [2^63, 2^64)
};

/// n = high * 2^64 + low, not zero.
constexpr InverseRoot inverse_root(std::uint64_t high, std::uint64_t low) {
    const bool wide = high != 0;
    const int zeros = std::countl_zero(wide ? high : low) & ~1;
    std::uint64_t n = (wide ? high : low) << zeros;
    if (wide && zeros != 0) n |= low >> (64 - zeros);
    std::uint64_t q = 0;
    if (std::is_constant_evaluated())
        q = inverse_root_integer(n);
    else
        q = inverse_root_estimated(n);
    // q has 32 bits; what is left, 2^126 - q^2 n, gives the next 30 by one Newton step q + q (left / 2^127).
    const Wide square = Wide::product_unsigned(q * q, n);
    const std::uint64_t left = (std::uint64_t{1} << 62) - static_cast<std::uint64_t>(square.high_bits()) -
                               (square.low_bits() != 0 ? 1u : 0u);
    const std::uint64_t next = (q * (left >> 1)) >> 32;
    return {static_cast<std::int64_t>((q << 30) + next), zeros / 2 + (wide ? 0 : 32)};
}

/// floor(m / sqrt(n) * 2^60), to 2^-59. Needs |m| <= sqrt(n).
constexpr std::int64_t scaled_to_60(std::int64_t m, InverseRoot r) {
    const std::int64_t m63 = r.up == 0 ? m >> 1 : m * (std::int64_t{1} << (r.up - 1));
    return Wide::product(m63, r.mantissa).high_bits();
}
/// m / sqrt(n) as a Unit.
constexpr Unit scaled_to_unit(std::int64_t m, InverseRoot r) {
    return Unit::from_raw(static_cast<std::int32_t>(((scaled_to_60(m, r) >> 29) + 1) >> 1));
}

/// x^2 + y^2 + z^2 of raw values, unsigned: at most 3 * 2^126.
struct SquareSum {
    std::uint64_t high, low;
};
template <FixedPoint T> constexpr SquareSum square_sum(Vector3<T> v) {
    if constexpr (sizeof(typename T::rep) == 4) {
        const std::int64_t x = v.x.raw, y = v.y.raw, z = v.z.raw;
        return {0, static_cast<std::uint64_t>(x * x) + static_cast<std::uint64_t>(y * y) +
                       static_cast<std::uint64_t>(z * z)};
    } else {
        const Wide sum = Wide::product(v.x.raw, v.x.raw) + Wide::product(v.y.raw, v.y.raw) +
                         Wide::product(v.z.raw, v.z.raw);
        return {static_cast<std::uint64_t>(sum.high_bits()), sum.low_bits()};
    }
}

/// The unit quaternion along four integers below 2^62; identity for four zeros.
constexpr Quat normalized_quat(std::int64_t x, std::int64_t y, std::int64_t z, std::int64_t w) {
    const Wide sum = Wide::product(x, x) + Wide::product(y, y) + Wide::product(z, z) + Wide::product(w, w);
    const std::uint64_t high = static_cast<std::uint64_t>(sum.high_bits()), low = sum.low_bits();
    if ((high | low) == 0) return Quat::identity();
    const InverseRoot r = inverse_root(high, low);
    return {scaled_to_unit(x, r), scaled_to_unit(y, r), scaled_to_unit(z, r), scaled_to_unit(w, r)};
}

} // namespace detail

/// floor(sqrt(n)), exact.
constexpr std::uint32_t isqrt(std::uint64_t n) {
    if (std::is_constant_evaluated()) return static_cast<std::uint32_t>(detail::isqrt_integer(n));
    return static_cast<std::uint32_t>(detail::isqrt_estimated(n));
}
/// floor(sqrt(n)), exact; 0 for a negative n.
constexpr std::uint64_t isqrt(Wide n) {
    if (n.is_negative()) return 0;
    return detail::isqrt(static_cast<std::uint64_t>(n.high_bits()), n.low_bits());
}

/// The square root, rounded to nearest (error_bound::sqrt); 0 for a negative x.
template <FixedPoint T> constexpr T sqrt(T x) {
    if (x.raw <= 0) return T{};
    const std::uint64_t raw = static_cast<std::uint64_t>(x.raw);
    if constexpr (sizeof(typename T::rep) == 4) {
        const std::uint64_t n = raw << T::fraction_bits, root = isqrt(n);
        return T::from_raw(
            saturate_to_int32(static_cast<std::int64_t>(n - root * root > root ? root + 1 : root)));
    } else {
        constexpr int f = T::fraction_bits;
        const std::uint64_t high = f == 0 ? 0 : raw >> (64 - f), low = raw << f;
        return T::from_raw(
            static_cast<std::int64_t>(detail::nearest_root(high, low, detail::isqrt(high, low))));
    }
}

/// 1 / sqrt(x); the largest value for x <= 0. error_bound::inv_sqrt + result * 2^-inv_sqrt_relative_bits.
template <FixedPoint T> constexpr T inv_sqrt(T x) {
    if (x.raw <= 0) return T::max();
    // Raw result = 2^(3f/2) / sqrt(raw); an odd 3f borrows a factor of two from raw.
    constexpr int odd = T::fraction_bits & 1;
    const std::uint64_t raw = static_cast<std::uint64_t>(x.raw);
    const detail::InverseRoot r = detail::inverse_root(odd != 0 ? raw >> 63 : 0, raw << odd);
    const int shift = 125 - r.up - (3 * T::fraction_bits + odd) / 2;
    const std::int64_t v =
        shift > 0 ? narrow_rounded(Wide::from(r.mantissa), shift) : shift_left_saturated(r.mantissa, -shift);
    if constexpr (sizeof(typename T::rep) == 8)
        return T::from_raw(v);
    else
        return T::from_raw(saturate_to_int32(v));
}

/// 1 / x, rounded once, clamped; the largest number for 0.
template <FixedPoint T> constexpr T reciprocal(T x) {
    static_assert(T::fraction_bits < 63, "1 is not within the 64 bits that the division starts from");
    if (x.raw == 0) return T::max();
    const std::int64_t q = divide_shifted(std::int64_t{1} << T::fraction_bits, x.raw, T::fraction_bits);
    if constexpr (sizeof(typename T::rep) == 8)
        return T::from_raw(q);
    else
        return T::from_raw(saturate_to_int32(q));
}

/// |v|, rounded to nearest (error_bound::length), clamped.
template <FixedPoint T> constexpr T length(Vector3<T> v) {
    const detail::SquareSum n = detail::square_sum(v);
    if constexpr (sizeof(typename T::rep) == 4) {
        const std::uint64_t root = isqrt(n.low);
        return T::from_raw(
            saturate_to_int32(static_cast<std::int64_t>(n.low - root * root > root ? root + 1 : root)));
    } else {
        const std::uint64_t root = detail::nearest_root(n.high, n.low, detail::isqrt(n.high, n.low));
        constexpr std::uint64_t largest = std::numeric_limits<std::int64_t>::max();
        return T::from_raw(static_cast<std::int64_t>(root > largest ? largest : root));
    }
}

/// |v|^2, rounded once to To, by default the format of v; clamped.
///@{
template <FixedPoint To, FixedPoint T> constexpr To length_squared(Vector3<T> v) { return dot<To>(v, v); }
template <FixedPoint T> constexpr T length_squared(Vector3<T> v) { return dot<T>(v, v); }
///@}

/// v / |v|, each component within error_bound::normalized for any length of v; `fallback` for v = 0.
template <FixedPoint T> constexpr UnitVec3 normalized_or(Vector3<T> v, UnitVec3 fallback) {
    const detail::SquareSum n = detail::square_sum(v);
    if ((n.high | n.low) == 0) return fallback;
    const detail::InverseRoot r = detail::inverse_root(n.high, n.low);
    return {detail::scaled_to_unit(v.x.raw, r), detail::scaled_to_unit(v.y.raw, r),
            detail::scaled_to_unit(v.z.raw, r)};
}
/// v / |v|; zero for v = 0.
template <FixedPoint T> constexpr UnitVec3 normalized(Vector3<T> v) { return normalized_or(v, UnitVec3{}); }

/// q / |q|; identity for the zero quaternion.
constexpr Quat normalized(Quat q) { return detail::normalized_quat(q.x.raw, q.y.raw, q.z.raw, q.w.raw); }

/// A unit vector perpendicular to n; continuous except where another component of n becomes the smallest.
constexpr UnitVec3 any_perpendicular(UnitVec3 n) {
    const UnitVec3 a = abs(n);
    if (a.x <= a.y && a.x <= a.z) return normalized(UnitVec3{Unit{}, -n.z, n.y});
    if (a.y <= a.z) return normalized(UnitVec3{n.z, Unit{}, -n.x});
    return normalized(UnitVec3{-n.y, n.x, Unit{}});
}

// ---- elementary functions ---------------------------------------------------------------------------------

inline constexpr Real pi = decimal<Real>("3.14159265358979323846264338327950288");      ///< pi
inline constexpr Real half_pi = decimal<Real>("1.57079632679489661923132169163975144"); ///< pi / 2
inline constexpr Real two_pi = decimal<Real>("6.28318530717958647692528676655900577");  ///< 2 pi
/// Constants with short names. A separate namespace, because local variables are often named e.
namespace constants {
/// Base of the natural logarithm.
inline constexpr Real e = decimal<Real>("2.71828182845904523536028747135266250");
} // namespace constants

/// Sine and cosine of one angle.
struct SinCos {
    Unit sin, ///< sine
        cos;  ///< cosine
};

/// Sine and cosine of any angle [rad]. error_bound::sin_cos.
///@{
SinCos sin_cos(Real radians);
Real sin(Real radians);
Real cos(Real radians);
///@}
/// Tangent of any angle [rad], clamped near the poles. error_bound::tan + result^2 * 2^-tan_relative_bits.
Real tan(Real radians);

/// The angle of the point (x, y) in [-pi, pi] [rad]; 0 for (0, 0). error_bound::atan.
Real atan2(Real y, Real x);
/// The arc tangent [rad]. error_bound::atan.
Real atan(Real x);
/// Arc sine and arc cosine [rad] of x, clamped to [-1, 1]. error_bound::atan.
///@{
Real asin(Real x);
Real acos(Real x);
///@}

/// e^x and 2^x, clamped. error_bound::exp + |result| * 2^-exp_relative_bits.
///@{
Real exp(Real x);
Real exp2(Real x);
///@}
/// Natural and binary logarithm; the most negative Real for x <= 0. error_bound::log.
///@{
Real log(Real x);
Real log2(Real x);
///@}
/// x^y, clamped. 0^0 is 1; 0^y is the largest Real for y < 0; 0 for a negative x unless y is an integer.
/// error_bound::exp + |result| * max(1, |y|) * 2^-exp_relative_bits.
Real pow(Real x, Real y);

// ---- rotations --------------------------------------------------------------------------------------------

/// A rotation by an angle about an axis.
struct AxisAngle {
    UnitVec3 axis; ///< of unit length
    Real angle;    ///< [rad], 0..pi
};

/// The rotation by `radians` about `axis`, right-handed. All quaternions below are normalised, and within
/// error_bound::rotation.
Quat from_axis_angle(UnitVec3 axis, Real radians);
/// Axis and angle of a rotation. The identity has the axis x.
AxisAngle to_axis_angle(Quat q);
/// The shortest rotation from direction a to direction b. For opposite directions: a half turn about
/// any_perpendicular(a).
Quat from_to(UnitVec3 a, UnitVec3 b);
/// The rotation about x by angles.x, then about y, then about z; fixed axes [rad].
Quat from_euler(Vec3 angles);
/// The quaternion of an orthonormal matrix.
Quat from_rotation(const Rotation& m);

/// Interpolates along the shorter arc at constant angular speed; t is clamped to [0, 1].
Quat slerp(Quat a, Quat b, Real t);
/// Interpolates along the shorter arc, faster, not at constant speed; t is clamped to [0, 1].
Quat nlerp(Quat a, Quat b, Real t);

namespace detail {
/// exp(v / 2) * q for a rotation vector with `fraction_bits`.
Quat integrate_rotation(Quat q, const std::array<std::int64_t, 3>& v, int fraction_bits);
} // namespace detail

/// q rotated by the world-frame rotation vector v [rad] (axis times angle) of any length: the exponential
/// map, renormalised, within error_bound::rotation. Small half angles are computed with 34 fraction bits and
/// rounded once.
template <FixedPoint T> Quat integrate_rotation(Quat q, Vector3<T> v) {
    return detail::integrate_rotation(q, {v.x.raw, v.y.raw, v.z.raw}, T::fraction_bits);
}

// ---- small matrices ---------------------------------------------------------------------------------------

/// The determinant, clamped. error_bound::determinant and determinant_relative_bits.
Real determinant(const Mat3& m);
/// The inverse matrix; zero for a singular one. error_bound::inverse and inverse_relative_bits.
Mat3 inverse(const Mat3& m);

/// A diagonalised matrix: m = R diag(values) R^T with R = to_rotation(axes).
struct Diagonal {
    Vec3 values; ///< eigenvalues
    Quat axes;   ///< eigenvectors
};
/// Eigenvalues (error_bound::eigenvalue_relative_bits) and eigenvectors of a symmetric matrix; only its upper
/// triangle is used. Each eigenvector is assigned to its nearest coordinate axis, so a diagonal matrix gives
/// the identity.
Diagonal diagonalize(const Mat3& symmetric);

} // namespace lockstone
