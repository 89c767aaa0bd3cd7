// A hinge whose axes separate within one tick.
#pragma once

#include "support/sim_scenes.h"

namespace lockstone::test::scene {

/// Two boxes of 2 m in one place. One is welded to a body that spins about z, the other to the world, and their hinge
/// about x cannot hold both. A ball joint between the boxes closes a loop, so the tree solver does not solve the hinge.
struct TornHinge {
    World world;
    BodyId spun, held;
    JointId hinge;

    TornHinge(const JointDef& def, Real speed) : world(made(World::create({.gravity = {}, .sleeping = 0}))) {
        const Vec3 spin{Real{}, Real{}, speed}, half{1_r, 1_r, 1_r};
        const Transform middle = Transform::identity();
        const BodyId motor = made(world.create_body({.kind = BodyKind::kinematic, .angular_velocity = spin}));
        spun = add(world, {.angular_velocity = spin}, {.geometry = box(half)});
        held = add(world, {}, {.geometry = box(half)});
        made(world.create_joint(weld_joint(), motor, spun, middle));
        made(world.create_joint(weld_joint(), {}, held, middle));
        made(world.create_joint(ball_joint(), spun, held, middle));
        hinge = made(world.create_joint(def, spun, held, middle));
    }
    /// The cosine of the angle between its axes.
    Real closeness() const {
        const Vec3 x{1_r, Real{}, Real{}};
        return dot(rotate(world.pose(spun).rotation, x), rotate(world.pose(held).rotation, x));
    }
    /// About z [N m].
    Real torque() const { return world.joint_state(hinge).torque.z; }
};

inline JointDef hinge_with(const JointAxis& about) {
    JointDef def = hinge_joint();
    def.axis[about_x] = about;
    return def;
}
/// A wheel joint with the hinge's axes; packs do not solve its rows.
inline JointDef wheel_like_hinge(const JointAxis& about) {
    JointDef def = wheel_joint(1_r, 1_r);
    def.axis[along_y] = JointAxis{};
    def.axis[about_x] = about;
    return def;
}

inline constexpr JointAxis turns_freely{.mode = AxisMode::free},
    hardly_turns{.mode = AxisMode::limited, .lower = -0.01_r, .upper = 0.01_r};

} // namespace lockstone::test::scene
