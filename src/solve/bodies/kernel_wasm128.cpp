// Of modules that are compiled with vectors (-msimd128): others do not load where there are none.
#if defined(__wasm_simd128__)

#include "solve/bodies/kernel.h"
#include "solve/bodies/kernels.h"
#include "solve/lanes/wasm128.h"

namespace lockstone::solve {

constinit const dynamics::BodyKernel wasm128_bodies = MovedBodies<Wasm128>::table();

} // namespace lockstone::solve

#endif
