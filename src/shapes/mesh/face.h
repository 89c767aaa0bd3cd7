// A triangle's face, and the data of its edges, as separate parts: casts and distances need only the face,
// contacts need the face first.
#pragma once

#include "shapes/asset/asset.h"

namespace lockstone::shapes {

/// As in Triangle: in the asset's axes at the shape's scale.
struct Face {
    CoordinateVec3 corner[3];
    UnitVec3 normal;
    std::uint32_t index;
};
/// The face of triangle_at(). The solid must be a mesh or height field, here and below.
Face face_at(const Solid& solid, std::uint32_t index);

/// The first corner of a face and its normal, which define its plane.
struct FacePlane {
    CoordinateVec3 on;
    UnitVec3 normal;
};
FacePlane plane_at(const Solid& solid, std::uint32_t index); ///< the plane of face_at()

/// The data of a face's edges, as in Triangle.
struct FaceEdges {
    std::uint32_t sharp;
    UnitVec3 beyond[3];
};
FaceEdges edges_at(const Solid& solid, const Face& face);

} // namespace lockstone::shapes
