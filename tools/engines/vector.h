// Vectors and quaternions in double precision, for scenes and measurements.
#pragma once

#include <cmath>

namespace engines {

struct V3 {
    double x = 0, y = 0, z = 0;

    friend V3 operator+(V3 a, V3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend V3 operator-(V3 a, V3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend V3 operator-(V3 a) { return {-a.x, -a.y, -a.z}; }
    friend V3 operator*(V3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
    friend V3 operator*(double s, V3 a) { return a * s; }
    friend V3 operator/(V3 a, double s) { return {a.x / s, a.y / s, a.z / s}; }
    V3& operator+=(V3 b) { return *this = *this + b; }
};

inline double dot(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline V3 cross(V3 a, V3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(V3 a) { return std::sqrt(dot(a, a)); }

/// A rotation: unit quaternion.
struct Turn {
    double x = 0, y = 0, z = 0, w = 1;
};

/// The rotation by `angle` [rad] about a unit axis, right-handed.
inline Turn about(V3 axis, double angle) {
    const double s = std::sin(angle / 2);
    return {axis.x * s, axis.y * s, axis.z * s, std::cos(angle / 2)};
}
inline V3 rotate(Turn q, V3 v) {
    const V3 u{q.x, q.y, q.z}, t = 2 * cross(u, v);
    return v + q.w * t + cross(u, t);
}
/// The rotation by b, followed by the rotation by a.
inline Turn operator*(Turn a, Turn b) {
    const V3 p{a.x, a.y, a.z}, q{b.x, b.y, b.z}, v = a.w * q + b.w * p + cross(p, q);
    return {v.x, v.y, v.z, a.w * b.w - dot(p, q)};
}
inline V3 rotate_inverse(Turn q, V3 v) { return rotate({-q.x, -q.y, -q.z, q.w}, v); }

/// The shortest rotation of the x axis to a unit vector.
inline Turn from_x_to(V3 to) {
    if (to.x < -0.999999) return {0, 0, 1, 0};
    const V3 c = cross({1, 0, 0}, to);
    const double w = 1 + to.x, size = std::sqrt(dot(c, c) + w * w);
    return {c.x / size, c.y / size, c.z / size, w / size};
}

inline Turn from_z_to(V3 to) {
    if (to.z < -0.999999) return {1, 0, 0, 0};
    const V3 c = cross({0, 0, 1}, to);
    const double w = 1 + to.z, size = std::sqrt(dot(c, c) + w * w);
    return {c.x / size, c.y / size, c.z / size, w / size};
}

inline constexpr double pi = 3.14159265358979323846;
inline double radians(double degrees) { return degrees * pi / 180; }

} // namespace engines
