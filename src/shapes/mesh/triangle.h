// What meshes and height fields share: normals of exact triangles, edges that are felt, queries turned back to scale 1.
#pragma once

#include "shapes/asset/asset.h"

namespace lockstone::shapes {

/// Unit normal of a triangle at a scale, from its corners at scale 1: exact until it is rounded; zero when degenerate.
/// Corners within 2^14 m of each other.
UnitVec3 triangle_normal(const CoordinateVec3 (&corner)[3], LengthVec3 scale);

bool has_area(const CoordinateVec3 (&corner)[3]); ///< exact

/// The side of p: > 0 where the triangle's normal shows to, 0 in its plane. Exact.
int side_of(const CoordinateVec3 (&corner)[3], CoordinateVec3 p);

/// |a x b| < sine.
bool is_flat(UnitVec3 a, UnitVec3 b, Unit sine);

/// The box at scale 1 that the same points lie in: scaled_by(p, scale) is in `where` exactly when p is in the result.
Extent at_scale_one(const Extent& where, LengthVec3 scale);

} // namespace lockstone::shapes
