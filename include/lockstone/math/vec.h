// Vectors, quaternions and matrices of any fixed-point format. Each component of a result is rounded once,
// unless noted, and clamped. All functions are pure and thread-safe.
#pragma once

#include "lockstone/math/formats.h"

namespace lockstone {

/// A vector of three numbers.
template <FixedPoint T> struct Vector3 {
    using scalar = T; ///< format of the components
    T x,              ///< component 0
        y,            ///< component 1
        z;            ///< component 2

    /// Equal components.
    friend constexpr bool operator==(const Vector3&, const Vector3&) = default;
    /// The operation on each component.
    ///@{
    friend constexpr Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend constexpr Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend constexpr Vector3 operator-(Vector3 a) { return {-a.x, -a.y, -a.z}; }
    friend constexpr Vector3 operator*(Vector3 a, T s) { return {a.x * s, a.y * s, a.z * s}; }
    friend constexpr Vector3 operator*(T s, Vector3 a) { return a * s; }
    friend constexpr Vector3 operator/(Vector3 a, T s) { return {a.x / s, a.y / s, a.z / s}; }
    constexpr Vector3& operator+=(Vector3 b) { return *this = *this + b; }
    constexpr Vector3& operator-=(Vector3 b) { return *this = *this - b; }
    constexpr Vector3& operator*=(T s) { return *this = *this * s; }
    ///@}
    /// Component 0, 1 or 2; any other index is 2.
    ///@{
    constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr const T& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    ///@}
};

using Vec3 = Vector3<Real>;                 ///< public vector: positions, forces
using UnitVec3 = Vector3<Unit>;             ///< directions
using LengthVec3 = Vector3<Length>;         ///< sizes and vertices [m]
using CoordinateVec3 = Vector3<Coordinate>; ///< points of assets [m]
using SpeedVec3 = Vector3<Speed>;           ///< velocities

/// Converts each component to another format: rounded once, clamped.
template <FixedPoint To, FixedPoint From> constexpr Vector3<To> to(Vector3<From> v) {
    return {to<To>(v.x), to<To>(v.y), to<To>(v.z)};
}

/// Dot product, rounded once to To, by default the format of a.
///@{
template <FixedPoint To, FixedPoint A, FixedPoint B> constexpr To dot(Vector3<A> a, Vector3<B> b) {
    return SumOfProducts<A, B>{}.add(a.x, b.x).add(a.y, b.y).add(a.z, b.z).template round<To>();
}
template <FixedPoint T> constexpr T dot(Vector3<T> a, Vector3<T> b) { return dot<T, T, T>(a, b); }
///@}

/// Cross product, each component rounded once to To, by default the format of a.
///@{
template <FixedPoint To, FixedPoint A, FixedPoint B> constexpr Vector3<To> cross(Vector3<A> a, Vector3<B> b) {
    using Sum = SumOfProducts<A, B>;
    return {Sum{}.add(a.y, b.z).sub(a.z, b.y).template round<To>(),
            Sum{}.add(a.z, b.x).sub(a.x, b.z).template round<To>(),
            Sum{}.add(a.x, b.y).sub(a.y, b.x).template round<To>()};
}
template <FixedPoint T> constexpr Vector3<T> cross(Vector3<T> a, Vector3<T> b) {
    return cross<T, T, T>(a, b);
}
///@}

/// v * s, each component rounded once to To.
template <FixedPoint To, FixedPoint A, FixedPoint B> constexpr Vector3<To> scale(Vector3<A> v, B s) {
    return {mul<To>(v.x, s), mul<To>(v.y, s), mul<To>(v.z, s)};
}
/// The smaller one, the larger one, the absolute value of each component.
///@{
template <FixedPoint T> constexpr Vector3<T> min(Vector3<T> a, Vector3<T> b) {
    return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
}
template <FixedPoint T> constexpr Vector3<T> max(Vector3<T> a, Vector3<T> b) {
    return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
}
template <FixedPoint T> constexpr Vector3<T> abs(Vector3<T> v) { return {abs(v.x), abs(v.y), abs(v.z)}; }
///@}

/// A 3 x 3 matrix of three columns: m * v is m.x * v.x + m.y * v.y + m.z * v.z.
template <FixedPoint T> struct Matrix3 {
    Vector3<T> x, ///< column 0
        y,        ///< column 1
        z;        ///< column 2

    /// The matrix with these diagonal entries.
    static constexpr Matrix3 diagonal(T a, T b, T c) { return {{a, T{}, T{}}, {T{}, b, T{}}, {T{}, T{}, c}}; }
    /// The unit matrix.
    static constexpr Matrix3 identity() requires(T::integer_bits >= 2) { return diagonal(T(1), T(1), T(1)); }
    /// Equal entries.
    friend constexpr bool operator==(const Matrix3&, const Matrix3&) = default;
    /// The operation on each entry.
    ///@{
    friend constexpr Matrix3 operator+(const Matrix3& a, const Matrix3& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend constexpr Matrix3 operator-(const Matrix3& a, const Matrix3& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    ///@}
};

using Mat3 = Matrix3<Real>;     ///< public matrix
using Rotation = Matrix3<Unit>; ///< a rotation: orthonormal columns

/// The transposed matrix.
template <FixedPoint T> constexpr Matrix3<T> transpose(const Matrix3<T>& m) {
    return {{m.x.x, m.y.x, m.z.x}, {m.x.y, m.y.y, m.z.y}, {m.x.z, m.y.z, m.z.z}};
}
/// m v, each component rounded once to To.
template <FixedPoint To, FixedPoint A, FixedPoint B>
constexpr Vector3<To> mul(const Matrix3<A>& m, Vector3<B> v) {
    const Matrix3<A> t = transpose(m);
    return {dot<To>(t.x, v), dot<To>(t.y, v), dot<To>(t.z, v)};
}
/// m^T v, each component rounded once to To: the vector in the frame with the columns of m as axes.
template <FixedPoint To, FixedPoint A, FixedPoint B>
constexpr Vector3<To> mul_transposed(const Matrix3<A>& m, Vector3<B> v) {
    return {dot<To>(m.x, v), dot<To>(m.y, v), dot<To>(m.z, v)};
}
/// a b, each entry rounded once to To.
template <FixedPoint To, FixedPoint A, FixedPoint B>
constexpr Matrix3<To> mul(const Matrix3<A>& a, const Matrix3<B>& b) {
    return {mul<To>(a, b.x), mul<To>(a, b.y), mul<To>(a, b.z)};
}
/// a^T b, each entry rounded once to To.
template <FixedPoint To, FixedPoint A, FixedPoint B>
constexpr Matrix3<To> mul_transposed(const Matrix3<A>& a, const Matrix3<B>& b) {
    return {mul_transposed<To>(a, b.x), mul_transposed<To>(a, b.y), mul_transposed<To>(a, b.z)};
}
/// m v.
template <FixedPoint T> constexpr Vector3<T> operator*(const Matrix3<T>& m, Vector3<T> v) {
    return mul<T>(m, v);
}
/// a b.
template <FixedPoint T> constexpr Matrix3<T> operator*(const Matrix3<T>& a, const Matrix3<T>& b) {
    return mul<T>(a, b);
}

/// A rotation: unit quaternion w + xi + yj + zk.
struct Quat {
    Unit x, ///< i
        y,  ///< j
        z,  ///< k
        w;  ///< real part

    /// No rotation.
    static constexpr Quat identity() { return {Unit{}, Unit{}, Unit{}, unit_one}; }
    /// Equal components. q and -q are different, though they are one rotation.
    friend constexpr bool operator==(const Quat&, const Quat&) = default;
};

/// The inverse rotation of a unit quaternion.
constexpr Quat conjugate(Quat q) { return {-q.x, -q.y, -q.z, q.w}; }

/// The rotation b followed by a.
constexpr Quat operator*(Quat a, Quat b) {
    using Sum = SumOfProducts<Unit, Unit>;
    return {Sum{}.add(a.w, b.x).add(a.x, b.w).add(a.y, b.z).sub(a.z, b.y).round<Unit>(),
            Sum{}.add(a.w, b.y).sub(a.x, b.z).add(a.y, b.w).add(a.z, b.x).round<Unit>(),
            Sum{}.add(a.w, b.z).add(a.x, b.y).sub(a.y, b.x).add(a.z, b.w).round<Unit>(),
            Sum{}.add(a.w, b.w).sub(a.x, b.x).sub(a.y, b.y).sub(a.z, b.z).round<Unit>()};
}

/// The rotation matrix of a unit quaternion; each entry is rounded once.
constexpr Rotation to_rotation(Quat q) {
    using Sum = SumOfProducts<Unit, Unit>;
    // An off-diagonal entry is 2 * (sum of two products), so rounding drops one bit less. The diagonal
    // uses w^2 + x^2 - y^2 - z^2 in place of 1 - 2 (...): orthonormal to first order when |q| has a rounding
    // error.
    const std::int64_t x = q.x.raw, y = q.y.raw, z = q.z.raw, w = q.w.raw;
    const std::uint64_t xx = static_cast<std::uint64_t>(x * x), yy = static_cast<std::uint64_t>(y * y),
                        zz = static_cast<std::uint64_t>(z * z), ww = static_cast<std::uint64_t>(w * w);
    // Four squares of -2^31 add up to 2^64, which wraps to 0: not a rotation either.
    if (xx + yy + zz + ww - 1 < 3 * (std::uint64_t{1} << 59)) [[likely]] {
        // No entry is above |q|^2 <= 1.5, so no result below leaves its format.
        const auto once = [](std::uint64_t sum) {
            constexpr std::int64_t half = std::int64_t{1} << 29;
            return Unit::from_raw(static_cast<std::int32_t>((static_cast<std::int64_t>(sum) + half) >> 30));
        };
        const auto twice = [](std::int64_t sum) {
            constexpr std::int64_t half = std::int64_t{1} << 28;
            return Unit::from_raw(static_cast<std::int32_t>((sum + half) >> 29));
        };
        const std::int64_t xy = x * y, xz = x * z, yz = y * z, wx = w * x, wy = w * y, wz = w * z;
        return {{once(ww + xx - yy - zz), twice(xy + wz), twice(xz - wy)},
                {twice(xy - wz), once(ww - xx + yy - zz), twice(yz + wx)},
                {twice(xz + wy), twice(yz - wx), once(ww - xx - yy + zz)}};
    }
    const auto twice = [](Sum s) { return round_from<Unit>(s.exact(), 59); };
    const auto once = [](Sum s) { return s.round<Unit>(); };
    return {{once(Sum{}.add(q.w, q.w).add(q.x, q.x).sub(q.y, q.y).sub(q.z, q.z)),
             twice(Sum{}.add(q.x, q.y).add(q.w, q.z)), twice(Sum{}.add(q.x, q.z).sub(q.w, q.y))},
            {twice(Sum{}.add(q.x, q.y).sub(q.w, q.z)),
             once(Sum{}.add(q.w, q.w).sub(q.x, q.x).add(q.y, q.y).sub(q.z, q.z)),
             twice(Sum{}.add(q.y, q.z).add(q.w, q.x))},
            {twice(Sum{}.add(q.x, q.z).add(q.w, q.y)), twice(Sum{}.add(q.y, q.z).sub(q.w, q.x)),
             once(Sum{}.add(q.w, q.w).sub(q.x, q.x).sub(q.y, q.y).add(q.z, q.z))}};
}

/// v rotated by q.
template <FixedPoint T> constexpr Vector3<T> rotate(Quat q, Vector3<T> v) {
    return mul<T>(to_rotation(q), v);
}
/// v rotated by the inverse of q.
template <FixedPoint T> constexpr Vector3<T> rotate_inverse(Quat q, Vector3<T> v) {
    return mul_transposed<T>(to_rotation(q), v);
}

/// A rigid pose: x -> position + rotation x.
struct Transform {
    Vec3 position{};                  ///< [m]
    Quat rotation = Quat::identity(); ///< of unit length

    /// No translation, no rotation.
    static constexpr Transform identity() { return {Vec3{}, Quat::identity()}; }
    /// Equal components.
    friend constexpr bool operator==(const Transform&, const Transform&) = default;
};

/// The point p transformed by t.
constexpr Vec3 operator*(const Transform& t, Vec3 p) { return t.position + rotate(t.rotation, p); }
/// The transform b followed by a. After many products renormalise the rotation by normalized(Quat) of math.h.
constexpr Transform operator*(const Transform& a, const Transform& b) {
    return {a * b.position, a.rotation * b.rotation};
}
/// The point p transformed by the inverse of t.
constexpr Vec3 inverse_mul(const Transform& t, Vec3 p) { return rotate_inverse(t.rotation, p - t.position); }
/// The inverse transform.
constexpr Transform inverse(const Transform& t) {
    return {rotate_inverse(t.rotation, -t.position), conjugate(t.rotation)};
}

} // namespace lockstone
