// The small worlds of the self test. Each random draw is its own statement, as compilers differ in the order in which
// they compute the arguments of a call.
#include "prove/random_world.h"

#include <algorithm>
#include <utility>

namespace lockstone::proofs {

namespace {

constexpr Real spacing = 1_r; ///< [m], of the grid on which bodies start

/// Capacity that is reserved at the start.
constexpr WorldRows rows{
    .bodies = 64, .shapes = 64, .contacts = 256, .fields = 4, .pair_filters = 8, .joints = 16};

WorldDef definition(std::uint64_t seed) {
    WorldDef def;
    def.substeps = static_cast<std::uint32_t>(1 + seed % 3);
    def.integrator = static_cast<Integrator>(seed % 4);
    def.restitution_speed_min = 0.25_r;
    // The sleep speed is above the speed of many bodies, so that islands fall asleep and wake within the ticks of a
    // test.
    def.sleep_speed = seed % 2 == 0 ? 0.4_r : 0.03_r;
    def.sleep_time = 0.02_r;
    def.seed = seed;
    return def;
}

/// A core of any kind that needs no asset.
Geometry primitive(std::uint32_t kind, Real a, Real b) {
    switch (kind) {
    case 0:
        return sphere(a);
    case 1:
        return capsule(a * 0.6_r, b);
    case 2:
        return cylinder(a, b);
    case 3:
        return cone(a, b);
    case 4:
        return box(a, b, a * 0.75_r);
    case 5:
        return rounded(box(b, a, b), 0.05_r);
    case 6:
        return rounded(cylinder(b, a), 0.04_r);
    default:
        return rounded(cone(b, b), 0.03_r);
    }
}

JointDef limited_hinge() {
    JointDef def = hinge_joint();
    JointAxis& axis = def.axis[about_x];
    axis.mode = AxisMode::limited, axis.lower = -0.5_r, axis.upper = 0.25_r;
    axis.motor_speed = 3_r, axis.motor_force = 200_r;
    return def;
}

JointDef sprung_slider() {
    JointDef def = slider_joint();
    JointAxis& axis = def.axis[along_x];
    axis.spring = 1, axis.frequency = 4_r, axis.damping_ratio = 0.5_r, axis.target = 0.2_r;
    return def;
}

JointDef loose_six() {
    JointDef def = six_dof_joint();
    for (JointAxis& axis : def.axis) axis.mode = AxisMode::limited, axis.lower = -0.1_r, axis.upper = 0.1_r;
    def.axis[about_y].friction = 20_r;
    return def;
}

JointDef cone_ball() {
    JointDef def = ball_joint();
    def.swing = 0.4_r;
    return def;
}

constexpr std::uint32_t joints_made = 10;
JointDef joint(std::uint32_t kind) {
    switch (kind) {
    case 0:
        return cone_ball();
    case 1:
        return limited_hinge();
    case 2:
        return sprung_slider();
    case 3:
        return weld_joint(6_r, 0.7_r);
    case 4:
        return wheel_joint(3_r, 0.8_r);
    case 5:
        return motor_joint(2_r, 500_r, 200_r);
    case 6:
        return loose_six();
    case 7:
        return gear_joint(2_r);
    case 8:
        return rope_joint(spacing);
    default:
        return spring_joint(1_r, 3_r, 0.5_r);
    }
}

} // namespace

template <class T> T RandomWorld::taken(Result<T> result) {
    if (result) return std::move(*result);
    if (!refusal) refusal = result.error();
    return T{};
}
void RandomWorld::taken(const Status& status) {
    if (!status && !refusal) refusal = status.error();
}

Vec3 RandomWorld::within(Real most) {
    Vec3 v;
    v.x = between(-most, most);
    v.y = between(-most, most);
    v.z = between(-most, most);
    return v;
}
Quat RandomWorld::turn() {
    const UnitVec3 axis = random.unit_vector();
    return from_axis_angle(axis, between(0_r, pi));
}

ShapeDef RandomWorld::shape() {
    ShapeDef def;
    const std::uint32_t kind = random.below(12); // 8 and more: a sphere or a box
    const Real a = between(0.2_r, 0.44_r);
    def.geometry = primitive(kind < 8 ? kind : kind % 2 * 4, a, between(0.15_r, 0.4_r));
    def.density = between(100_r, 2000_r);
    def.friction = between(0_r, 1_r);
    if (one_of(2)) def.restitution = between(0.1_r, 0.9_r);
    if (one_of(3)) def.rolling_resistance = between(0.01_r, 0.1_r);
    if (one_of(8)) def.surface_velocity = within(2_r);
    def.restitution_mix = static_cast<Mix>(random.below(5));
    return def;
}

void RandomWorld::add_shapes(BodyId body) {
    const std::uint32_t count = one_of(10) ? 2 : 1;
    for (std::uint32_t i = 0; i < count; ++i) {
        ShapeDef def = shape();
        if (i > 0) def.local.position = within(0.3_r), def.local.rotation = turn();
        taken(world.create_shape(body, def));
    }
}

void RandomWorld::add_body(const Transform& pose) {
    BodyDef def;
    def.pose = pose;
    if (one_of(6)) {
        def.awake = 0;
    } else {
        def.linear_velocity = within(one_of(40) ? 30_r : 2_r);
        def.angular_velocity = within(one_of(24) ? 40_r : 3_r);
    }
    if (one_of(5)) def.locks = random.below(64);
    if (one_of(4)) def.linear_damping = between(0_r, 2_r);
    if (one_of(4)) def.angular_damping = between(0_r, 2_r);
    if (one_of(6)) def.gravity_scale = between(-1_r, 2_r);
    def.gyroscopic = one_of(6) ? 0 : 1;
    def.bullet = one_of(40) ? 1 : 0;
    const BodyId body = taken(world.create_body(def));
    add_shapes(body);
    bodies.push_back(body);
}

void RandomWorld::add_scenery(std::uint64_t seed) {
    const BodyId floor = taken(world.create_body({.kind = BodyKind::static_}));
    ShapeDef ground{.geometry = plane(), .friction = 0.5_r, .restitution = 0.3_r};
    if (seed % 3 == 1) ground.surface_velocity = {1_r, 0_r, 0.5_r};
    taken(world.create_shape(floor, ground));

    BodyDef ramp{.kind = BodyKind::static_};
    ramp.pose = {{2_r, 0.2_r, 0_r}, turn()};
    Geometry slab = box(0.4_r, 0.2_r, 0.6_r);
    slab.scale = {Length(2), Length(2), Length(2)};
    taken(world.create_shape(taken(world.create_body(ramp)), {.geometry = slab}));

    BodyDef paddle{.kind = BodyKind::kinematic};
    paddle.pose.position = {-0.5_r, 0.5_r, 0_r};
    paddle.linear_velocity = {0.5_r, 0_r, 0_r}, paddle.angular_velocity = {0_r, 2_r, 0.5_r};
    taken(world.create_shape(taken(world.create_body(paddle)), {.geometry = box(1_r, 0.3_r, 0.1_r)}));
}

void RandomWorld::add_fields(std::uint64_t seed) {
    const Region low{.kind = RegionKind::box,
                     .pose = {{0_r, -0.5_r, 0_r}, Quat::identity()},
                     .half_extent = {3_r, 1.5_r, 3_r}};
    if (seed % 4 == 1) taken(world.create_field(water(low)));
    if (seed % 4 == 2) taken(world.create_field(wind({8_r, 0_r, 3_r})));
    if (seed % 5 == 4) {
        taken(world.set_gravity({}));
        taken(world.create_field({.center = {0_r, 2_r, 0_r}, .strength = 30_r, .softening = 0.5_r}));
        taken(world.create_field({.kind = FieldKind::spring, .center = {1_r, 1_r, 0_r}, .strength = 2_r}));
    }
    if (seed % 7 == 3)
        taken(world.create_field({.kind = FieldKind::uniform, .acceleration = {2_r, 1_r, 0_r}}));
}

void RandomWorld::add_bodies(std::uint64_t seed) {
    // More pairs than a chunk of contacts has, so that workers share them; one world has more bodies than a chunk.
    const std::uint32_t count = seed % 20 == 10 ? 34 : 14 + random.below(3);
    for (std::uint32_t i = 0; i < count; ++i) {
        Transform pose;
        pose.position.x = spacing * Real(static_cast<int>(i % 3) - 1);
        pose.position.y = 0.35_r + spacing * Real(static_cast<int>(i / 9));
        pose.position.z = spacing * Real(static_cast<int>(i / 3 % 3) - 1);
        pose.position = pose.position + within(0.1_r);
        pose.rotation = turn();
        add_body(pose);
    }
}

void RandomWorld::join(JointDef def, BodyId a, BodyId b) {
    if (def.kind == JointKind::distance) {
        def.body_a = a, def.body_b = b;
        taken(world.create_joint(def));
        return;
    }
    Transform at = world.pose(b);
    at.rotation = turn();
    taken(world.create_joint(def, a, b, at));
}

/// Adds a chain of joints of several kinds; every third world has three joints, the others six.
void RandomWorld::add_joints(std::uint64_t seed) {
    const std::uint32_t count = seed % 3 == 0 ? 3 : 6;
    for (std::uint32_t i = 0; i < count; ++i) {
        JointDef def = joint(static_cast<std::uint32_t>((seed + i) % joints_made));
        if (one_of(4)) def.break_force = 500_r;
        join(def, bodies[i], bodies[i + 1]);
    }
}

Result<RandomWorld> RandomWorld::make(std::uint64_t seed) {
    Result<World> world = World::create(definition(seed));
    if (!world) return world.error();
    RandomWorld made(std::move(*world), Random::seeded(seed, 1));
    if (Status room = made.world.reserve(rows); !room) return room.error();
    made.add_scenery(seed);
    made.add_bodies(seed);
    if (!made.refusal) made.add_joints(seed); // needs the poses of the bodies
    made.add_fields(seed);
    if (made.refusal) return *made.refusal;
    made.world.save(made.start.image);
    made.start.random = made.random, made.start.bodies = made.bodies;
    return made;
}

void RandomWorld::rewind() {
    world.restore(start.image);
    random = start.random, bodies = start.bodies, refusal.reset();
}

void RandomWorld::command() {
    const BodyId body = any_body();
    const Vec3 v = within(4_r), w = within(6_r);
    const Vec3 point = world.center_of_mass(body) + Vec3{0.1_r, 0.05_r, 0_r};
    switch (random.below(13)) {
    case 0:
        return taken(world.add_force(body, v * 100_r, w * 5_r));
    case 1:
        return taken(world.add_force_at(body, v * 100_r, point));
    case 2:
        return taken(world.add_impulse(body, v * 5_r, w));
    case 3:
        return taken(world.add_impulse_at(body, v * 5_r, point));
    case 4:
        return taken(world.set_velocity(body, v, w));
    case 5:
        return taken(world.set_pose(body, {Vec3{v.x * 0.25_r, 2_r, v.z * 0.25_r}, turn()}));
    case 6: {
        SetBodyParameters change{.body = body};
        change.locks = random.below(64), change.linear_damping = between(0_r, 1_r);
        return taken(world.set_body_parameters(change));
    }
    case 7: {
        SetMaterial change{.shape = world.shapes(body).front()};
        change.friction = between(0_r, 2_r), change.restitution = between(0_r, 1_r);
        return taken(world.set_material(change));
    }
    case 8:
        return taken(world.explode({.center = point + v * 0.25_r, .radius = 3_r, .impulse = 60_r}));
    case 9:
        return add_body({Vec3{v.x * 0.25_r, 3_r, v.z * 0.25_r}, turn()});
    case 10:
        if (bodies.size() < 12) return taken(world.wake_body(body));
        bodies.erase(std::ranges::find(bodies, body));
        return taken(world.destroy(body));
    case 11:
        return taken(
            world.set_pair_filter(body, bodies.front() == body ? bodies.back() : bodies.front(), false));
    default:
        return taken(world.set_gravity(Vec3{0_r, -10_r, 0_r} + v * 0.5_r));
    }
}

Status RandomWorld::step() {
    for (std::uint32_t left = random.below(4); left > 0 && !refusal; --left) command();
    if (refusal) return *refusal;
    world.tick();
    return {};
}

} // namespace lockstone::proofs
