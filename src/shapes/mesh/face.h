// The face of a triangle and what lies beside it, apart: casts and distances look at the face alone, contacts at the face first.
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

/// The first corner of a face and its normal, which tell its plane.
struct FacePlane {
    CoordinateVec3 on;
    UnitVec3 normal;
};
FacePlane plane_at(const Solid& solid, std::uint32_t index); ///< of face_at()

/// What lies beside a face, as in Triangle.
struct FaceEdges {
    std::uint32_t sharp;
    UnitVec3 beyond[3];
};
FaceEdges edges_at(const Solid& solid, const Face& face);

} // namespace lockstone::shapes
