// Converts Lockstone's shapes to FCL's.
#pragma once

#include "reference/start.h"

#include <fcl/narrowphase/collision_object.h>

#include <memory>

namespace reference {

/// An FCL shape and its pose in Lockstone's shape frame: FCL's capsules, cylinders and cones lie along z, Lockstone's
/// along y.
struct FclShape {
    std::shared_ptr<fcl::CollisionGeometryd> geometry;
    fcl::Transform3d local;
};
/// Meshes and height fields become triangle meshes, hulls become FCL's Convex. The error names a shape that FCL does
/// not have.
lockstone::Result<FclShape> make_fcl_shape(const lockstone::Geometry& geometry,
                                           const lockstone::AssetLibrary& assets);
fcl::Transform3d fcl_transform(const Pose& pose);

} // namespace reference
