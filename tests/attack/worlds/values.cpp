#include "values.h"
#include "support/rigs/scale_field.h"

#include <algorithm>

namespace attack {

std::uint32_t Values::integer(std::uint32_t low, std::uint32_t high, std::uint32_t usual) {
    if (below(8) >= wildness) return usual;
    const std::uint32_t which = below(4);
    return which == 0 ? low : which == 1 ? high : low + below(high - low + 1);
}

Real Values::between(Real low, Real high, Real usual) {
    if (below(8) >= wildness) return usual;
    const std::uint64_t width = static_cast<std::uint64_t>(high.raw) - static_cast<std::uint64_t>(low.raw);
    switch (below(8)) {
    case 0:
        return low;
    case 1:
    case 2:
        return high;
    case 3:
        return Real::from_raw(low.raw + (width > 0 ? 1 : 0));
    case 4:
        return Real::from_raw(high.raw - (width > 0 ? 1 : 0));
    case 5:
        return random.range(low, high);
    case 6: // by powers of two above the lower limit
        return Real::from_raw(
            static_cast<std::int64_t>(static_cast<std::uint64_t>(low.raw) + (width >> below(64))));
    default: // and below the upper one
        return Real::from_raw(
            static_cast<std::int64_t>(static_cast<std::uint64_t>(high.raw) - (width >> below(64))));
    }
}

Vec3 Values::each_within(Real most, Vec3 usual) {
    Vec3 v{};
    for (int i = 0; i < 3; ++i) v[i] = between(-most, most, usual[i]);
    return v;
}

Vec3 Values::as_long_as(Real most) {
    const Real long_as = between(Real{}, most - Real::step() * 16, min(most, Real(3)));
    const UnitVec3 along = direction();
    return lockstone::scale<Real>(along, long_as);
}

Quat Values::turn() {
    if (chance(3)) return Quat::identity();
    const UnitVec3 axis = direction();
    const Real angle = random.range(-pi, pi);
    return from_axis_angle(axis, angle);
}

UnitVec3 Values::direction() {
    if (chance(3)) return random.unit_vector();
    UnitVec3 v{};
    const int axis =
        static_cast<int>(below(3)); // one draw per statement: the evaluation order is unspecified
    v[axis] = chance(2) ? unit_one : -unit_one;
    return v;
}

Transform Values::near(Vec3 center, Real reach) {
    Transform t;
    for (int i = 0; i < 3; ++i) {
        const Real off = random.range(-reach, reach);
        t.position[i] = clamp(center[i] + off, Real(-1000000000), Real(1000000000));
    }
    t.rotation = turn();
    return t;
}

WorldDef world_def(Values& v) {
    WorldDef d;
    d.tick_rate = v.integer(1, 1000, 60);
    d.substeps = v.integer(1, 16, 8);
    d.gravity = v.each_within(Real(1000), d.gravity);
    d.integrator = static_cast<Integrator>(v.integer(0, 3, 0));
    d.bounds_shift = v.integer(0, 8, 0);
    d.bodies_max = 24, d.shapes_max = 48, d.joints_max = 16;
    d.contacts_max = v.integer(1, 512, 512);
    d.fields_max = 4, d.characters_max = 2, d.vehicles_max = 2, d.pair_filters_max = 4;
    d.continuous = v.integer(0, 1, 1);
    d.sleeping = v.integer(0, 1, 1);
    d.restitution_speed_min = v.between(Real{}, Real(500), d.restitution_speed_min);
    d.contact_hertz = v.between(Real(1), Real(4000), d.contact_hertz);
    d.contact_damping = v.between(0.1_r, Real(100), d.contact_damping);
    d.push_speed_max = v.between(Real{}, Real(500), d.push_speed_max);
    d.sleep_speed = v.between(Real{}, Real(10), d.sleep_speed);
    d.sleep_time = v.between(Real{}, Real(3600), d.sleep_time);
    return d;
}

BodyDef body_def(Values& v, const Transform& pose) {
    BodyDef d;
    d.pose = pose;
    const std::uint32_t kind = v.below(8);
    d.kind = kind == 0 ? BodyKind::static_ : kind == 1 ? BodyKind::kinematic : BodyKind::dynamic;
    d.locks = v.chance(6) ? v.below(64) : 0;
    d.linear_velocity = v.as_long_as(Real(500));
    d.angular_velocity = v.each_within(Real(4095));
    d.linear_damping = v.between(Real{}, Real(1000), Real{});
    d.angular_damping = v.between(Real{}, Real(1000), Real{});
    d.gravity_scale = v.between(Real(-100), Real(100), Real(1));
    d.drag_scale = v.between(Real{}, Real(100), Real(1));
    d.mass = v.between(0.001_r, Real(1000000000), Real{});
    d.gyroscopic = v.integer(0, 1, 1);
    d.enable_fields = v.integer(0, 1, 1);
    d.bullet = v.integer(0, 1, 0);
    d.user_key = v.key();
    // Decided by the key: one more draw would change the worlds of kept seeds, and none of their bodies sleep.
    d.awake = d.user_key % 13 == 7 ? 0 : 1;
    if (d.awake == 0) d.linear_velocity = d.angular_velocity = {};
    return d;
}

namespace {

Geometry primitive(Values& v) {
    const Real low = to<Real>(shape_size_min), high = to<Real>(shape_size_max), usual = half(Real(1));
    const Real a = v.between(low, high, usual), b = v.between(low, high, usual),
               c = v.between(low, high, usual);
    const Real rounding = v.between(Real{}, high - max(a, max(b, c)), Real{});
    switch (v.below(5)) {
    case 0:
        return sphere(a);
    case 1: {
        const Real segment = v.between(Real{}, high - a, usual);
        return capsule(a, segment);
    }
    case 2:
        return rounded(cylinder(a, b), rounding);
    case 3:
        return rounded(cone(a, b), rounding);
    default:
        return rounded(box(a, b, c), rounding);
    }
}

LengthVec3 factors(Values& v) {
    LengthVec3 f{};
    for (int i = 0; i < 3; ++i)
        f[i] = to<Length>(v.between(Real::from_raw(std::int64_t{1} << 25), Real(100), Real(1)));
    return f;
}

} // namespace

Geometry geometry(Values& v, BodyKind kind, const AssetLibrary& assets) {
    if (kind == BodyKind::static_ && v.chance(4)) return plane();
    if (v.chance(3)) {
        const std::vector<AssetId> ids = assets.ids();
        Geometry g = assets.geometry(ids[v.below(static_cast<std::uint32_t>(ids.size()))]).value();
        const bool is_terrain = g.kind == ShapeKind::mesh || g.kind == ShapeKind::height_field;
        if (is_terrain && kind == BodyKind::dynamic) return primitive(v);
        if (g.kind != ShapeKind::compound) g.scale = factors(v);
        if (g.kind == ShapeKind::hull) g.radius = to<Length>(v.between(Real{}, Real(50), Real{}));
        return g;
    }
    Geometry g = primitive(v);
    if (kind == BodyKind::static_) g = test::with_scale(g, Real(1 << v.integer(0, 3, 0)));
    return g;
}

ShapeDef shape_def(Values& v, BodyKind kind, const AssetLibrary& assets) {
    ShapeDef d;
    d.geometry = geometry(v, kind, assets);
    d.local.position = v.each_within(Real(64));
    d.local.rotation = v.turn();
    d.density = v.between(0.01_r, Real(100000), d.density);
    d.friction = v.between(Real{}, Real(4), d.friction);
    d.restitution = v.between(Real{}, Real(1), Real{});
    d.rolling_resistance = v.between(Real{}, Real(1), Real{});
    d.surface_velocity = v.each_within(Real(100));
    d.friction_mix = static_cast<Mix>(v.integer(0, 4, 0));
    d.restitution_mix = static_cast<Mix>(v.integer(0, 4, 4));
    d.sensor = v.chance(10) ? 1 : 0;
    d.one_way = v.chance(10) ? 1 : 0;
    d.material = v.bits();
    d.user_key = v.key();
    return d;
}

namespace {

JointAxis joint_axis(Values& v, const JointAxis& usual, bool swings, bool turns) {
    JointAxis a = usual;
    const Real reach = swings ? pi : Real(1000000);
    const Real tame = turns ? Real(1) : Real(2);
    a.mode = static_cast<AxisMode>(v.integer(0, 2, static_cast<std::uint32_t>(usual.mode)));
    a.lower = v.between(-reach, Real{}, -tame);
    a.upper = v.between(Real{}, reach, tame);
    a.frequency = v.between(0.001_r, Real(1000), usual.frequency);
    a.spring = a.frequency > Real{} ? v.integer(0, 1, usual.spring) : 0;
    a.damping_ratio = v.between(Real{}, Real(100), usual.damping_ratio);
    a.target = v.between(-reach, reach, usual.target);
    a.motor_speed = v.between(Real(-500), Real(500), Real{});
    a.motor_force = v.between(Real{}, Real(2000000000), Real{});
    a.friction = v.between(Real{}, Real(2000000000), Real{});
    a.spring_force = v.between(Real{}, Real(2000000000), Real{});
    return a;
}

JointDef usual_joint(Values& v) {
    const Real one = Real(1), hard = Real(1000);
    switch (v.below(12)) {
    case 0:
        return six_dof_joint();
    case 1:
        return ball_joint();
    case 2:
        return hinge_joint();
    case 3:
        return slider_joint();
    case 4:
        return weld_joint();
    case 5:
        return wheel_joint(one, one);
    case 6:
        return motor_joint(one, hard, hard);
    case 7:
        return mouse_joint(one, hard);
    case 8:
        return v.chance(2) ? rope_joint(one) : distance_joint(one);
    case 9:
        return pulley_joint({one, one, one}, {one, one, Real{}}, one * 3);
    case 10:
        return gear_joint(one);
    default:
        return rack_and_pinion_joint(one);
    }
}

} // namespace

JointDef joint_def(Values& v) {
    JointDef d = usual_joint(v);
    for (std::uint32_t i = 0; i < joint_axis_count; ++i)
        d.axis[i] = joint_axis(v, d.axis[i], i == about_y || i == about_z, i >= about_x);
    d.collide_connected = v.integer(0, 1, 0);
    d.frame_a.position = v.each_within(Real(1000000));
    d.frame_a.rotation = v.turn();
    d.frame_b.position = v.each_within(Real(1000000));
    d.frame_b.rotation = v.turn();
    if (d.kind == JointKind::ball) d.swing = v.between(Real{}, pi - Real::step(), Real{});
    d.ratio = v.between(0.001_r, Real(1000), Real(1));
    if (v.chance(2)) d.ratio = -d.ratio;
    d.ground_a = v.each_within(Real(1000000000), d.ground_a);
    d.ground_b = v.each_within(Real(1000000000), d.ground_b);
    d.break_force = v.between(Real{}, Real(2000000000), Real{});
    d.break_torque = v.between(Real{}, Real(2000000000), Real{});
    d.user_key = v.key();
    return d;
}

namespace {

template <std::size_t N> void bend(Values& v, std::array<CurvePoint, N>& curve) {
    for (CurvePoint& p : curve)
        p.x = v.between(Real{}, Real(1000), p.x), p.y = v.between(Real{}, Real(10), p.y);
    std::ranges::sort(curve, {}, &CurvePoint::x);
}

void change_wheel(Values& v, WheelDef& w) {
    w.attachment = v.each_within(Real(64), w.attachment);
    w.length_min = v.between(Real{}, Real(4), w.length_min);
    w.length_max = v.between(w.length_min, Real(4), max(w.length_min, w.length_max));
    w.preload = v.between(Real{}, Real(4), w.preload);
    w.frequency = v.between(0.1_r, Real(50), w.frequency);
    w.damping_compression = v.between(Real{}, Real(10), w.damping_compression);
    w.damping_rebound = v.between(Real{}, Real(10), w.damping_rebound);
    w.radius = v.between(0.01_r, Real(10), w.radius);
    w.width = v.between(0.01_r, Real(10), w.width);
    w.inertia = v.between(0.001_r, Real(1000000), w.inertia);
    w.steer_max = v.between(-1.3_r, 1.3_r, w.steer_max);
    w.brake_torque = v.between(Real{}, Real(100000000), w.brake_torque);
    w.hand_brake_torque = v.between(Real{}, Real(100000000), w.hand_brake_torque);
}

void change_train(Values& v, VehicleDef& d) {
    const Real torque = Real(100000000), engine = Real(10000000), ratio = Real(1000);
    EngineDef& e = d.engine;
    e.torque_max = v.between(Real{}, engine, e.torque_max);
    bend(v, e.torque);
    e.inertia = v.between(0.001_r, Real(100000), e.inertia);
    e.rpm_max = v.between(Real(10), Real(100000), e.rpm_max);
    e.rpm_idle = v.between(Real(1), e.rpm_max, min(e.rpm_idle, e.rpm_max));
    e.brake_torque = v.between(Real{}, engine, e.brake_torque);
    GearboxDef& g = d.gearbox;
    g.mode = static_cast<GearboxMode>(v.integer(0, 1, 0));
    for (Real& r : g.forward) r = v.between(0.001_r, ratio, max(r, Real(1)));
    g.forward_count = v.integer(1, vehicle_gears_max, g.forward_count);
    g.reverse = v.between(0.001_r, ratio, g.reverse);
    g.final_drive = v.between(0.001_r, ratio, g.final_drive);
    g.shift_time = v.between(Real{}, Real(10), g.shift_time);
    g.shift_pause = v.between(Real{}, Real(10), g.shift_pause);
    g.rpm_up = v.between(Real(1), Real(100000), g.rpm_up);
    g.rpm_down = v.between(Real{}, g.rpm_up, min(g.rpm_down, g.rpm_up));
    g.clutch_torque = v.between(Real{}, torque, g.clutch_torque);
    d.tracks.steer_ratio = v.between(0.001_r, Real(10000), d.tracks.steer_ratio);
    d.tracks.steer_torque = v.between(Real{}, torque, d.tracks.steer_torque);
    for (std::uint32_t i = 0; i < vehicle_couplings_max; ++i) {
        Differential& diff = d.differential[i];
        diff.kind = static_cast<DifferentialKind>(v.below(3));
        diff.wheels_a = 1u << v.below(d.wheel_count);
        diff.wheels_b = (1u << v.below(d.wheel_count)) & ~diff.wheels_a;
        diff.preload = v.between(Real{}, torque, diff.preload);
        diff.bias = v.between(Real{}, Real(10), diff.bias);
        d.anti_roll[i].wheel_a = v.below(d.wheel_count);
        d.anti_roll[i].wheel_b = v.below(d.wheel_count);
        d.anti_roll[i].stiffness = v.between(Real{}, Real(1000000000), Real{});
    }
}

} // namespace

VehicleDef vehicle_def(Values& v, BodyId chassis) {
    const Real x = v.between(Real{}, Real(64), Real(1)), z = v.between(Real{}, Real(64), Real(2));
    const Vec3 hub{x, Real{}, z};
    const std::uint32_t pairs = 1 + v.below(4);
    VehicleDef d = v.chance(2) ? four_wheels(chassis, hub) : two_tracks(chassis, hub, pairs);
    d.cast = static_cast<WheelCast>(v.below(3));
    for (std::uint32_t i = 0; i < d.wheel_count; ++i) change_wheel(v, d.wheel[i]);
    for (Tyre& t : d.tyre) {
        bend(v, t.along), bend(v, t.across);
        t.ground_friction = v.between(0.01_r, Real(4), t.ground_friction);
        t.rolling_resistance = v.between(Real{}, Real(1), t.rolling_resistance);
    }
    change_train(v, d);
    d.ackermann = v.between(Real{}, Real(1), Real(1));
    d.steer_speed = v.between(Real{}, Real(1000), Real{});
    d.user_key = v.key();
    return d;
}

VehicleInput vehicle_input(Values& v) {
    VehicleInput in;
    in.throttle = v.between(Real{}, Real(1), Real(1));
    in.brake = v.between(Real{}, Real(1), Real{});
    in.steer = v.between(Real(-1), Real(1), Real{});
    in.hand_brake = v.between(Real{}, Real(1), Real{});
    in.clutch = v.between(Real{}, Real(1), Real{});
    in.gear = static_cast<std::int32_t>(v.below(10)) - 1;
    return in;
}

CharacterDef character_def(Values& v, Vec3 at) {
    CharacterDef d;
    d.position = at;
    d.up = v.chance(2) ? d.up : v.direction();
    d.radius = v.between(0.05_r, Real(10), d.radius);
    const Real least = d.radius * 2 + 0.01_r;
    d.height = v.between(least, Real(50), max(least, d.height));
    d.crouch_height = v.between(least, d.height, clamp(d.crouch_height, least, d.height));
    d.slope_max = v.between(Real{}, 1.3_r, d.slope_max);
    d.step_height = v.between(Real{}, Real(10), d.step_height);
    d.step_down = v.between(Real{}, Real(10), d.step_down);
    d.mass = v.between(0.001_r, Real(1000000), d.mass);
    d.push_force = v.between(Real{}, Real(100000000), d.push_force);
    d.gravity = v.between(Real{}, Real(1000), d.gravity);
    d.fall_speed_max = v.between(0.1_r, Real(400), d.fall_speed_max);
    d.jump_speed = v.between(Real{}, Real(100), d.jump_speed);
    d.acceleration = v.between(Real{}, Real(1000000), d.acceleration);
    d.air_acceleration = v.between(Real{}, Real(1000000), d.air_acceleration);
    d.coyote_ticks = v.integer(0, 1000, 6);
    d.jump_buffer_ticks = v.integer(0, 1000, 6);
    d.user_key = v.key();
    return d;
}

FieldDef field_def(Values& v, Vec3 at) {
    FieldDef d;
    d.kind = static_cast<FieldKind>(v.below(4));
    d.center = v.chance(2) ? at : v.each_within(Real(1000000000));
    d.strength = v.between(Real(-100000000), Real(100000000), Real(10));
    d.softening = v.between(Real{}, Real(30000), Real(1));
    d.acceleration = v.each_within(Real(1000));
    d.velocity = v.as_long_as(Real(500));
    d.density = v.between(Real{}, Real(100000), Real(1000));
    d.drag_linear = v.between(Real{}, Real(1000000), Real(300));
    d.drag_quadratic = v.between(Real{}, Real(1000000), Real(500));
    d.drag_angular = v.between(Real{}, Real(1000000), Real(300));
    d.priority = static_cast<std::int32_t>(v.below(3));
    d.region.kind = static_cast<RegionKind>(v.below(3));
    d.region.pose.position = v.chance(2) ? at : v.each_within(Real(1000000000));
    d.region.pose.rotation = v.turn();
    for (int i = 0; i < 3; ++i) d.region.half_extent[i] = v.between(0.001_r, Real(1000000), Real(10));
    return d;
}

ExplosionDef explosion_def(Values& v, Vec3 at) {
    ExplosionDef d;
    d.center = v.chance(2) ? at : v.near(at, Real(20)).position;
    d.radius = v.between(0.001_r, Real(30000), Real(10));
    d.core = v.between(0.001_r, Real(30000), Real(1));
    d.impulse = v.between(Real(-100000000), Real(100000000), Real(100));
    d.falloff = static_cast<Falloff>(v.below(3));
    return d;
}

// ---- assets ----------------------------------------------------------------------------------------------------

namespace {

AssetBytes hull_of(std::int32_t half_raw) {
    std::vector<LengthVec3> points;
    for (int i = 0; i < 8; ++i) {
        const auto at = [&](int bit) { return Length::from_raw((i >> bit & 1) != 0 ? half_raw : -half_raw); };
        points.push_back({at(0), at(1), at(2)});
    }
    return bake_hull(points).value();
}

const MaterialSurface surfaces[] = {{1, Real(4), Real(1), Real(1), {Real(100), Real(-100), Real{}}},
                                    {65535, Real{}}};

AssetBytes mesh_of(Real reach, bool two_sided) {
    const Vec3 vertices[] = {{-reach, Real{}, -reach},
                             {reach, Real{}, -reach},
                             {-reach, Real{}, reach},
                             {reach, half(reach), reach},
                             {Real{}, -reach, Real{}}};
    const std::array<std::uint32_t, 3> triangles[] = {{0, 2, 1}, {1, 2, 3}, {0, 1, 4}};
    const std::uint16_t materials[] = {1, 65535, 3};
    return bake_mesh({.vertices = vertices,
                      .triangles = triangles,
                      .materials = materials,
                      .surfaces = surfaces,
                      .two_sided = two_sided})
        .value();
}

AssetBytes height_field_of(std::uint32_t samples, Length spacing, Length height) {
    std::vector<Length> heights(samples * samples);
    std::vector<std::uint8_t> cells((samples - 1) * (samples - 1));
    for (std::size_t i = 0; i < heights.size(); ++i) heights[i] = i % 3 == 0 ? height : -height;
    for (std::size_t i = 0; i < cells.size(); ++i)
        cells[i] = static_cast<std::uint8_t>(i % 7 == 6 ? 255 : i % 255);
    return bake_height_field({.columns = samples,
                              .rows = samples,
                              .spacing = spacing,
                              .heights = heights,
                              .cells = cells,
                              .surfaces = surfaces})
        .value();
}

} // namespace

AssetLibrary assets_at_limits() {
    AssetLibrary library;
    const auto add = [&](const AssetBytes& bytes) { return library.add(bytes).value(); };
    const AssetId small = add(hull_of(1 << 16)); // 4 mm
    const AssetId large = add(hull_of(shape_size_max.raw));
    add(mesh_of(Real(8000), false)), add(mesh_of(Real(8000), true)), add(mesh_of(0.01_r, false));
    add(height_field_of(64, Length(125), shape_size_max));
    add(height_field_of(3, shape_size_min, Length::from_raw(1 << 14)));
    const Geometry far_box = box(Real(100), 0.0025_r, Real(100));
    const CompoundPart parts[] = {
        {far_box, {{Real(100), Real(100), Real(-100)}, Quat::identity()}},
        {sphere(0.0025_r), {{Real(-100), Real(100), Real(-100)}, Quat::identity()}},
        {instance(ShapeKind::hull, large), Transform::identity()},
        {instance(ShapeKind::hull, small), {{Real(100), Real{}, Real{}}, Quat::identity()}}};
    add(bake_compound(parts).value());
    const CompoundPart few[] = {{sphere(0.0025_r), Transform::identity()},
                                {capsule(0.0025_r, Real{}), {{0.004_r, Real{}, Real{}}, Quat::identity()}}};
    add(bake_compound(few).value());
    return library;
}

} // namespace attack
