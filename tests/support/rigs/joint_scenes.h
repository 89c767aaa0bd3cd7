// Two bodies and a joint of any kind in a world, and the joint's constraints, measured in double precision without the
// engine.
#pragma once

#include "lockstone/math/random.h"
#include "support/sim_scenes.h"

namespace lockstone::test::scene {

inline constexpr JointKind joint_kinds[] = {JointKind::six_dof, JointKind::ball,  JointKind::hinge,
                                            JointKind::slider,  JointKind::weld,  JointKind::wheel,
                                            JointKind::motor,   JointKind::mouse, JointKind::distance,
                                            JointKind::pulley,  JointKind::gear,  JointKind::rack_and_pinion};

/// A definition without gravity and sleep.
inline WorldDef bare_def() {
    WorldDef def = weightless();
    def.bodies_max = def.shapes_max = 16;
    def.joints_max = 16;
    def.contacts_max = 64;
    def.sleeping = 0;
    return def;
}
inline World bare_world() { return made(World::create(bare_def())); }
inline World heavy_world() {
    WorldDef def = bare_def();
    def.gravity = vec(0, -9.81, 0);
    return made(World::create(def));
}

/// A crate of 1 m and 1000 kg, and another 2 m along x; the joint's place is between them.
struct Jointed {
    World world;
    BodyId a, b;
    JointId joint;
    JointId axle_a{}, axle_b{}; ///< of gears and racks: the axles of A and B to the world
};

inline JointDef plain_joint(JointKind kind) {
    switch (kind) {
    case JointKind::six_dof:
        return six_dof_joint();
    case JointKind::ball:
        return ball_joint();
    case JointKind::hinge:
        return hinge_joint();
    case JointKind::slider:
        return slider_joint();
    case JointKind::weld:
        return weld_joint();
    case JointKind::wheel:
        return wheel_joint(Real(2), Real(1));
    case JointKind::motor:
        return motor_joint(Real(1), Real(50000), Real(20000));
    case JointKind::mouse:
        return mouse_joint(Real(1), Real(50000));
    case JointKind::distance:
        return distance_joint(Real(1));
    case JointKind::pulley:
        return pulley_joint(vec(-1, 3, 0), vec(1, 3, 0), Real(6));
    case JointKind::gear:
        return gear_joint(Real(2));
    default:
        return rack_and_pinion_joint(Real(2));
    }
}

/// `turn`: the rotation of the joint's frame.
inline Jointed join_two(JointKind kind, JointDef def, Quat turn = Quat::identity(),
                        WorldDef world_def = bare_def()) {
    Jointed j{made(World::create(world_def)), {}, {}, {}};
    j.a = add_crate(j.world, at(-1, 0, 0)), j.b = add_crate(j.world, at(1, 0, 0));
    def.kind = kind;
    if (kind == JointKind::distance ||
        kind == JointKind::pulley) { // between the origins; or faces that are opposite each other
        def.body_a = j.a, def.body_b = j.b;
        if (kind == JointKind::distance) def.frame_a = at(0.5, 0, 0), def.frame_b = at(-0.5, 0, 0);
        j.joint = made(j.world.create_joint(def));
        return j;
    }
    if (kind == JointKind::gear || kind == JointKind::rack_and_pinion) {
        j.axle_a = made(j.world.create_joint(hinge_joint(), {}, j.a, at(-1, 0, 0, turn)));
        const JointDef other = kind == JointKind::gear ? hinge_joint() : slider_joint();
        j.axle_b = made(j.world.create_joint(other, {}, j.b, at(1, 0, 0, turn)));
    }
    j.joint = made(j.world.create_joint(def, j.a, j.b, at(0, 0, 0, turn)));
    return j;
}
inline Jointed join_two(JointKind kind) { return join_two(kind, plain_joint(kind)); }

// ---- measured in double ---------------------------------------------------------------------------------------

using Columns3 = std::array<D3, 3>; ///< the axes of a frame
struct Place {
    D3 at;
    Columns3 axes;
};
inline Columns3 axes_of(const std::array<double, 4>& q) {
    const auto [x, y, z, w] = q;
    return {D3{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
            D3{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
            D3{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}
inline D3 carried(const Columns3& axes, D3 v) { return v[0] * axes[0] + v[1] * axes[1] + v[2] * axes[2]; }
inline Place place_of(const World& w, BodyId body, const Transform& frame) {
    const Columns3 local = axes_of(to_double(frame.rotation));
    if (!body) return {to_double(frame.position), local};
    const Transform pose = w.pose(body);
    const Columns3 axes = axes_of(to_double(pose.rotation));
    return {to_double(pose.position) + carried(axes, to_double(frame.position)),
            {carried(axes, local[0]), carried(axes, local[1]), carried(axes, local[2])}};
}
inline D3 crossed(D3 a, D3 b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double angle_between(D3 a, D3 b) { return std::atan2(length(crossed(a, b)), dot(a, b)); }

/// The translation of B's frame along, and its rotation about, each of A's axes.
struct Offset {
    D3 along;    ///< [m]
    D3 about;    ///< rotation vector [rad]
    double tilt; ///< angle between the two x axes
};
inline Offset offset_of(const Place& a, const Place& b) {
    const D3 s = b.at - a.at;
    const auto m = [&](std::size_t i, std::size_t k) { return dot(a.axes[i], b.axes[k]); };
    const D3 skew{m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)};
    const double sine = length(skew) / 2, angle = std::atan2(sine, (m(0, 0) + m(1, 1) + m(2, 2) - 1) / 2);
    return {{dot(s, a.axes[0]), dot(s, a.axes[1]), dot(s, a.axes[2])},
            (sine < 1e-12 ? 0.5 : angle / (2 * sine)) * skew,
            angle_between(a.axes[0], b.axes[0])};
}
inline Offset offset_of(const World& w, JointId joint) {
    const JointDef def = w.joint(joint);
    return offset_of(place_of(w, def.body_a, def.frame_a), place_of(w, def.body_b, def.frame_b));
}

/// The violation of the constraints of a joint of `kind` [m], angles times 1 m.
inline double violation(const Jointed& j, JointKind kind) {
    const JointDef def = j.world.joint(j.joint);
    const Place a = place_of(j.world, def.body_a, def.frame_a),
                b = place_of(j.world, def.body_b, def.frame_b);
    const Offset o = offset_of(a, b);
    const double apart = length(o.along), turned_by = length(o.about);
    const auto coordinate = [&](JointId id, JointAxisIndex i) {
        return to_double(j.world.joint_state(id).position[i]);
    };
    switch (kind) {
    case JointKind::ball:
        return apart;
    case JointKind::hinge:
        return std::max(apart, o.tilt);
    case JointKind::slider:
        return std::max({std::abs(o.along[1]), std::abs(o.along[2]), turned_by});
    case JointKind::weld:
        return std::max(apart, turned_by);
    case JointKind::wheel:
        return std::max({std::abs(o.along[0]), std::abs(o.along[2]), o.tilt});
    case JointKind::distance:
        return std::abs(apart - to_double(def.axis[0].target));
    case JointKind::pulley:
        return std::abs(length(a.at - to_double(def.ground_a)) +
                        to_double(def.ratio) * length(b.at - to_double(def.ground_b)) -
                        to_double(def.axis[0].target));
    case JointKind::gear:
        return std::abs(coordinate(j.axle_a, about_x) + to_double(def.ratio) * coordinate(j.axle_b, about_x));
    case JointKind::rack_and_pinion:
        return std::abs(coordinate(j.axle_a, about_x) - to_double(def.ratio) * coordinate(j.axle_b, along_x));
    default:
        return 0;
    }
}

/// The axes along and about which B is free relative to A, by index.
inline std::vector<std::uint32_t> free_axes(JointKind kind) {
    switch (kind) {
    case JointKind::ball:
        return {3, 4, 5};
    case JointKind::hinge:
        return {3};
    case JointKind::slider:
        return {0};
    case JointKind::weld:
        return {};
    case JointKind::wheel:
        return {1, 3};
    default:
        return {0, 1, 2, 3, 4, 5};
    }
}

/// Forces [N] and torques [N m] on both bodies, in all directions. A seed and a tick always give equal loads.
struct Loads {
    Random random;
    double force, torque;
    double pushed =
        0; ///< sum of |force| dt / sqrt(m) and of |torque| dt / sqrt(I): bounds the square root of twice the energy

    D3 direction() { return {number(), number(), number()}; }
    double number() { return to_double(random.range(Real(-1), Real(1))); }
    void apply(World& w, BodyId body) {
        const D3 f = force * direction(), t = torque * direction();
        done(w.add_force(body, vec(f[0], f[1], f[2]), vec(t[0], t[1], t[2])));
        const double mass = to_double(w.mass(body)), inertia = mass / 6; // of a crate of 1 m
        pushed += (length(f) / std::sqrt(mass) + length(t) / std::sqrt(inertia)) / w.def().tick_rate;
    }
    double energy_max() const { return 0.5 * pushed * pushed; }
};
inline Loads loads_of(std::uint64_t seed, double force, double torque) {
    return {Random::seeded(seed), force, torque};
}

} // namespace lockstone::test::scene
