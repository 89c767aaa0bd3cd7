#include "reference/fcl_shape.h"

#include "lockstone/asset.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>

namespace reference {

using lockstone::Error, lockstone::Result, lockstone::ShapeKind, lockstone::to_double;

fcl::Transform3d fcl_transform(const Pose& pose) {
    fcl::Transform3d t = fcl::Transform3d::Identity();
    t.linear() = fcl::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z)
                     .toRotationMatrix();
    t.translation() = fcl::Vector3d(pose.position.x, pose.position.y, pose.position.z);
    return t;
}

namespace {

fcl::Vector3d point_of(const lockstone::Vec3& v) { return {to_double(v.x), to_double(v.y), to_double(v.z)}; }

std::shared_ptr<fcl::CollisionGeometryd> make_hull(const lockstone::TriangleSoup& soup) {
    auto vertices = std::make_shared<std::vector<fcl::Vector3d>>();
    for (const lockstone::Vec3& v : soup.vertices) vertices->push_back(point_of(v));
    auto faces = std::make_shared<std::vector<int>>();
    for (const auto& t : soup.triangles)
        faces->insert(faces->end(),
                      {3, static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2])});
    return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(soup.triangles.size()), faces);
}

std::shared_ptr<fcl::CollisionGeometryd> make_mesh(const lockstone::TriangleSoup& soup) {
    auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
    model->beginModel(static_cast<int>(soup.triangles.size()), static_cast<int>(soup.vertices.size()));
    for (const auto& t : soup.triangles)
        model->addTriangle(point_of(soup.vertices[t[0]]), point_of(soup.vertices[t[1]]),
                           point_of(soup.vertices[t[2]]));
    model->endModel();
    return model;
}

/// The permutation x y z -> z x y, which turns z into y.
fcl::Transform3d upright() {
    fcl::Transform3d t = fcl::Transform3d::Identity();
    t.linear().col(0) = fcl::Vector3d::UnitZ();
    t.linear().col(1) = fcl::Vector3d::UnitX();
    t.linear().col(2) = fcl::Vector3d::UnitY();
    return t;
}

} // namespace

Result<FclShape> make_fcl_shape(const lockstone::Geometry& g, const lockstone::AssetLibrary& assets) {
    const bool has_radius = g.kind == ShapeKind::sphere || g.kind == ShapeKind::capsule;
    if (!has_radius && g.radius != lockstone::Length{})
        return Error{std::string("FCL has no rounded ") + name_of(g.kind)};
    const fcl::Transform3d as_is = fcl::Transform3d::Identity();
    const double scale = to_double(g.scale.x), radius = scale * to_double(g.radius);
    const double x = scale * to_double(g.half_extent.x), y = scale * to_double(g.half_extent.y),
                 z = scale * to_double(g.half_extent.z);
    switch (g.kind) {
    case ShapeKind::sphere:
        return FclShape{std::make_shared<fcl::Sphered>(radius), as_is};
    case ShapeKind::capsule:
        return FclShape{std::make_shared<fcl::Capsuled>(radius, 2 * y), upright()};
    case ShapeKind::cylinder:
        return FclShape{std::make_shared<fcl::Cylinderd>(x, 2 * y), upright()};
    case ShapeKind::cone:
        return FclShape{std::make_shared<fcl::Coned>(x, 2 * y), upright()};
    case ShapeKind::box:
        return FclShape{std::make_shared<fcl::Boxd>(2 * x, 2 * y, 2 * z), as_is};
    case ShapeKind::plane:
        return FclShape{std::make_shared<fcl::Halfspaced>(fcl::Vector3d(0, 1, 0), 0), as_is};
    case ShapeKind::hull:
        return FclShape{make_hull(triangulate(g, assets)), as_is};
    case ShapeKind::height_field:
    case ShapeKind::mesh:
        return FclShape{make_mesh(triangulate(g, assets)), as_is};
    case ShapeKind::compound:
        break;
    }
    return Error{std::string("FCL has no ") + name_of(g.kind)};
}

} // namespace reference
