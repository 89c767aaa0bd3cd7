// The integers of the narrow phase. A name's suffix gives its fraction bits: x_24, x_30, x_54.
//
// The routines for plain spheres, capsules and boxes rely on these bounds: a shape reaches at most 174 m from
// its origin (a box of 3 x 100 m), and a relative position is at most 222 m (3 x 128 m). So no point is further
// than 396 m < 2^9 m from the frame's origin. A dot product of a unit vector (30 fraction bits) and a length
// (24 fraction bits), partial sums included, then stays below 2^63 and needs no check.
#pragma once

#include "collide/narrow_phase.h"
#include "lockstone/math/math.h"

#include <cstdint>
#include <type_traits>

namespace lockstone::collide {

/// Three 64-bit coordinates.
struct Long3 {
    std::int64_t v[3];

    constexpr std::int64_t& operator[](int i) { return v[i]; }
    constexpr std::int64_t operator[](int i) const { return v[i]; }
    friend constexpr Long3 operator+(Long3 a, Long3 b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
    friend constexpr Long3 operator-(Long3 a, Long3 b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
    friend constexpr Long3 operator-(Long3 a) { return {-a[0], -a[1], -a[2]}; }
    friend constexpr Long3 operator*(Long3 a, std::int64_t s) { return {a[0] * s, a[1] * s, a[2] * s}; }
};

template <FixedPoint T> constexpr Long3 raw(const Vector3<T>& v) { return {v.x.raw, v.y.raw, v.z.raw}; }
constexpr std::int64_t dot(Long3 a, Long3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

constexpr std::int64_t one_30 = std::int64_t{1} << 30;

constexpr std::int64_t absolute(std::int64_t x) { return x < 0 ? -x : x; }
constexpr std::int64_t sign_of(std::int64_t x) { return x < 0 ? -1 : 1; } ///< zero counts as positive
constexpr std::int64_t clamped(std::int64_t x, std::int64_t low, std::int64_t high) {
    return x < low ? low : high < x ? high : x;
}
constexpr std::int64_t smaller(std::int64_t a, std::int64_t b) { return b < a ? b : a; }
constexpr std::int64_t larger(std::int64_t a, std::int64_t b) { return a < b ? b : a; }
constexpr Long3 shifted(Long3 a, int drop) {
    return {shift_right_rounded(a[0], drop), shift_right_rounded(a[1], drop),
            shift_right_rounded(a[2], drop)};
}
constexpr std::int64_t up(std::int64_t x, int bits) { return x * (std::int64_t{1} << bits); }
constexpr Long3 up(Long3 a, int bits) { return a * (std::int64_t{1} << bits); }

constexpr Length length_of_30(std::int64_t x) { return round_from<Length>(x, 30); }
constexpr Separation separation_of_30(std::int64_t x) { return round_from<Separation>(x, 30); }
constexpr LengthVec3 point_of_30(Long3 p) {
    return {length_of_30(p[0]), length_of_30(p[1]), length_of_30(p[2])};
}
constexpr UnitVec3 unit_of_30(Long3 n) {
    const auto unit = [](std::int64_t x) { return Unit::from_raw(static_cast<std::int32_t>(x)); };
    return {unit(n[0]), unit(n[1]), unit(n[2])};
}

/// Calls visit(0), visit(1), visit(2) with compile-time indices, so that the loops of the axis search unroll.
template <class Visit> constexpr void for_axes(Visit&& visit) {
    visit(std::integral_constant<int, 0>{});
    visit(std::integral_constant<int, 1>{});
    visit(std::integral_constant<int, 2>{});
}

/// d / |d| and |d|, both in 30 fraction bits; the direction of a zero vector is zero.
struct Direction {
    Long3 unit;
    std::int64_t length;
};
/// d has 30 fraction bits. The relative error is 2^-30 for any length up to 2^9 m.
inline Direction direction_of_30(Long3 d) {
    // Has as many bits as the widest component.
    const std::int64_t any = absolute(d[0]) | absolute(d[1]) | absolute(d[2]);
    if (any == 0) return {Long3{}, 0};
    // Scale to 31 bits: the sum of the squares is then below 2^64.
    const int shift = 31 - bit_length(static_cast<std::uint64_t>(any));
    const Long3 m = shift >= 0 ? up(d, shift) : Long3{d[0] >> -shift, d[1] >> -shift, d[2] >> -shift};
    std::uint64_t square = 0;
    for (int i = 0; i < 3; ++i) square += static_cast<std::uint64_t>(m[i] * m[i]);
    const std::int64_t root = isqrt(square);
    const auto ratio = [root](std::int64_t x) { return divide_shifted(x, root, 30); };
    return {{ratio(m[0]), ratio(m[1]), ratio(m[2])},
            shift >= 0 ? shift_right_rounded(root, shift) : up(root, -shift)};
}

/// numerator * 2^shift / denominator, clamped to low..high. The denominator is not 0.
inline std::int64_t ratio_clamped(std::int64_t numerator, std::int64_t denominator, int shift,
                                  std::int64_t low, std::int64_t high) {
    return clamped(divide_shifted(numerator, denominator, shift), low, high);
}

/// Adds a point if it is within the margin. `position` and `separation` have 30 fraction bits.
inline void add_point(Manifold& out, Long3 position, std::int64_t separation, Length margin,
                      std::uint32_t feature) {
    if (separation > up(margin.raw, 6)) return;
    out.points[out.count++] = {point_of_30(position), separation_of_30(separation), feature};
}

/// Adds the contact point of two round surfaces: the cores are at `from` (A) and from + distance * normal (B),
/// each with its radius around it.
inline void add_round_point(Manifold& out, Long3 from, Long3 normal, std::int64_t distance, Length radius_a,
                            Length radius_b, Length margin, std::uint32_t feature) {
    const std::int64_t separation = distance - up(std::int64_t{radius_a.raw} + radius_b.raw, 6);
    const std::int64_t offset_24 =
        radius_a.raw + shift_right_rounded(separation, 7); // to the middle of the gap
    add_point(out, from + shifted(normal * offset_24, 24), separation, margin, feature);
}

// Feature names of boxes. They do not depend on which box's face was the reference. A corner has three sign
// bits (bit i: the positive side of axis i). An edge has its axis and the sign bits of the other two axes.
constexpr std::uint32_t corner_feature_a(std::uint32_t corner) { return 0x10000u | corner; }
constexpr std::uint32_t corner_feature_b(std::uint32_t corner) { return 0x20000u | corner; }
constexpr std::uint32_t edge_feature(std::uint32_t edge_a, std::uint32_t edge_b) {
    return 0x30000u | edge_a << 8 | edge_b;
}
/// `signs` are corner bits; the bit of the edge's own axis has no effect.
constexpr std::uint32_t edge_id(int axis, std::uint32_t signs) {
    return static_cast<std::uint32_t>(axis) << 3 | (signs & ~(1u << axis));
}

/// length * axis with 30 fraction bits, from 24 and 30 fraction bits, rounded once. For lengths of up to
/// 2^20 m.
inline Long3 along_30(Long3 axis_30, std::int64_t length_24) {
    if ((length_24 ^ (length_24 >> 63)) >> 32 == 0) return shifted(axis_30 * length_24, 24); // below 2^62
    const auto part = [&](std::int64_t x) { return narrow_rounded(Wide::product(x, length_24), 24); };
    return {part(axis_30[0]), part(axis_30[1]), part(axis_30[2])};
}

// The routines by pairs of kinds; A first. All need the preconditions of `collide`, no rounding, scale 1 and a
// zeroed manifold. Positions in the result are from A's origin.
void collide_sphere_sphere(const Geometry& a, const Geometry& b, const RelativePose&, Length margin,
                           Manifold& out);
void collide_capsule_sphere(const Geometry& a, const Geometry& b, const RelativePose&, Length margin,
                            Manifold& out);
void collide_capsule_capsule(const Geometry& a, const Geometry& b, const RelativePose&, Length margin,
                             Manifold& out);
void collide_box_sphere(const Geometry& a, const Geometry& b, const RelativePose&, Length margin,
                        Manifold& out);
void collide_box_capsule(const Geometry& a, const Geometry& b, const RelativePose&, Length margin,
                         Manifold& out);
void collide_box_box(const Geometry& a, const Geometry& b, const RelativePose&, Length margin, Manifold& out);

} // namespace lockstone::collide
