// Joints in a tick: handed to the solver, and broken by it.
#include "tick/phases.h"
#include "world/commands/applier.h"

#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone::sim {

/// Of a resting body the frame's place in the world.
static Transform frame_for_solver(const Data& w, std::uint32_t row, const Transform& frame) {
    if (row == Data::dead || row < w.header().bodies_awake) return frame;
    const Transform& pose = w.state.rows(w.m.body_pose)[row];
    const Vec3 arm = frame.position - w.mass_of(row).center;
    return {pose.position + rotate(pose.rotation, arm), normalized(pose.rotation * frame.rotation)};
}

void list_joints(Data& w) {
    Scratch& s = w.scratch;
    const std::uint32_t still = w.header().bodies_awake;
    const std::span<const JointRow> rows = w.state.rows(w.m.joint);
    s.joints.clear();
    for (std::uint32_t row = 0; row < w.header().joints_awake; ++row) {
        const JointDef& def = rows[row].def;
        const std::uint32_t a = def.body_a ? w.row_of(def.body_a) : Data::dead, b = w.row_of(def.body_b);
        s.joints.push_back({&def, std::min(a, still), std::min(b, still), row,
                            frame_for_solver(w, a, def.frame_a), frame_for_solver(w, b, def.frame_b)});
    }
    const auto before = [&](const solve::Joint& x, const solve::Joint& y) {
        return rows[x.memory].id.index < rows[y.memory].id.index;
    };
    if (!std::is_sorted(s.joints.begin(), s.joints.end(), before))
        std::sort(s.joints.begin(), s.joints.end(), before);
}

void break_joints(Data& w) {
    Scratch& s = w.scratch;
    const std::span<const JointMemory> memory = w.state.rows(w.m.joint_memory);
    s.broken.clear();
    for (const JointRow& row : w.state.rows(w.m.joint).first(w.header().joints_awake)) {
        if (row.def.break_force == Real{} && row.def.break_torque == Real{}) continue;
        const JointMemory& m = memory[w.row_of(row.id)];
        const bool by_force = row.def.break_force != Real{} && length(m.force) > row.def.break_force;
        const bool by_torque = row.def.break_torque != Real{} && length(m.torque) > row.def.break_torque;
        if (by_force || by_torque) s.broken.push_back(row.id);
    }
    std::sort(s.broken.begin(), s.broken.end());
    w.events.clear(); // those of the last tick; this is the first phase that makes new ones
    for (JointId id : s.broken) {
        const JointDef& def = w.state.rows(w.m.joint)[w.row_of(id)].def;
        Event e{};
        e.kind = EventKind::joint_break;
        e.body_a = def.body_a;
        e.body_b = def.body_b;
        e.joint = id;
        e.point = w.state.rows(w.m.body_pose)[w.row_of(def.body_b)].position;
        e.tick = w.header().tick;
        w.events.push_back(e);
        Applier{w}.remove_joint(id.index);
    }
}

} // namespace lockstone::sim
