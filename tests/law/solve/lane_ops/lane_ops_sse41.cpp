// The lane operations of SSE4.1, compiled with the flags of this instruction set.
#include "lockstone/compiler.h"

#include "lane_ops.h"

#if LOCKSTONE_HAS_X86
#include "solve/lanes/sse41.h"
#endif

namespace lockstone::test {

#if LOCKSTONE_HAS_X86
const LaneOps* const sse41_lane_ops = &LaneRunner<solve::Sse41>::table;
#else
const LaneOps* const sse41_lane_ops = nullptr;
#endif

} // namespace lockstone::test
