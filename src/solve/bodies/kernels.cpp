#include "solve/bodies/kernels.h"

namespace lockstone::solve {

const dynamics::BodyKernel* bodies_of(Simd level) {
    if (!has_simd(level)) return nullptr;
#if defined(__x86_64__) || defined(__i386__)
    if (level >= Simd::avx2) return &avx2_bodies; // a body has six velocities
    if (level == Simd::sse41) return &sse41_bodies;
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
    if (level == Simd::neon) return &neon_bodies;
#elif defined(__wasm_simd128__)
    if (level == Simd::wasm128) return &wasm128_bodies;
#endif
    return &scalar_bodies;
}

} // namespace lockstone::solve
