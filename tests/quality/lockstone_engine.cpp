// A scene in Lockstone, through its public interface. Defaults throughout, capacities apart.
#include "quality/scene.h"

#include "lockstone/convert.h"
#include "lockstone/math.h"
#include "lockstone/world.h"

#include <cstdio>
#include <cstdlib>

namespace quality {

namespace {

namespace ls = lockstone;

template <class T> T checked(ls::Result<T> result) {
    if (result.ok()) return std::move(result).value();
    std::fprintf(stderr, "quality: %s\n", result.error().message.c_str());
    std::exit(2);
}

ls::Real real(double x) { return ls::quantize<ls::Real>(x); }
ls::Vec3 vec(V3 v) { return {real(v.x), real(v.y), real(v.z)}; }
ls::Quat quat(Turn q) { return ls::normalized(ls::quantize_quat({q.x, q.y, q.z, q.w})); }
V3 back(ls::Vec3 v) { return {ls::to_double(v.x), ls::to_double(v.y), ls::to_double(v.z)}; }

ls::Geometry geometry_of(const Shape& shape, ls::AssetLibrary& library) {
    const V3 h = shape.half;
    switch (shape.kind) {
    case Kind::sphere:
        return ls::sphere(real(h.x));
    case Kind::box:
        return ls::box(vec(h));
    case Kind::capsule:
        return ls::capsule(real(h.x), real(h.y));
    case Kind::cylinder:
        return ls::cylinder(real(h.x), real(h.y));
    case Kind::hull: {
        std::vector<ls::LengthVec3> points;
        for (V3 p : shape.points) points.push_back(ls::to<ls::Length>(vec(p)));
        return ls::instance(ls::ShapeKind::hull, checked(library.add(ls::bake_hull(points))));
    }
    case Kind::plane:
        break;
    }
    return ls::plane();
}

ls::WorldDef world_of(const Contestant& c, const Scene& scene) {
    const auto count = static_cast<std::uint32_t>(scene.bodies.size());
    ls::WorldDef def{.tick_rate = static_cast<std::uint32_t>(c.rate),
                     .gravity = vec(scene.gravity),
                     .integrator = static_cast<ls::Integrator>(c.scheme),
                     .bodies_max = count,
                     .shapes_max = count,
                     .contacts_max = 32 * count,
                     .joints_max = static_cast<std::uint32_t>(scene.joints.size()) + 1,
                     .sleeping = scene.sleeping};
    if (c.substeps != 0) def.substeps = static_cast<std::uint32_t>(c.substeps);
    if (c.contact_hertz != 0) def.contact_hertz = real(c.contact_hertz);
    if (c.contact_damping != 0) def.contact_damping = real(c.contact_damping);
    return def;
}

class Lockstone final : public Engine {
  public:
    Lockstone(const Contestant& contestant, const Scene& scene) : world(make(contestant, scene)) {}

    State state(int body) const override {
        const ls::BodyId id = ids[static_cast<std::size_t>(body)];
        const ls::Transform pose = world.pose(id);
        const auto q = ls::to_double(pose.rotation);
        return {back(pose.position),
                back(world.linear_velocity(id)),
                back(world.angular_velocity(id)),
                {q[0], q[1], q[2], q[3]}};
    }

  private:
    void tick() override { world.tick(); }

    ls::World make(const Contestant& contestant, const Scene& scene) {
        auto library = std::make_shared<ls::AssetLibrary>();
        std::vector<ls::Geometry> geometries;
        for (const Body& body : scene.bodies) geometries.push_back(geometry_of(body.shape, *library));
        ls::World made = checked(ls::World::create(world_of(contestant, scene), {}, library));
        for (std::size_t i = 0; i < scene.bodies.size(); ++i) add(made, scene.bodies[i], geometries[i]);
        for (const Joint& joint : scene.joints) join(made, joint);
        if (scene.attraction != 0) checked(made.create_field({.strength = real(scene.attraction)}));
        return made;
    }

    void add(ls::World& made, const Body& body, const ls::Geometry& geometry) {
        const ls::BodyId id =
            checked(made.create_body({.kind = body.mass == 0 ? ls::BodyKind::static_ : ls::BodyKind::dynamic,
                                      .pose = {vec(body.position), quat(body.rotation)},
                                      .linear_velocity = vec(body.velocity),
                                      .angular_velocity = vec(body.spin),
                                      .mass = real(body.mass)}));
        checked(made.create_shape(id, {.geometry = geometry,
                                       .friction = real(body.friction),
                                       .restitution = real(body.restitution),
                                       .rolling_resistance = real(body.rolling_resistance),
                                       .surface_velocity = vec(body.surface_velocity)}));
        ids.push_back(id);
    }

    void join(ls::World& made, const Joint& joint) {
        ls::JointDef def = joint.kind == Link::ball    ? ls::ball_joint()
                           : joint.kind == Link::hinge ? ls::hinge_joint()
                                                       : ls::slider_joint();
        ls::JointAxis& axis = def.axis[joint.kind == Link::slider ? ls::along_x : ls::about_x];
        if (joint.limit != 0) {
            axis.mode = ls::AxisMode::limited;
            axis.lower = real(-joint.limit), axis.upper = real(joint.limit);
        }
        axis.motor_speed = real(joint.motor_speed), axis.motor_force = real(joint.motor_force);
        const ls::BodyId a = joint.a < 0 ? ls::BodyId{} : ids[static_cast<std::size_t>(joint.a)];
        checked(made.create_joint(def, a, ids[static_cast<std::size_t>(joint.b)],
                                  {vec(joint.anchor), quat(from_x_to(joint.axis))}));
    }

    std::vector<ls::BodyId> ids;
    ls::World world;
};

} // namespace

std::unique_ptr<Engine> make_lockstone(const Contestant& contestant, const Scene& scene) {
    return std::make_unique<Lockstone>(contestant, scene);
}

} // namespace quality
