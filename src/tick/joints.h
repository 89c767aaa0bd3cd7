// Joints in a tick: handed to the solver, and broken by it.
#pragma once

#include "lockstone/event.h"
#include "model/model.h"
#include "solve/joints/joint.h"

#include <vector>

namespace lockstone::sim {

/// In slot order, as the solver takes them.
void list_joints(const Model& w, std::vector<solve::Joint>& out);
/// Removes joints that bore too much, and reports them. `broken`: memory.
void break_joints(Model& w, std::vector<JointId>& broken, std::vector<Event>& events);

} // namespace lockstone::sim
