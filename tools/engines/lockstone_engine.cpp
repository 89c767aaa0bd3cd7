// Runs a scene in Lockstone through its public interface. All settings are defaults, except capacities that would be
// too low.
#include "engines/lockstone_engine.h"

#include "lockstone/math/convert.h"
#include "lockstone/math/math.h"
#include "lockstone/play/ragdoll.h"
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
    case Kind::box: {
        const V3 core = h - V3{shape.round, shape.round, shape.round};
        return shape.round == 0 ? ls::box(vec(h)) : ls::rounded(ls::box(vec(core)), real(shape.round));
    }
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
    const auto count = static_cast<std::uint32_t>(scene.bodies.size()) +
                       static_cast<std::uint32_t>(scene.room + static_cast<int>(scene.walkers.size()));
    std::uint32_t shapes = count;
    for (const Body& body : scene.bodies) shapes += static_cast<std::uint32_t>(body.parts.size());
    ls::WorldDef def{.tick_rate = static_cast<std::uint32_t>(c.rate),
                     .gravity = vec(scene.gravity),
                     .integrator = static_cast<ls::Integrator>(c.scheme),
                     .continuous = scene.continuous,
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
        must(world.set_velocity(id, world.linear_velocity(id) + vec(change), world.angular_velocity(id)));
    }

    void walk(int walker, V3 velocity) override {
        const ls::CharacterId id = world.character_at(static_cast<std::uint32_t>(walker));
        must(world.set_character_input(id, {.velocity = vec(velocity)}));
    }

    void drive(int car, double throttle, double steer) override {
        const ls::VehicleId id = world.vehicle_at(static_cast<std::uint32_t>(car));
        must(world.set_vehicle_input(id, {.throttle = real(throttle), .steer = real(steer)}));
    }

    int add(const Body& body) override {
        ids.push_back(create(world, body));
        return static_cast<int>(ids.size()) - 1;
    }

    void replace(int number, const Body& body) override {
        ls::BodyId& id = ids[static_cast<std::size_t>(number)];
        must(world.destroy(id));
        id = create(world, body);
    }

    double cast_ray(V3 from, V3 way) const override {
        const auto hit = world.cast_ray({vec(from), vec(way)});
        return hit ? ls::to_double(hit->fraction) : 1;
    }

    double cast(int probe, V3 from, V3 way) const override {
        const auto hit =
            world.cast_shape(probes[static_cast<std::size_t>(probe)], standing_at(from), vec(way));
        return hit ? ls::to_double(hit->fraction) : 1;
    }

    int overlap(int probe, V3 at) const override {
        world.overlap(probes[static_cast<std::size_t>(probe)], standing_at(at), {}, overlapped);
        return static_cast<int>(overlapped.size());
    }

  private:
    friend ls::World& engines::world_of(Engine& engine);
    void tick() override { world.tick(); }
    static void must(const ls::Status& status) {
        if (!status) checked(ls::Result<int>(status.error()));
    }
    static ls::Transform standing_at(V3 place) { return {vec(place), ls::Quat::identity()}; }

    ls::World make(const Contestant& contestant, const Scene& scene) {
        auto library = std::make_shared<ls::AssetLibrary>();
        std::vector<ls::Geometry> geometries; // of each body: its shape, then its parts
        for (const Body& body : scene.bodies) {
            geometries.push_back(geometry_of(body.shape, *library));
            for (const Part& part : body.parts) geometries.push_back(geometry_of(part.shape, *library));
        }
        for (const Shape& probe : scene.probes) probes.push_back(geometry_of(probe, *library));
        ls::World made = checked(ls::World::create(def_of(contestant, scene), {}, library));
        std::span<const ls::Geometry> left = geometries;
        auto human = scene.humans.begin();
        for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
            const std::size_t count = 1 + scene.bodies[i].parts.size();
            if (human != scene.humans.end() && i == static_cast<std::size_t>(human->body))
                add(made, *human++);
            else if (i == ids.size()) // other bodies belong to the last human
                ids.push_back(create(made, scene.bodies[i], left.first(count)));
            left = left.subspan(count);
        }
        for (const Joint& one : scene.joints)
            if (!one.frames) join(made, one);
        add_played(made, scene);
        if (scene.attraction != 0) checked(made.create_field({.strength = real(scene.attraction)}));
        return made;
    }
    static ls::BodyId create(ls::World& made, const Body& body, std::span<const ls::Geometry> geometries) {
        const ls::BodyKind still = body.moves ? ls::BodyKind::kinematic : ls::BodyKind::static_;
        const ls::BodyId id =
            checked(made.create_body({.kind = body.mass == 0 ? still : ls::BodyKind::dynamic,
                                      .pose = {vec(body.position), quat(body.rotation)},
                                      .linear_velocity = vec(body.velocity),
                                      .angular_velocity = vec(body.spin),
                                      .mass = real(body.mass),
                                      .bullet = body.bullet}));
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
        return id;
    }

    /// Creates a body that has one primitive shape.
    static ls::BodyId create(ls::World& made, const Body& body) {
        ls::AssetLibrary none;
        const ls::Geometry geometry = geometry_of(body.shape, none);
        return create(made, body, {&geometry, 1});
    }

    void add(ls::World& made, const Human& human) {
        constexpr ls::UnitVec3 up{ls::Unit{}, ls::unit_one, ls::Unit{}};
        const ls::RagdollDef def{.place = {vec(human.at), ls::from_axis_angle(up, real(human.heading))},
                                 .linear_velocity = vec(human.velocity)};
        for (const ls::BodyId id : checked(ls::make_ragdoll(made, def)).bodies) ids.push_back(id);
    }

    /// Adds cars and characters.
    void add_played(ls::World& made, const Scene& scene) {
        for (const Car& car : scene.cars)
            checked(made.create_vehicle(
                ls::four_wheels(ids[static_cast<std::size_t>(car.chassis)], vec(car.hub))));
        for (const V3 feet : scene.walkers) checked(made.create_character({.position = vec(feet)}));
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
        if (joint.kind != Link::slider) soften(def.axis[ls::about_x], joint);
        if (joint.kind == Link::ball)
            for (const ls::JointAxisIndex i : {ls::about_y, ls::about_z}) soften(def.axis[i], joint);
        const ls::BodyId a = joint.a < 0 ? ls::BodyId{} : ids[static_cast<std::size_t>(joint.a)];
        checked(made.create_joint(def, a, ids[static_cast<std::size_t>(joint.b)],
                                  {vec(joint.anchor), quat(from_x_to(joint.axis))}));
    }

    static void soften(ls::JointAxis& axis, const Joint& joint) {
        axis.friction = real(joint.friction);
        if (joint.spring_hertz == 0) return;
        axis.spring = 1;
        axis.frequency = real(joint.spring_hertz), axis.damping_ratio = real(joint.spring_damping);
    }

    std::vector<ls::BodyId> ids;
    std::vector<ls::Geometry> probes;
    mutable std::vector<ls::ShapeId> overlapped;
    std::unique_ptr<ls::Tasks> tasks;
    ls::World world;
};

} // namespace

ls::World& world_of(Engine& engine) { return static_cast<Lockstone&>(engine).world; }

std::unique_ptr<Engine> make_lockstone(const Contestant& contestant, const Scene& scene) {
    return std::make_unique<Lockstone>(contestant, scene);
}

} // namespace engines
