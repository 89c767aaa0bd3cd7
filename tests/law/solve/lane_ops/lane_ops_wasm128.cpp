// The lane operations of WebAssembly, compiled with the flags of this instruction set.
#include "lockstone/compiler.h"

#include "lane_ops.h"

#if LOCKSTONE_HAS_WASM128
#include "solve/lanes/wasm128.h"
#endif

namespace lockstone::test {

#if LOCKSTONE_HAS_WASM128
const LaneOps* const wasm128_lane_ops = &LaneRunner<solve::Wasm128>::table;
#else
const LaneOps* const wasm128_lane_ops = nullptr;
#endif

} // namespace lockstone::test
