// A scene in Lockstone, through its public interface. Defaults throughout, limits that are too low apart.
#include "engines/lockstone_engine.h"

#include "lockstone/math/convert.h"
#include "lockstone/math/math.h"
#include "lockstone/tasks.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <span>

namespace engines {

namespace {

namespace ls = lockstone;

template <class T> T checked(ls::Result<T> result) {
    if (result.ok()) return std::move(result).value();
    std::fprintf(stderr, "engines: %s\n", result.error().message.c_str());
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
    case Kind::mesh: {
        std::vector<ls::Vec3> points;
        for (V3 p : shape.points) points.push_back(vec(p));
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (const std::vector<int>& face : shape.faces) {
            const auto corner = [&](std::size_t i) { return static_cast<std::uint32_t>(face[i]); };
            triangles.push_back({corner(0), corner(1), corner(2)});
        }
        const ls::MeshDef def{.vertices = points, .triangles = triangles};
        return ls::instance(ls::ShapeKind::mesh, checked(library.add(ls::bake_mesh(def))));
    }
    case Kind::plane:
        break;
    }
    return ls::plane();
}

ls::WorldDef def_of(const Contestant& c, const Scene& scene) {
    const auto count = static_cast<std::uint32_t>(scene.bodies.size());
    std::uint32_t shapes = count;
    for (const Body& body : scene.bodies) shapes += static_cast<std::uint32_t>(body.parts.size());
    ls::WorldDef def{.tick_rate = static_cast<std::uint32_t>(c.rate),
                     .gravity = vec(scene.gravity),
                     .integrator = static_cast<ls::Integrator>(c.scheme),
                     .sleeping = scene.sleeping};
    def.bodies_max = std::max(def.bodies_max, count);
    def.shapes_max = std::max(def.shapes_max, shapes);
    def.joints_max = std::max(def.joints_max, static_cast<std::uint32_t>(scene.joints.size()));
    if (c.substeps != 0) def.substeps = static_cast<std::uint32_t>(c.substeps);
    if (c.contact_hertz != 0) def.contact_hertz = real(c.contact_hertz);
    if (c.contact_damping != 0) def.contact_damping = real(c.contact_damping);
    return def;
}

class Lockstone final : public Engine {
  public:
    Lockstone(const Contestant& contestant, const Scene& scene) : world(make(contestant, scene)) {
        by_wall = contestant.by_wall;
        for (const ls::Simd level : ls::every_simd)
            if (contestant.simd == ls::name_of(level)) world.set_simd(level);
#if !defined(LOCKSTONE_NO_THREADS)
        if (contestant.threads < 2) return;
        tasks = ls::make_worker_pool(contestant.threads);
        world.set_tasks(tasks.get());
#endif
    }

    State state(int body) const override {
        const ls::BodyId id = ids[static_cast<std::size_t>(body)];
        const ls::Transform pose = world.pose(id);
        const auto q = ls::to_double(pose.rotation);
        return {back(pose.position),
                back(world.linear_velocity(id)),
                back(world.angular_velocity(id)),
                {q[0], q[1], q[2], q[3]}};
    }

    void kick(int body, V3 change) override {
        const ls::BodyId id = ids[static_cast<std::size_t>(body)];
        const ls::Status done =
            world.set_velocity(id, world.linear_velocity(id) + vec(change), world.angular_velocity(id));
        if (!done) std::abort();
    }

  private:
    friend ls::World& engines::world_of(Engine& engine);
    void tick() override { world.tick(); }

    ls::World make(const Contestant& contestant, const Scene& scene) {
        auto library = std::make_shared<ls::AssetLibrary>();
        std::vector<ls::Geometry> geometries; // of a body, then of its parts
        for (const Body& body : scene.bodies) {
            geometries.push_back(geometry_of(body.shape, *library));
            for (const Part& part : body.parts) geometries.push_back(geometry_of(part.shape, *library));
        }
        ls::World made = checked(ls::World::create(def_of(contestant, scene), {}, library));
        std::span<const ls::Geometry> left = geometries;
        for (const Body& body : scene.bodies) {
            add(made, body, left);
            left = left.subspan(1 + body.parts.size());
        }
        for (const Joint& joint : scene.joints) join(made, joint);
        if (scene.attraction != 0) checked(made.create_field({.strength = real(scene.attraction)}));
        return made;
    }

    void add(ls::World& made, const Body& body, std::span<const ls::Geometry> geometries) {
        const ls::BodyKind still = body.moves ? ls::BodyKind::kinematic : ls::BodyKind::static_;
        const ls::BodyId id =
            checked(made.create_body({.kind = body.mass == 0 ? still : ls::BodyKind::dynamic,
                                      .pose = {vec(body.position), quat(body.rotation)},
                                      .linear_velocity = vec(body.velocity),
                                      .angular_velocity = vec(body.spin),
                                      .mass = real(body.mass)}));
        ls::ShapeDef shape{.geometry = geometries[0],
                           .friction = real(body.friction),
                           .restitution = real(body.restitution),
                           .rolling_resistance = real(body.rolling_resistance),
                           .surface_velocity = vec(body.surface_velocity)};
        checked(made.create_shape(id, shape));
        for (std::size_t i = 0; i < body.parts.size(); ++i) {
            shape.geometry = geometries[i + 1];
            shape.local = {vec(body.parts[i].position), quat(body.parts[i].rotation)};
            checked(made.create_shape(id, shape));
        }
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
    std::unique_ptr<ls::Tasks> tasks;
    ls::World world;
};

} // namespace

ls::World& world_of(Engine& engine) { return static_cast<Lockstone&>(engine).world; }

std::unique_ptr<Engine> make_lockstone(const Contestant& contestant, const Scene& scene) {
    return std::make_unique<Lockstone>(contestant, scene);
}

} // namespace engines
