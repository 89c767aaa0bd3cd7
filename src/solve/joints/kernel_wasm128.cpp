// Of modules that are compiled with vectors (-msimd128): others do not load where there are none.
#if defined(__wasm_simd128__)

#include "solve/joints/kernel.h"
#include "solve/joints/kernels.h"
#include "solve/lanes/wasm128.h"

namespace lockstone::solve {

constinit const dynamics::JointKernel wasm128_joints = PackedJoints<Wasm128>::table();

} // namespace lockstone::solve

#endif
