// Conversion to and from floating point, for rendering, sound, tools and tests. The simulation never includes
// this header.
#pragma once

#include "lockstone/math/vec.h"

#include <array>
#include <bit>

namespace lockstone {

/// The number as a double: exact for 32-bit formats and below 2^53 steps, else rounded once.
template <FixedPoint T> constexpr double to_double(T x) {
    return static_cast<double>(x.raw) * (1.0 / static_cast<double>(std::uint64_t{1} << T::fraction_bits));
}
/// The number as a float, rounded once.
template <FixedPoint T> constexpr float to_float(T x) {
    return static_cast<float>(x.raw) * (1.0f / static_cast<float>(std::uint64_t{1} << T::fraction_bits));
}

/// The nearest number of the format, ties to even, clamped; 0 for NaN. Works on the bits, so rounding modes
/// and -ffast-math have no effect.
template <FixedPoint T> constexpr T quantize(double value) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(value);
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52) - 1);
    const int exponent = static_cast<int>((bits >> 52) & 0x7ff);
    const bool negative = (bits >> 63) != 0;
    if (exponent == 0x7ff && fraction != 0) return T{};
    // |value| * 2^fraction_bits = m * 2^shift
    std::uint64_t m = exponent == 0 ? fraction : fraction | (std::uint64_t{1} << 52);
    const int shift = (exponent == 0 ? 1 : exponent) - 1075 + T::fraction_bits;
    if (shift > 10)
        m = m == 0 ? 0 : std::uint64_t{1} << 63;
    else if (shift >= 0)
        m <<= shift;
    else if (shift < -54)
        m = 0;
    else {
        const std::uint64_t half_bit = std::uint64_t{1} << (-shift - 1), rest = m & (2 * half_bit - 1);
        m >>= -shift;
        if (rest > half_bit || (rest == half_bit && (m & 1) != 0)) ++m;
    }
    constexpr std::uint64_t largest = static_cast<std::uint64_t>(T::max().raw);
    if (m > largest) return negative ? T::min() : T::max();
    const std::int64_t raw = static_cast<std::int64_t>(m);
    return T::from_raw(static_cast<typename T::rep>(negative ? -raw : raw));
}

/// {x, y, z} as to_double() and to_float() give them.
///@{
template <FixedPoint T> constexpr std::array<double, 3> to_double(Vector3<T> v) {
    return {to_double(v.x), to_double(v.y), to_double(v.z)};
}
template <FixedPoint T> constexpr std::array<float, 3> to_float(Vector3<T> v) {
    return {to_float(v.x), to_float(v.y), to_float(v.z)};
}
///@}
/// {x, y, z, w} as to_double() and to_float() give them.
///@{
constexpr std::array<double, 4> to_double(Quat q) {
    return {to_double(q.x), to_double(q.y), to_double(q.z), to_double(q.w)};
}
constexpr std::array<float, 4> to_float(Quat q) {
    return {to_float(q.x), to_float(q.y), to_float(q.z), to_float(q.w)};
}
///@}

/// quantize() of each component {x, y, z}.
///@{
template <FixedPoint T> constexpr Vector3<T> quantize(const std::array<double, 3>& v) {
    return {quantize<T>(v[0]), quantize<T>(v[1]), quantize<T>(v[2])};
}
template <FixedPoint T> constexpr Vector3<T> quantize(const std::array<float, 3>& v) {
    return {quantize<T>(double{v[0]}), quantize<T>(double{v[1]}), quantize<T>(double{v[2]})};
}
///@}
/// quantize() of each component {x, y, z, w}. Pass the result to normalized(Quat) before you use it as a
/// rotation.
constexpr Quat quantize_quat(const std::array<double, 4>& q) {
    return {quantize<Unit>(q[0]), quantize<Unit>(q[1]), quantize<Unit>(q[2]), quantize<Unit>(q[3])};
}

/// The matrix [4 x 4, column-major] of a pose, for graphics interfaces.
constexpr std::array<float, 16> to_float_matrix(const Transform& t) {
    const Rotation r = to_rotation(t.rotation);
    const std::array<float, 3> x = to_float(r.x), y = to_float(r.y), z = to_float(r.z),
                               p = to_float(t.position);
    return {x[0], x[1], x[2], 0, y[0], y[1], y[2], 0, z[0], z[1], z[2], 0, p[0], p[1], p[2], 1};
}

} // namespace lockstone
