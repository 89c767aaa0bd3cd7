// The face of a triangle alone, without what lies beside it: what casts and distances look at.
#pragma once

#include "shapes/asset/asset.h"

namespace lockstone::shapes {

/// As in Triangle, in the asset's axes at the shape's scale.
struct Face {
    CoordinateVec3 corner[3];
    UnitVec3 normal;
    std::uint32_t index;
};
/// Of a solid that has triangles: the face of triangle_at().
Face face_at(const Solid& solid, std::uint32_t index);

} // namespace lockstone::shapes
