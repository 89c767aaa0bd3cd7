// The lane operations of AVX2, compiled with the flags of this instruction set.
#include "lockstone/compiler.h"

#include "lane_ops.h"

#if LOCKSTONE_HAS_X86
#include "solve/lanes/avx2.h"
#endif

namespace lockstone::test {

#if LOCKSTONE_HAS_X86
const LaneOps* const avx2_lane_ops = &LaneRunner<solve::Avx2>::table;
#else
const LaneOps* const avx2_lane_ops = nullptr;
#endif

} // namespace lockstone::test
