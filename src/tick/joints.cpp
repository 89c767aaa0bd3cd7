#include "tick/joints.h"

#include "base/poison.h"
#include "lockstone/math/math.h"
#include "model/slots.h"

#include <algorithm>
#include <numeric>

namespace lockstone::sim {

/// The frame of a joint; for a resting body, the frame in world space.
static Transform frame_for_solver(const Model& w, std::uint32_t row, const Transform& frame) {
    if (row == Model::dead || row < w.header().bodies_awake) return frame;
    const Transform& pose = w.state.rows(w.m.body_pose)[row];
    const Vec3 arm = frame.position - w.mass_of(row).center;
    return {pose.position + rotate(pose.rotation, arm), normalized(pose.rotation * frame.rotation)};
}

static bool can_break(const JointDef& def) { return def.break_force != Real{} || def.break_torque != Real{}; }

/// Returns true if a column from which the list is made may have changed since the last call.
static bool has_changed(const Model& w, JointList& list) {
    bool any = false;
    const auto look = [&](std::uint32_t column, std::uint32_t rows) {
        const std::uint32_t before = w.state.take_changes(column, list.seen, list.changed);
        any = any || before != rows || !list.changed.empty();
    };
    look(w.m.joint.index, w.state.count(w.m.joints));
    look(w.m.body_slot.index, w.state.count(w.m.body_slots));
    look(w.m.body_info.index, w.state.count(w.m.bodies));
    look(w.m.body_traits.row.index, w.state.count(w.m.body_traits.table));
    return any;
}

/// Updates the frames of resting bodies, which a command may have moved.
static void place_resting(const Model& w, JointList& list) {
    for (const std::uint32_t i : list.resting) {
        solve::Joint& joint = list.all[i];
        const JointDef& def = *joint.def;
        if (joint.body_a == list.bodies_awake && def.body_a)
            joint.frame_a = frame_for_solver(w, w.row_of(def.body_a), def.frame_a);
        if (joint.body_b == list.bodies_awake)
            joint.frame_b = frame_for_solver(w, w.row_of(def.body_b), def.frame_b);
    }
}

void JointList::poison(std::byte with) {
    base::poison(with, all, order, resting);
    rows = nullptr;
}

void list_joints(const Model& w, JointList& list) {
    std::vector<solve::Joint>& out = list.all;
    const std::uint32_t still = w.header().bodies_awake, count = w.header().joints_awake;
    const std::span<const JointRow> rows = w.state.rows(w.m.joint);
    if (count == 0 && out.empty()) {
        list.any_breaks = false;
        return;
    }
    const bool is_known =
        list.rows == rows.data() && list.bodies_awake == still && list.joints_awake == count;
    list.is_new = has_changed(w, list) || !is_known;
    if (!list.is_new) return place_resting(w, list);
    list.rows = rows.data(), list.bodies_awake = still, list.joints_awake = count;
    list.order.resize(count);
    std::iota(list.order.begin(), list.order.end(), 0u);
    const auto before = [&](std::uint32_t x, std::uint32_t y) { return rows[x].id.index < rows[y].id.index; };
    if (!std::is_sorted(list.order.begin(), list.order.end(), before))
        std::sort(list.order.begin(), list.order.end(), before);
    out.clear(), list.resting.clear(), list.any_breaks = false;
    for (const std::uint32_t row : list.order) {
        const JointDef& def = rows[row].def;
        list.any_breaks = list.any_breaks || can_break(def);
        const std::uint32_t a = def.body_a ? w.row_of(def.body_a) : Model::dead, b = w.row_of(def.body_b);
        if ((a != Model::dead && a >= still) || b >= still)
            list.resting.push_back(static_cast<std::uint32_t>(out.size()));
        out.push_back({&def, std::min(a, still), std::min(b, still), row, 0, 0,
                       frame_for_solver(w, a, def.frame_a), frame_for_solver(w, b, def.frame_b)});
    }
}

void break_joints(Model& w, const JointList& list, std::vector<JointId>& broken, std::vector<Event>& events) {
    if (!list.any_breaks) return;
    const std::span<const JointMemory> memory = w.state.rows(w.m.joint_memory);
    broken.clear();
    for (const JointRow& row : w.state.rows(w.m.joint).first(w.header().joints_awake)) {
        if (!can_break(row.def)) continue;
        const JointMemory& m = memory[w.row_of(row.id)];
        const bool by_force = row.def.break_force != Real{} && length(m.force) > row.def.break_force;
        const bool by_torque = row.def.break_torque != Real{} && length(m.torque) > row.def.break_torque;
        if (by_force || by_torque) broken.push_back(row.id);
    }
    std::sort(broken.begin(), broken.end());
    for (JointId id : broken) {
        const JointDef& def = w.state.rows(w.m.joint)[w.row_of(id)].def;
        Event e{};
        e.kind = EventKind::joint_break;
        e.body_a = def.body_a;
        e.body_b = def.body_b;
        e.joint = id;
        e.point = w.state.rows(w.m.body_pose)[w.row_of(def.body_b)].position;
        e.tick = w.header().tick;
        events.push_back(e);
        remove_joint(w, id.index);
    }
}

} // namespace lockstone::sim
