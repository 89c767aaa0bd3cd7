// Shared by meshes and height fields: exact normals of triangles, the test for flat edges, and queries
// converted to scale 1.
#pragma once

#include "shapes/asset/asset.h"

namespace lockstone::shapes {

/// Unit normal of a triangle at a scale, from its corners at scale 1. Exact until the final rounding; zero for
/// a degenerate triangle. The corners must be within 2^14 m of each other.
UnitVec3 triangle_normal(const CoordinateVec3 (&corner)[3], LengthVec3 scale);

bool has_area(const CoordinateVec3 (&corner)[3]); ///< exact

/// Sign of p's height: > 0 on the side to which the triangle's normal points, 0 in its plane. Exact.
int side_of(const CoordinateVec3 (&corner)[3], CoordinateVec3 p);

/// |a x b| < sine.
bool is_flat(UnitVec3 a, UnitVec3 b, Unit sine);

/// Converts a box to scale 1: scaled_by(p, scale) is in `where` exactly when p is in the result.
Extent at_scale_one(const Extent& where, LengthVec3 scale);

} // namespace lockstone::shapes
