#pragma once
/// Meshes of the primitive shapes, made in code. Right-handed, y up.

#include "mesh.h"

namespace lockstone::demo {

/// Box with rounded edges: scale = half extents less the radius, radius = the bevel's.
MeshData make_box();

/// Capsule along y: scale.y = half height without caps, radius = the capsule's. With scale 0 it is a sphere.
MeshData make_capsule();

/// Cylinder along y: scale = (radius, half height, radius).
MeshData make_cylinder();

/// Cone along y, apex up, origin half way up: scale = (radius, half height, radius).
MeshData make_cone();

/// Rectangle in the xz plane, facing y: scale = (half extent x, any, half extent z).
MeshData make_plane();

} // namespace lockstone::demo
