// The kernels that this build has, by instruction set; each in a file of its own, kernel_*.cpp.
#pragma once

#include "solve/contacts/pack.h"

#include "lockstone/simd.h"

namespace lockstone::solve {

/// Null where the build or the machine lacks it.
const ContactKernel* kernel_of(Simd level);

extern const ContactKernel scalar_kernel, sse41_kernel, avx2_kernel, avx512_kernel, neon_kernel, wasm128_kernel;

} // namespace lockstone::solve
