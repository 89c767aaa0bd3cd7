// Joints in a tick: handed to the solver, and broken by it.
#pragma once

#include "lockstone/event.h"
#include "model/model.h"
#include "solve/joints/joint.h"

#include <cstddef>
#include <vector>

namespace lockstone::sim {

/// The joints of a tick, and whether they are those of the last one: then what was made of them alone serves again.
struct JointList {
    std::vector<solve::Joint> all; ///< in slot order, as the solver takes them
    /// Made anew: joints have come, gone or changed, or bodies, their masses or their rows have. Frames in the world may be others in
    /// any tick.
    bool is_new = true;
    std::vector<std::uint32_t> resting; ///< joints of `all` that hold a body that rests
    bool any_breaks = false;            ///< a joint that would, with enough force or torque

    void poison(std::byte with);

    // What the list was made of
    const JointRow* rows = nullptr;
    std::uint32_t bodies_awake = 0, joints_awake = 0;
    ChangeMark seen;
    std::vector<RowRange> changed;    ///< memory
    std::vector<std::uint32_t> order; ///< memory: rows in slot order
};
void list_joints(const Model& w, JointList& out);
/// Removes joints that bore too much, and reports them. `broken`: memory.
void break_joints(Model& w, const JointList& list, std::vector<JointId>& broken, std::vector<Event>& events);

} // namespace lockstone::sim
