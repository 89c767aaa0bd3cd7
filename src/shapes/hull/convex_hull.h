// The exact convex hull of integer points: the sign of an integer determinant makes every decision.
#pragma once

#include "lockstone/math/vec.h"
#include "shapes/scaled.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace lockstone::shapes {

/// A vector whose components need more than 64 bits: the cross product of two differences of lengths.
struct WideVec3 {
    Wide x, y, z;
};

/// The exact normal of the triangle a b c; its length is twice the area. 48 fraction bits, |component| < 2^65.
WideVec3 exact_normal(LengthVec3 a, LengthVec3 b, LengthVec3 c);
/// n . (p - a), exact, 72 fraction bits. Positive when p is on the side to which n points.
Wide exact_height(const WideVec3& n, LengthVec3 a, LengthVec3 p);
/// The direction of a wide vector; zero for zero.
UnitVec3 unit_of(const WideVec3& n);
/// |n| with 59 significant bits.
Scaled length_of(const WideVec3& n);

/// A closed, convex surface of triangles, counter-clockwise seen from outside.
struct ConvexSurface {
    std::vector<LengthVec3> vertices; ///< ascending by x, then y, then z; every one is a corner
    /// In ascending order; each begins with its smallest vertex
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

enum class HullFault { none, too_few_points, one_point, one_line, one_plane };

/// Depends on the set of points only, not on their order. Coordinates must be in -128 m .. 128 m.
/// source: Edelsbrunner, Algorithms in Combinatorial Geometry, 8.4 (beneath-beyond in lexicographic order).
HullFault convex_hull(std::span<const LengthVec3> points, ConvexSurface& out);

} // namespace lockstone::shapes
