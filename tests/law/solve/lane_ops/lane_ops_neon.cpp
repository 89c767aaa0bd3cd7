// The lane operations of NEON, compiled with the flags of this instruction set.
#include "lockstone/compiler.h"

#include "lane_ops.h"

#if LOCKSTONE_HAS_NEON
#include "solve/lanes/neon.h"
#endif

namespace lockstone::test {

#if LOCKSTONE_HAS_NEON
const LaneOps* const neon_lane_ops = &LaneRunner<solve::Neon>::table;
#else
const LaneOps* const neon_lane_ops = nullptr;
#endif

} // namespace lockstone::test
