// Creates, changes and destroys joints. Each joint is in the joint lists of its bodies.
#include "world/commands/applier.h"

#include "lockstone/math/math.h"
#include "model/checks.h"
#include "model/sleep.h"

#include <algorithm>

namespace lockstone::sim {

using Applied = World::Applied;
using base::join;

namespace {

/// Returns an empty text if the bodies can be joined, else the error.
std::string check_bodies(const Model& w, const JointDef& d) {
    const auto lives = [&](BodyId body) { return w.row_of(body) != Model::dead; };
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

void wake_bodies(Model& w, const JointDef& def) {
    if (def.body_a) wake(w, def.body_a);
    wake(w, def.body_b);
}

} // namespace

Result<World::Applied> Applier::operator()(const CreateJoint& c) {
    const JointDef& def = *c.def;
    if (std::string e = check(def); !e.empty()) return Error{"create_joint: " + e};
    if (std::string e = check_bodies(w, def); !e.empty()) return Error{"create_joint: " + e};
    const std::uint32_t row = w.state.count(w.m.joints);
    if (row == w.state.rows_max(w.m.joints))
        return Error{join("create_joint: the world is full: joints_max is ", row)};
    wake_bodies(w, def);
    w.state.make_room({w.m.joint_slots, w.m.joints}, 1);
    const std::uint32_t index = take_slot(w, w.m.joint_slots, w.m.joint_slot, &Header::joint_free, row);
    const JointId id{index, w.state.rows(w.m.joint_slot)[index - 1].generation};
    w.state.resize(w.m.joints, row + 1);
    JointRow& fresh = w.state.edit_row(w.m.joint, row);
    fresh = {id, def, 0, 0};
    fresh.def.frame_a.rotation = normalized(def.frame_a.rotation);
    fresh.def.frame_b.rotation = normalized(def.frame_b.rotation);
    enlist_joint(w, row);
    wake_joint(w, row);
    return Applied{.joint = id};
}

Result<World::Applied> Applier::operator()(const DestroyJoint& c) {
    if (w.row_of(c.joint) == Model::dead) return dead("destroy_joint", "joint", c.joint);
    wake_bodies(w, JointDef(w.state.rows(w.m.joint)[w.row_of(c.joint)].def));
    remove_joint(w, c.joint.index);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const SetJointAxis& c) {
    if (w.row_of(c.joint) == Model::dead) return dead("set_joint_axis", "joint", c.joint);
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
    if (row == Model::dead) return dead("set_joint_frames", "joint", c.joint);
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

} // namespace lockstone::sim
