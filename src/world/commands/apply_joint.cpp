// Joints come, change and go. Each stands in the lists of its bodies.
#include "world/commands/applier.h"

#include "lockstone/math/math.h"
#include "model/checks.h"
#include "tick/sleep.h"

#include <algorithm>

namespace lockstone::sim {

using Applied = World::Applied;
using base::join;

namespace {

/// The link of body `body` in a joint's row.
std::uint32_t& next_of(JointRow& row, BodyId body) {
    return row.def.body_a == body ? row.next_a : row.next_b;
}

/// Empty when the bodies can be joined.
std::string check_bodies(const Data& w, const JointDef& d) {
    const auto lives = [&](BodyId body) { return w.row_of(body) != Data::dead; };
    if (!lives(d.body_b))
        return join("body_b ", text_of(d.body_b), " is not alive: destroyed, null, or of another time");
    const bool needs_a =
        d.kind == JointKind::pulley || d.kind == JointKind::gear || d.kind == JointKind::rack_and_pinion;
    if (!d.body_a && needs_a) return join("a ", name_of(d.kind), " joint needs a body_a");
    if (d.body_a && !lives(d.body_a))
        return join("body_a ", text_of(d.body_a), " is not alive: destroyed, or of another time");
    if (d.body_a == d.body_b) return "body_a and body_b are the same body";
    return {};
}

void wake_bodies(Data& w, const JointDef& def) {
    if (def.body_a) wake(w, def.body_a);
    wake(w, def.body_b);
}

void enlist(Data& w, std::uint32_t row, std::uint32_t slot, BodyId body) {
    if (!body) return;
    BodyInfo& info = w.state.edit_row(w.m.body_info, w.row_of(body));
    next_of(w.state.edit_row(w.m.joint, row), body) = info.first_joint;
    info.first_joint = slot;
}

void delist(Data& w, std::uint32_t row, std::uint32_t slot, BodyId body) {
    if (!body) return;
    const std::span<const Slot> slots = w.state.rows(w.m.joint_slot);
    const std::uint32_t next = next_of(w.state.edit_row(w.m.joint, row), body);
    BodyInfo& info = w.state.edit_row(w.m.body_info, w.row_of(body));
    if (info.first_joint == slot) {
        info.first_joint = next;
        return;
    }
    for (std::uint32_t at = info.first_joint; at != 0;) {
        std::uint32_t& link = next_of(w.state.edit_row(w.m.joint, slots[at - 1].row), body);
        if (link == slot) {
            link = next;
            return;
        }
        at = link;
    }
}

} // namespace

Result<World::Applied> Applier::operator()(const CreateJoint& c) {
    if (std::string e = check(c.def); !e.empty()) return Error{"create_joint: " + e};
    if (std::string e = check_bodies(w, c.def); !e.empty()) return Error{"create_joint: " + e};
    const std::uint32_t row = w.state.count(w.m.joints);
    if (row == w.state.rows_max(w.m.joints))
        return Error{join("create_joint: the world is full: joints_max is ", row)};
    wake_bodies(w, c.def);
    w.state.make_room({w.m.joint_slots, w.m.joints}, 1);
    const std::uint32_t index =
        take_slot(w.state, w.m.joint_slots, w.m.joint_slot, w.edit_header().joint_free, row);
    const JointId id{index, w.state.rows(w.m.joint_slot)[index - 1].generation};
    w.state.resize(w.m.joints, row + 1);
    JointRow& fresh = w.state.edit_row(w.m.joint, row);
    fresh = {id, c.def, 0, 0};
    fresh.def.frame_a.rotation = normalized(c.def.frame_a.rotation);
    fresh.def.frame_b.rotation = normalized(c.def.frame_b.rotation);
    enlist(w, row, index, c.def.body_a);
    enlist(w, row, index, c.def.body_b);
    wake_joint(w, row);
    return Applied{.joint = id};
}

Result<World::Applied> Applier::operator()(const DestroyJoint& c) {
    if (w.row_of(c.joint) == Data::dead) return dead("destroy_joint", "joint", c.joint);
    wake_bodies(w, JointDef(w.state.rows(w.m.joint)[w.row_of(c.joint)].def));
    remove_joint(c.joint.index);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const SetJointAxis& c) {
    if (w.row_of(c.joint) == Data::dead) return dead("set_joint_axis", "joint", c.joint);
    if (c.index >= joint_axis_count)
        return Error{join("set_joint_axis: index is ", c.index, ", must be 0 to 5")};
    if (c.reserved != 0) return Error{"set_joint_axis: reserved must be 0"};
    if (std::string e = check(c.axis, c.index); !e.empty()) return Error{"set_joint_axis: " + e};
    wake_bodies(w, JointDef(w.state.rows(w.m.joint)[w.row_of(c.joint)].def));
    w.state.edit_row(w.m.joint, w.row_of(c.joint)).def.axis[c.index] = c.axis;
    return Applied{};
}

Result<World::Applied> Applier::operator()(const SetJointFrames& c) {
    const std::uint32_t row = w.row_of(c.joint);
    if (row == Data::dead) return dead("set_joint_frames", "joint", c.joint);
    JointDef def = w.state.rows(w.m.joint)[row].def;
    def.frame_a = c.frame_a;
    def.frame_b = c.frame_b;
    if (std::string e = check(def); !e.empty()) return Error{"set_joint_frames: " + e};
    wake_bodies(w, def);
    JointDef& changed = w.state.edit_row(w.m.joint, w.row_of(c.joint)).def;
    changed.frame_a = {c.frame_a.position, normalized(c.frame_a.rotation)};
    changed.frame_b = {c.frame_b.position, normalized(c.frame_b.rotation)};
    return Applied{};
}

void Applier::remove_joint(std::uint32_t slot) {
    std::uint32_t row = w.state.rows(w.m.joint_slot)[slot - 1].row;
    const JointDef def = w.state.rows(w.m.joint)[row].def;
    delist(w, row, slot, def.body_a);
    delist(w, row, slot, def.body_b);
    row = put_joint_to_rest(w, row);
    const JointId moved = w.state.rows(w.m.joint).back().id;
    remove_row(w.state, w.m.joints, row);
    w.state.edit_row(w.m.joint_slot, moved.index - 1).row = row;
    free_slot(w.state, w.m.joint_slot, slot, w.edit_header().joint_free);
}

} // namespace lockstone::sim
