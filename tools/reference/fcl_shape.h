// Lockstone's shapes as FCL's.
#pragma once

#include "reference/start.h"

#include <fcl/narrowphase/collision_object.h>

#include <memory>

namespace reference {

/// A shape and where it sits in the shape's frame: FCL's capsules, cylinders and cones run along z, ours along y.
struct FclShape {
    std::shared_ptr<fcl::CollisionGeometryd> geometry;
    fcl::Transform3d local;
};
/// Meshes and height fields become triangle meshes, hulls FCL's Convex. The error names what FCL lacks.
lockstone::Result<FclShape> make_fcl_shape(const lockstone::Geometry& geometry,
                                           const lockstone::AssetLibrary& assets);
fcl::Transform3d fcl_transform(const Pose& pose);

} // namespace reference
