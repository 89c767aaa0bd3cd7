// Vectors, quaternions and matrices of one build. The build defines the namespace and the number type, so that builds
// with different flags share no function.
#pragma once

#include "reference/engine/core.h"

#include <cmath>

#ifndef LOCKSTONE_REFERENCE_BUILD
#define LOCKSTONE_REFERENCE_BUILD double_plain
#define LOCKSTONE_REFERENCE_NUMBER double
#endif

namespace reference::LOCKSTONE_REFERENCE_BUILD {

using Number = LOCKSTONE_REFERENCE_NUMBER;

constexpr Number half = Number(1) / 2;

struct V3 {
    Number x{}, y{}, z{};

    friend V3 operator+(V3 a, V3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend V3 operator-(V3 a, V3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend V3 operator-(V3 a) { return {-a.x, -a.y, -a.z}; }
    friend V3 operator*(V3 a, Number s) { return {a.x * s, a.y * s, a.z * s}; }
    friend V3 operator*(Number s, V3 a) { return a * s; }
    V3& operator+=(V3 b) { return *this = *this + b; }
    V3& operator-=(V3 b) { return *this = *this - b; }
    V3& operator*=(Number s) { return *this = *this * s; }
};
inline Number dot(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline V3 cross(V3 a, V3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline Number length(V3 a) { return std::sqrt(dot(a, a)); }

/// A matrix of three columns.
struct M3 {
    V3 x, y, z;

    friend V3 operator*(const M3& m, V3 v) { return m.x * v.x + m.y * v.y + m.z * v.z; }
    friend M3 operator*(const M3& a, const M3& b) { return {a * b.x, a * b.y, a * b.z}; }
    friend M3 operator+(const M3& a, const M3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
};
inline M3 transpose(const M3& m) {
    return {{m.x.x, m.y.x, m.z.x}, {m.x.y, m.y.y, m.z.y}, {m.x.z, m.y.z, m.z.z}};
}
inline M3 diagonal(V3 d) { return {{d.x, 0, 0}, {0, d.y, 0}, {0, 0, d.z}}; }
/// skew(a) b = a x b.
inline M3 skew(V3 a) { return {{0, a.z, -a.y}, {-a.z, 0, a.x}, {a.y, -a.x, 0}}; }
/// Solves m x = b by Cramer's rule.
inline V3 solve(const M3& m, V3 b) {
    const V3 yz = cross(m.y, m.z);
    const Number d = dot(m.x, yz);
    return V3{dot(b, yz), dot(m.x, cross(b, m.z)), dot(m.x, cross(m.y, b))} * (1 / d);
}

struct Q4 {
    Number x{}, y{}, z{}, w = 1;

    friend Q4 operator+(Q4 a, Q4 b) { return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
    friend Q4 operator*(Q4 a, Number s) { return {a.x * s, a.y * s, a.z * s, a.w * s}; }
    friend Q4 operator*(Q4 a, Q4 b) {
        return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
    }
};
inline Q4 normalize(Q4 q) { return q * (1 / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)); }
/// The rate of change of q at angular velocity w: w q / 2.
inline Q4 rate_of(Q4 q, V3 w) { return Q4{w.x, w.y, w.z, 0} * q * half; }
inline M3 matrix_of(Q4 q) {
    const Number x = q.x + q.x, y = q.y + q.y, z = q.z + q.z;
    return {{1 - (q.y * y + q.z * z), q.x * y + q.w * z, q.x * z - q.w * y},
            {q.x * y - q.w * z, 1 - (q.x * x + q.z * z), q.y * z + q.w * x},
            {q.x * z + q.w * y, q.y * z - q.w * x, 1 - (q.x * x + q.y * y)}};
}

inline V3 in(const Vec& v) { return {Number(v.x), Number(v.y), Number(v.z)}; }
inline Q4 in(const Turn& q) { return {Number(q.x), Number(q.y), Number(q.z), Number(q.w)}; }
inline Vec out(V3 v) { return {double(v.x), double(v.y), double(v.z)}; }
inline Turn out(Q4 q) { return {double(q.x), double(q.y), double(q.z), double(q.w)}; }

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
