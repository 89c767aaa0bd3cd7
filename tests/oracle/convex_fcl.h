// The results of FCL 0.7 for two convex shapes: a second opinion by other authors.
#pragma once

#include "oracle/convex_scenes.h"

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <map>
#include <memory>
#include <optional>

namespace oracle {

/// FCL's cylinders, cones and capsules have their axis along z, ours along y: x y z -> z x y.
inline fcl::Transform3d transform_of(const DoubleCore& s) {
    const bool turned = s.kind == ShapeKind::capsule || s.is_smooth();
    fcl::Transform3d t = fcl::Transform3d::Identity();
    for (int column = 0; column < 3; ++column) {
        const D3& axis = s.axes[turned ? (column + 2) % 3 : column];
        t.linear().col(column) = fcl::Vector3d(axis.x, axis.y, axis.z);
    }
    t.translation() = fcl::Vector3d(s.center.x, s.center.y, s.center.z);
    return t;
}

using FclShape = std::shared_ptr<fcl::CollisionGeometryd>;

inline FclShape make_fcl_hull(const Solid& s) {
    auto vertices = std::make_shared<std::vector<fcl::Vector3d>>();
    for (const lockstone::LengthVec3& v : s.hull->vertices)
        vertices->emplace_back(as_double(v.x), as_double(v.y), as_double(v.z));
    auto faces = std::make_shared<std::vector<int>>();
    for (const auto& t : s.hull->triangles) faces->insert(faces->end(), {3, t[0], t[1], t[2]});
    return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(s.hull->triangles.size()), faces);
}

/// FCL hulls, made once for each hull of a pool. The pool must outlive this object.
class FclHulls {
  public:
    FclShape of(const Solid& s) {
        FclShape& made = hulls[s.hull];
        if (made == nullptr) made = make_fcl_hull(s);
        return made;
    }

  private:
    std::map<const lockstone::shapes::Hull*, FclShape> hulls;
};

/// The cores, except whole spheres and capsules: FCL has no points and segments.
inline FclShape fcl_shape(FclHulls& hulls, const Solid& s, const DoubleCore& d) {
    switch (d.kind) {
    case ShapeKind::sphere:
        return std::make_shared<fcl::Sphered>(d.radius);
    case ShapeKind::capsule:
        return std::make_shared<fcl::Capsuled>(d.radius, 2 * d.half.y);
    case ShapeKind::cylinder:
        return std::make_shared<fcl::Cylinderd>(d.half.x, 2 * d.half.y);
    case ShapeKind::cone:
        return std::make_shared<fcl::Coned>(d.half.x, 2 * d.half.y);
    case ShapeKind::box:
        return std::make_shared<fcl::Boxd>(2 * d.half.x, 2 * d.half.y, 2 * d.half.z);
    case ShapeKind::plane:
        return std::make_shared<fcl::Halfspaced>(fcl::Vector3d(0, 1, 0), 0);
    default:
        return hulls.of(s);
    }
}

/// FCL's result for the shapes, without the rounding of all kinds but sphere and capsule.
struct FclAnswer {
    bool hit = false;
    double distance = 0;          ///< if apart
    double depth = 0;             ///< of its deepest contact
    std::vector<D3> directions{}; ///< of its contacts
};

/// Empty when FCL throws. The assertions of libccd's search end the process on some simplices of shapes that nearly
/// touch; these use FCL's own solver.
inline std::optional<FclAnswer> ask_fcl(FclHulls& hulls, const ConvexScene& s, const DoubleCore& a,
                                        const DoubleCore& b, bool touching) {
    const fcl::GJKSolverType solver = touching ? fcl::GST_INDEP : fcl::GST_LIBCCD;
    fcl::CollisionRequestd collision(8, true);
    fcl::DistanceRequestd distance(false, false);
    collision.gjk_solver_type = distance.gjk_solver_type = solver;
    fcl::CollisionObjectd object_a(fcl_shape(hulls, s.a, a), transform_of(a)),
        object_b(fcl_shape(hulls, s.b, b), transform_of(b));
    FclAnswer answer;
    try {
        fcl::CollisionResultd contacts;
        answer.hit = fcl::collide(&object_a, &object_b, collision, contacts) > 0;
        for (std::size_t i = 0; i < contacts.numContacts(); ++i) {
            const fcl::Contactd& contact = contacts.getContact(i);
            answer.directions.push_back({contact.normal.x(), contact.normal.y(), contact.normal.z()});
            answer.depth = std::max(answer.depth, std::abs(contact.penetration_depth));
        }
        if (answer.hit || a.kind == ShapeKind::plane) return answer; // FCL has no distance from a half-space
        fcl::DistanceResultd result;
        answer.distance = fcl::distance(&object_a, &object_b, distance, result);
        return answer;
    } catch (const std::exception&) { return std::nullopt; }
}

/// The part of the radius that the FCL shape includes.
inline double radius_in_fcl(const DoubleCore& s) {
    return s.kind == ShapeKind::sphere || s.kind == ShapeKind::capsule ? s.radius : 0;
}

} // namespace oracle
