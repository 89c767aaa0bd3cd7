// Splits the joints among workers (strands), and plans the waits between them.
#pragma once

#include "solve/joints/joint_work.h"

namespace lockstone::solve {

/// Assigns a strand to each joint by the position of its bodies. JointTick::in_order must be sorted by stage. Returns
/// the number of strands: 1 if there are few joints, or few per stage.
std::uint32_t share_out(JointTick& tick, std::uint32_t stage_count, std::uint32_t workers);
/// Sets JointWork::is_inner. Border joints come first in their stage, so that other strands wait only for these.
void find_borders(JointTick& tick);
/// Builds the pieces of both passes, which process the steps forward and in reverse. Builds none for one strand.
void plan_strands(JointTick& tick, std::uint32_t strands);

} // namespace lockstone::solve
