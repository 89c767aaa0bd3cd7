// Chains of joints over a floor that change while they run, beside equal chains whose memory is overwritten before
// every tick.
#pragma once

#include "support/task_worlds.h"
#include "tick/joints.h"
#include "world/data.h"

#include <functional>
#include <memory>
#include <vector>

namespace lockstone::test {

/// Chains of three over a floor, of every kind that packs and singles solve. Each hangs on a static body, except for
/// the last.
struct JointChains {
    static constexpr JointKind kinds[] = {JointKind::ball,  JointKind::hinge,    JointKind::weld,
                                          JointKind::wheel, JointKind::distance, JointKind::ball};
    static constexpr int links = 3; ///< too few for trees, whose plan is made in every tick
    sim::Data w{definition(), {}, std::make_shared<const AssetLibrary>()};
    std::vector<BodyId> bodies;
    std::vector<JointId> joints;

    static WorldDef definition() {
        WorldDef def = scene::drowsy_def();
        def.joints_max = 64;
        return def;
    }
    BodyId put(BodyKind kind, const Transform& pose, const Geometry& geometry) {
        bodies.push_back(scene::made(sim::apply(w, CreateBody{{.kind = kind, .pose = pose}})).body);
        scene::made(sim::apply(w, CreateShape{bodies.back(), {.geometry = geometry}}));
        return bodies.back();
    }
    void join(JointDef def, BodyId a, BodyId b) {
        def.body_a = a, def.body_b = b;
        def.frame_a.position = scene::vec(0.25, 0, 0), def.frame_b.position = scene::vec(-0.25, 0, 0);
        joints.push_back(scene::made(sim::apply(w, CreateJoint{def})).joint);
    }
    static JointDef of(JointKind kind) {
        JointDef def = kind == JointKind::hinge      ? hinge_joint()
                       : kind == JointKind::weld     ? weld_joint(4_r, 0.5_r)
                       : kind == JointKind::wheel    ? wheel_joint(4_r, 0.5_r)
                       : kind == JointKind::distance ? distance_joint(0.1_r)
                                                     : ball_joint();
        if (kind == JointKind::ball) def.swing = 0.75_r, def.axis[about_x].friction = 2_r;
        if (kind == JointKind::hinge)
            def.axis[about_x].mode = AxisMode::limited, def.axis[about_x].lower = -0.5_r,
            def.axis[about_x].upper = 0.5_r;
        return def;
    }
    JointChains() {
        put(BodyKind::static_, scene::at(0, -1, 0), box(Real(20), Real(1), Real(20)));
        double z = -4;
        for (const JointKind kind : kinds) {
            const bool hangs = z < 3;
            BodyId before =
                put(hangs ? BodyKind::static_ : BodyKind::dynamic, scene::at(-2, 2, z), sphere(0.1_r));
            for (int i = 1; i <= links; ++i) {
                const BodyId link =
                    put(BodyKind::dynamic, scene::at(-2 + 0.5 * i, 2, z), capsule(0.05_r, 0.1_r));
                join(of(kind), before, link);
                before = link;
            }
            z += 1.5;
        }
    }
    JointChains(const JointChains&) = default;
    JointChains& operator=(const JointChains&) = delete;

    template <class C> void say(const C& command) { scene::made(sim::apply(w, command)); }
    const JointDef& def(std::size_t joint) const {
        return w.state.rows(w.m.joint)[w.row_of(joints[joint])].def;
    }
};

/// Changes joints and bodies; the tick decides how.
inline void change(JointChains& c, int t) {
    const auto pick = [t](std::size_t count) { return static_cast<std::size_t>(t) * 7 % count; };
    const std::size_t joint = pick(c.joints.size());
    const BodyId body = c.bodies[1 + pick(c.bodies.size() - 1)];
    const BodyId anchor = c.bodies[1];
    JointDef def = c.def(joint);
    switch (t % 80) {
    case 10: // a motor
        def.axis[about_x].mode = AxisMode::free, def.axis[about_x].motor_speed = 4_r;
        def.axis[about_x].motor_force = 3_r;
        return c.say(SetJointAxis{c.joints[joint], about_x, 0, def.axis[about_x]});
    case 20: // a point opens along an axis, so packs no longer solve it
        def.axis[along_x].mode = AxisMode::free;
        return c.say(SetJointAxis{c.joints[joint], along_x, 0, def.axis[along_x]});
    case 30:
        def.frame_b.position.y += 0.05_r;
        return c.say(SetJointFrames{c.joints[joint], def.frame_a, def.frame_b});
    case 40: // moves a static body
        return c.say(SetPose{anchor, scene::at(-2.02, 2.01, -4)});
    case 50:
        if (c.w.state.rows(c.w.m.body_info)[c.w.row_of(body)].kind != BodyKind::dynamic) return;
        return c.say(SetMass{.body = body, .mass = Real(1 + t % 5), .center = scene::vec(0.02, 0, 0)});
    case 60: // destroys a joint and makes it again, as the last one
        c.say(DestroyJoint{c.joints[joint]});
        c.joints[joint] = scene::made(sim::apply(c.w, CreateJoint{def})).joint;
        return;
    case 70:
        return c.say(SetVelocity{c.bodies.back(), scene::vec(1, 2, 0.5), scene::vec(20, 3, 9)});
    default:
        return;
    }
}

struct ChainRun {
    int kept = 0, anew = 0, asleep = 0;
    int parted_at = -1; ///< the tick in which the two differ, -1: none
};
/// Calls `hide` between the changes and the tick.
inline ChainRun run_chains(
    int ticks, const std::function<void(sim::Data&)>& hide = [](sim::Data&) {}) {
    JointChains usual, other = usual;
    ChainRun kept;
    for (int t = 0; t < ticks && kept.parted_at < 0; ++t) {
        change(usual, t), change(other, t);
        hide(usual.w);
        sim::poison_scratch(other.w, static_cast<std::byte>(37 * t));
        sim::tick(usual.w), sim::tick(other.w);
        ++(usual.w.scratch.joints.is_new ? kept.anew : kept.kept);
        kept.asleep += usual.w.header().bodies_awake + 4 < usual.bodies.size() ? 1 : 0;
        if (usual.w.state.hash() != other.w.state.hash()) kept.parted_at = t;
    }
    return kept;
}

} // namespace lockstone::test
