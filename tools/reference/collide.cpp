#include "reference/collide.h"

#include "reference/fcl_shape.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cmath>

namespace reference {

using lockstone::Error, lockstone::Mix, lockstone::Result, lockstone::ShapeKind;

namespace {

/// The largest number of contact points per pair. FCL finds at most four for two convex shapes, and one per triangle
/// for a mesh.
constexpr std::size_t contacts_max = 64;

/// One shape of the scene.
struct Part {
    int body;
    lockstone::ShapeDef def;
    fcl::Transform3d local; ///< in the body's axes
    std::unique_ptr<fcl::CollisionObjectd> object;
};

double mixed(Mix rule_a, Mix rule_b, lockstone::Real of_a, lockstone::Real of_b) {
    const double a = lockstone::to_double(of_a), b = lockstone::to_double(of_b);
    switch (std::max(rule_a, rule_b)) {
    case Mix::geometric_mean:
        return std::sqrt(a * b);
    case Mix::average:
        return (a + b) / 2;
    case Mix::minimum:
        return std::min(a, b);
    case Mix::multiply:
        return a * b;
    case Mix::maximum:
        break;
    }
    return std::max(a, b);
}

bool filters_allow(const lockstone::ShapeDef& a, const lockstone::ShapeDef& b) {
    if (a.sensor != 0 || b.sensor != 0) return false;
    if (a.group != 0 && a.group == b.group) return a.group > 0;
    return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

class FclCollider final : public Collider {
  public:
    lockstone::Status add_all(const Start& start, const lockstone::World& world, bool boxes_on_boxes) {
        box_ground = boxes_on_boxes;
        for (std::size_t i = 0; i < start.bodies.size(); ++i) {
            movable.push_back(start.bodies[i].start.mass_inv > 0);
            for (const lockstone::ShapeDef& def : start.bodies[i].shapes)
                if (const lockstone::Status added = add(static_cast<int>(i), def, world.assets()); !added)
                    return Error{"body " + std::to_string(i) + ": " + added.error().message};
        }
        for (std::size_t a = 0; a < start.bodies.size(); ++a)
            for (std::size_t b = a + 1; b < start.bodies.size(); ++b)
                if (!world.may_touch(start.bodies[a].id, start.bodies[b].id))
                    apart.emplace_back(static_cast<int>(a), static_cast<int>(b));
        for (std::size_t i = 0; i < parts.size(); ++i) {
            parts[i].object->setUserData(&parts[i]);
            if (parts[i].def.geometry.kind == ShapeKind::plane)
                planes.push_back(i);
            else
                objects.push_back(parts[i].object.get());
        }
        tree.registerObjects(objects);
        tree.setup();
        return {};
    }

    std::vector<Contact> contacts(std::span<const Pose> poses) override {
        for (Part& part : parts) {
            part.object->setTransform(fcl_transform(poses[static_cast<std::size_t>(part.body)]) * part.local);
            part.object->computeAABB();
        }
        tree.update();
        near.clear();
        tree.collide(this, [](fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* self) {
            static_cast<FclCollider*>(self)->keep(*static_cast<const Part*>(a->getUserData()),
                                                  *static_cast<const Part*>(b->getUserData()));
            return false;
        });
        for (const std::size_t plane : planes)
            for (const Part& part : parts)
                if (part.def.geometry.kind != ShapeKind::plane) keep(parts[plane], part);
        std::sort(near.begin(), near.end());
        found.clear();
        for (const auto& [a, b] : near) collide(parts[a], parts[b]);
        return found;
    }

  private:
    lockstone::Status add(int body, const lockstone::ShapeDef& def, const lockstone::AssetLibrary& assets) {
        const Result<FclShape> shape = make_fcl_shape(def.geometry, assets);
        if (!shape) return shape.error();
        parts.push_back({body, def, fcl_transform(pose(def.local)) * shape->local,
                         std::make_unique<fcl::CollisionObjectd>(shape->geometry)});
        return {};
    }

    /// Adds a pair whose boxes overlap, in the order of the parts.
    void keep(const Part& one, const Part& other) {
        const Part &a = std::min(&one, &other) == &one ? one : other, &b = &a == &one ? other : one;
        if (a.body == b.body || !filters_allow(a.def, b.def)) return;
        if (!movable[static_cast<std::size_t>(a.body)] && !movable[static_cast<std::size_t>(b.body)]) return;
        if (std::binary_search(apart.begin(), apart.end(), std::pair(a.body, b.body))) return;
        near.emplace_back(static_cast<std::size_t>(&a - parts.data()),
                          static_cast<std::size_t>(&b - parts.data()));
    }

    /// FCL 0.7 finds only one point of a box on a half-space. It also treats a cone or a cylinder whose axis points
    /// down as one that lies on its side (halfspace-inl.h compares the cosine, not its absolute value). On the top of a
    /// box FCL finds four correct points.
    bool needs_top(const Part& plane, const Part& on) const {
        const ShapeKind kind = on.def.geometry.kind;
        return box_ground && plane.def.geometry.kind == ShapeKind::plane &&
               (kind == ShapeKind::box || kind == ShapeKind::cylinder || kind == ShapeKind::cone);
    }

    void collide(const Part& a, const Part& b) {
        if (needs_top(a, b))
            ask(a, b, *top_under(a, b), *b.object);
        else if (needs_top(b, a))
            ask(a, b, *a.object, *top_under(b, a));
        else
            ask(a, b, *a.object, *b.object);
    }

    /// A box whose top is the plane. It lies under the other shape and is four times as wide.
    static std::unique_ptr<fcl::CollisionObjectd> top_under(const Part& plane, const Part& on) {
        const double side = 8 * on.object->collisionGeometry()->aabb_radius;
        const fcl::Transform3d& ground = plane.object->getTransform();
        fcl::Vector3d center = ground.inverse() * on.object->getTranslation();
        center.y() = -side / 2;
        fcl::Transform3d place = ground;
        place.translation() = ground * center;
        return std::make_unique<fcl::CollisionObjectd>(std::make_shared<fcl::Boxd>(side, side, side), place);
    }

    /// The contacts that FCL finds with its own GJK. libccd's GJK ends the process for some simplices.
    static fcl::CollisionResultd find(const fcl::CollisionObjectd& first,
                                      const fcl::CollisionObjectd& second) {
        fcl::CollisionRequestd request(contacts_max, true);
        request.gjk_solver_type = fcl::GST_INDEP;
        fcl::CollisionResultd result;
        fcl::collide(&first, &second, request, result);
        return result;
    }

    /// The normal from FCL's first shape to its second. For a triangle and any shape but a sphere, FCL 0.7 returns it
    /// in that shape's axes and with the opposite sign (shapeTriangleIntersect of gjk_solver_indep-inl.h).
    static fcl::Vector3d normal_of(const fcl::Contactd& c, const fcl::CollisionObjectd& first,
                                   const fcl::CollisionObjectd& second) {
        if (first.getObjectType() != fcl::OT_BVH || second.getNodeType() == fcl::GEOM_SPHERE) return c.normal;
        return -(second.getRotation() * c.normal);
    }

    /// Adds the contacts of a pair. The thesis' normals point to the side to which the first body is pushed.
    void ask(const Part& a, const Part& b, const fcl::CollisionObjectd& shape_a,
             const fcl::CollisionObjectd& shape_b) {
        const bool turned = shape_b.getObjectType() == fcl::OT_BVH; // the mesh comes first
        const fcl::CollisionObjectd &first = turned ? shape_b : shape_a, &second = turned ? shape_a : shape_b;
        const fcl::CollisionResultd result = find(first, second);
        const double friction = mixed(a.def.friction_mix, b.def.friction_mix, a.def.friction, b.def.friction);
        const double restitution =
            mixed(a.def.restitution_mix, b.def.restitution_mix, a.def.restitution, b.def.restitution);
        for (std::size_t i = 0; i < result.numContacts(); ++i) {
            const fcl::Contactd& c = result.getContact(i);
            const fcl::Vector3d n = normal_of(c, first, second) * (turned ? 1 : -1);
            found.push_back({a.body,
                             b.body,
                             {c.pos.x(), c.pos.y(), c.pos.z()},
                             {n.x(), n.y(), n.z()},
                             std::abs(c.penetration_depth),
                             friction,
                             restitution});
        }
    }

    std::vector<Part> parts;
    std::vector<bool> movable;              ///< by body
    std::vector<std::pair<int, int>> apart; ///< pairs of bodies that may not touch, ascending
    std::vector<std::size_t> planes;        ///< they have no bounds, so they are not in the tree
    std::vector<fcl::CollisionObjectd*> objects;
    std::vector<std::pair<std::size_t, std::size_t>> near;
    std::vector<Contact> found;
    fcl::DynamicAABBTreeCollisionManagerd tree;
    bool box_ground = true;
};

} // namespace

Result<std::unique_ptr<Collider>> Collider::create(const Start& start, const lockstone::World& world,
                                                   bool box_ground) {
    auto collider = std::make_unique<FclCollider>();
    if (const lockstone::Status added = collider->add_all(start, world, box_ground); !added)
        return added.error();
    return std::unique_ptr<Collider>(std::move(collider));
}

} // namespace reference
