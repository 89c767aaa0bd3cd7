// Joints in a tick: the list for the solver, and the removal of broken joints.
#pragma once

#include "lockstone/event.h"
#include "model/model.h"
#include "solve/joints/joint.h"

#include <cstddef>
#include <vector>

namespace lockstone::sim {

/// The joints of a tick. If the list is the same as in the last tick, data that depends on the joints alone stays
/// valid.
struct JointList {
    std::vector<solve::Joint> all; ///< in slot order, as the solver takes them
    /// True if the list was rebuilt: joints were created, removed or changed, or bodies, their masses or their rows
    /// were. Frames of resting bodies, in world space, may change in any tick.
    bool is_new = true;
    std::vector<std::uint32_t> resting; ///< indices into `all` of joints that hold a resting body
    bool any_breaks = false;            ///< at least one joint has a limit of force or torque

    void poison(std::byte with);

    // The state of the columns from which the list was made
    const JointRow* rows = nullptr;
    std::uint32_t bodies_awake = 0, joints_awake = 0;
    ChangeMark seen;
    std::vector<RowRange> changed;    ///< scratch memory
    std::vector<std::uint32_t> order; ///< scratch memory: rows in slot order
};
void list_joints(const Model& w, JointList& out);
/// Removes joints whose force or torque exceeds the limit, and reports them. `broken`: scratch memory.
void break_joints(Model& w, const JointList& list, std::vector<JointId>& broken, std::vector<Event>& events);

} // namespace lockstone::sim
