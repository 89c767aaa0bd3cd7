// Which joints each worker solves, and for which of others it waits.
#pragma once

#include "solve/joints/joint_work.h"

namespace lockstone::solve {

/// Finds the strand of each joint by where its bodies are; joints are in_order by stages. Returns how many strands there are: 1 where there are few joints, or few in a stage.
std::uint32_t share_out(JointTick& tick, std::uint32_t stage_count, std::uint32_t workers);
/// Which joints are inner ones. Others come first in their stage: nobody who waits for them waits for more.
void find_borders(JointTick& tick);
/// Pieces for both passes, which go through the steps in order and backwards. None for one strand.
void plan_strands(JointTick& tick, std::uint32_t strands);

} // namespace lockstone::solve
