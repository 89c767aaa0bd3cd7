// Definitions of bodies, shapes, ground, joints and fields.
#include "drawer.h"

namespace worlds {

Geometry Drawer::of_asset(ShapeKind kind) {
    std::vector<Geometry> of_kind = ordinary_assets(kind);
    if (kind == ShapeKind::compound) of_kind.pop_back(); // the floor
    Geometry g = of_kind[v.below(static_cast<std::uint32_t>(of_kind.size()))];
    if (kind != ShapeKind::hull) return g;
    if (v.chance(4))
        for (int i = 0; i < 3; ++i) g.scale[i] = to<Length>(range(0.5_r, 1.5_r));
    if (v.chance(4)) g.radius = to<Length>(0.05_r);
    return g;
}

Geometry Drawer::solid() {
    if (is_stacked()) return box(0.4_r, 0.4_r, 0.4_r);
    if (is_now(Feature::hulls, 2)) return of_asset(ShapeKind::hull);
    if (is_now(Feature::compounds, 3)) return of_asset(ShapeKind::compound);
    const Real a = range(0.1_r, 0.45_r), b = range(0.1_r, 0.45_r), c = range(0.1_r, 0.45_r);
    switch (v.below(9)) {
    case 0:
        return sphere(a);
    case 1:
        return capsule(half(a), b);
    case 2:
        return cylinder(a, b);
    case 3:
        return cone(a, b);
    case 4:
        return rounded(box(a, b, c), 0.05_r);
    case 5:
    case 6:
        return box(0.4_r, 0.4_r, 0.4_r);
    case 7: // a pole or a plate
        return v.chance(2) ? box(0.03_r, 0.03_r, Real(1)) : box(0.6_r, 0.02_r, 0.6_r);
    default:
        return box(a, b, c);
    }
}

BodyDef Drawer::body_def(Vec3 at) {
    BodyDef d;
    if (is_now(Feature::wild, 2)) {
        const Transform pose{at, v.turn()};
        d = attack::body_def(v, pose);
        d.user_key = ++keys;
        return d;
    }
    d.pose.position = at;
    if (v.chance(3) && !is_stacked()) d.pose.rotation = v.turn();
    if (v.chance(4) && !is_stacked()) d.linear_velocity = vector(Real(6));
    if (v.chance(6) && !is_stacked()) d.angular_velocity = vector(Real(8));
    if (is_now(Feature::kinematic, drivers_of)) {
        d.kind = BodyKind::kinematic;
        d.linear_velocity = vector(Real(1)), d.angular_velocity = vector(Real(2));
        if (is_stacked())
            d.pose.position.y =
                d.pose.position.y + Real(100); // above the towers, as characters are beside them
    }
    if (is_now(Feature::locks, 3)) d.locks = 1 + v.below(63);
    if (is_now(Feature::bullets, 4))
        d.bullet = 1, d.linear_velocity = vector(v.chance(3) ? Real(280) : Real(60));
    if (is_now(Feature::no_gyroscope, 3)) d.gyroscopic = 0;
    if (is_now(Feature::damping, 3))
        d.linear_damping = range(Real{}, Real(3)), d.angular_damping = range(Real{}, Real(3));
    if (is_now(Feature::gravity_scales, 4)) d.gravity_scale = range(Real(-1), Real(2));
    if (is_now(Feature::masses, 4)) d.mass = range(0.1_r, Real(200));
    // Far beyond the range of a factor of a tree of joints.
    if (is_now(Feature::masses, 16)) d.mass = v.chance(2) ? 0.001_r : Real(1000000000);
    if (is_now(Feature::fields, 8)) d.enable_fields = 0;
    if (is_now(Feature::fluids, 4)) d.drag_scale = range(Real{}, Real(3));
    if (is_now(Feature::starts_asleep, 2) && d.kind == BodyKind::dynamic)
        d.awake = 0, d.linear_velocity = d.angular_velocity = {};
    d.user_key = ++keys;
    return d;
}

ShapeDef Drawer::shape_def(bool is_dynamic) {
    ShapeDef d;
    if (is_now(Feature::wild, 2)) {
        d = attack::shape_def(v, is_dynamic ? BodyKind::dynamic : BodyKind::static_, *story_assets());
        d.user_key = ++keys;
        return d;
    }
    d.geometry = solid();
    if (v.chance(10)) d.local.position = vector(0.2_r), d.local.rotation = v.turn();
    if (v.chance(3)) d.density = range(Real(100), Real(3000));
    if (v.chance(2)) d.friction = range(Real{}, Real(1));
    if (is_now(Feature::bounces, 2)) d.restitution = range(0.1_r, Real(1));
    if (is_now(Feature::rolls, 2)) d.rolling_resistance = range(0.001_r, 0.1_r);
    if (is_now(Feature::slides, 4)) d.surface_velocity = vector(Real(2));
    if (is_now(Feature::one_way, 6)) d.one_way = 1;
    if (is_now(Feature::sensors, 6)) d.sensor = 1;
    if (is_now(Feature::groups, 2)) {
        d.category = 1u << v.below(3), d.mask = v.chance(2) ? 0xffffffffu : 1 + v.below(7);
        d.group = static_cast<std::int32_t>(v.below(5)) - 2;
    }
    d.friction_mix = static_cast<Mix>(v.below(5)), d.restitution_mix = static_cast<Mix>(v.below(5));
    d.material = v.below(5);
    d.user_key = ++keys;
    return d;
}

Assembly Drawer::assembly(Vec3 at) {
    Assembly out{body_def(center + at), {}};
    for (std::uint32_t i = v.chance(8) ? 2 + v.below(2) : 1; i > 0; --i)
        out.shapes.push_back(shape_def(out.body.kind == BodyKind::dynamic));
    return out;
}

std::vector<Assembly> Drawer::ground() {
    std::vector<Assembly> out;
    const auto add = [&](const Geometry& geometry, Vec3 at) {
        BodyDef body{.kind = BodyKind::static_};
        body.pose.position = center + at, body.user_key = ++keys;
        ShapeDef shape{.geometry = geometry};
        if (is_now(Feature::bounces, 2)) shape.restitution = range(Real{}, Real(1));
        if (is_now(Feature::rolls, 4)) shape.rolling_resistance = 0.02_r;
        if (is_now(Feature::slides, 3)) shape.surface_velocity = {range(Real(-2), Real(2)), Real{}, Real(1)};
        shape.user_key = ++keys;
        out.push_back({body, {shape}});
    };
    const std::uint32_t kind = v.below(6);
    if (has(Feature::meshes) && kind < 3) {
        const std::vector<Geometry> meshes = ordinary_assets(ShapeKind::mesh);
        add(meshes[v.below(2)], {});
    } else if (has(Feature::height_fields) && kind < 4) {
        const std::vector<Geometry> terrains = ordinary_assets(ShapeKind::height_field);
        add(terrains[v.below(2)], {-side - Real(2), Real{}, -side - Real(2)});
    } else if (has(Feature::compounds) && kind < 5) {
        add(ordinary_assets(ShapeKind::compound).back(), {Real{}, -0.3_r, Real{}});
    } else if (kind == 5) {
        add(box(min(Real(90), side + Real(20)), Real(1), min(Real(90), side + Real(20))),
            {Real{}, Real(-1), Real{}});
    }
    if (out.empty() || v.chance(2)) add(plane(), {Real{}, out.empty() ? Real{} : Real(-3), Real{}});
    if (arrangement != Arrangement::wide_pit && arrangement != Arrangement::deep_pit) return out;
    const Real wide = min(Real(90), side + Real(1));
    for (int i = 0; i < 4; ++i) {
        const Real off = i % 2 == 0 ? side + Real(1) : -side - Real(1);
        if (i < 2)
            add(box(0.5_r, Real(6), wide), {off, Real(5), Real{}});
        else
            add(box(wide, Real(6), 0.5_r), {Real{}, Real(5), off});
    }
    return out;
}

JointDef Drawer::joint_def() {
    JointDef d = attack::joint_def(v);
    if (!has(Feature::wild)) {
        d.ground_a = center + Vec3{Real(-1), Real(8), Real{}},
        d.ground_b = center + Vec3{Real(1), Real(8), Real{}};
        for (JointAxis& a : d.axis) {
            if (is_now(Feature::joint_limits, 3) && a.mode != AxisMode::locked)
                a.mode = AxisMode::limited, a.lower = range(Real(-1), Real{}),
                a.upper = range(Real{}, Real(1));
            if (is_now(Feature::joint_springs, 3))
                a.frequency = range(0.5_r, Real(20)), a.spring = a.mode == AxisMode::locked ? 0 : 1,
                a.target = range(-0.5_r, 0.5_r), a.damping_ratio = range(Real{}, Real(2));
            if (is_now(Feature::joint_motors, 3))
                a.motor_speed = range(Real(-6), Real(6)), a.motor_force = range(Real{}, Real(2000));
            if (is_now(Feature::joint_friction, 3)) a.friction = range(Real{}, Real(50));
        }
        if (is_now(Feature::joints_break, 2)) {
            d.break_force = range(Real(10), Real(5000));
            if (v.chance(2)) d.break_torque = range(Real(10), Real(2000));
        }
    }
    d.user_key = ++keys;
    return d;
}

FieldDef Drawer::field_def() {
    if (is_now(Feature::wild, 2)) return attack::field_def(v, center);
    FieldDef d;
    d.region.kind = static_cast<RegionKind>(v.below(3));
    d.region.pose.position = center, d.region.pose.rotation = v.turn();
    d.region.half_extent = {side + Real(1), Real(2), side + Real(1)};
    if (has(Feature::fluids) && (!has(Feature::fields) || v.chance(2))) {
        d = water(d.region);
        if (v.chance(2)) d.velocity = vector(Real(2));
        d.priority = static_cast<std::int32_t>(v.below(3));
        return d;
    }
    d.kind = static_cast<FieldKind>(v.below(3));
    d.center = center + vector(side);
    d.strength = range(Real(-20), Real(20)), d.softening = Real(1);
    d.acceleration = vector(Real(8));
    return d;
}

} // namespace worlds
