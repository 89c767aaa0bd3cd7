// The kernels of bodies that this build has, by instruction set; each in a file of its own, kernel_*.cpp.
#pragma once

#include "dynamics/body_kernel.h"

#include "lockstone/simd.h"

namespace lockstone::solve {

/// Null where the build or the machine lacks it.
const dynamics::BodyKernel* bodies_of(Simd level);

extern const dynamics::BodyKernel scalar_bodies, sse41_bodies, avx2_bodies, neon_bodies, wasm128_bodies;

} // namespace lockstone::solve
