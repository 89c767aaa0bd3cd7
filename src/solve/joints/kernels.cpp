#include "solve/joints/kernels.h"

namespace lockstone::solve {

const dynamics::JointKernel* joints_of(Simd level) {
    if (!has_simd(level)) return nullptr;
#if defined(__x86_64__) || defined(__i386__)
    if (level >= Simd::avx2) return &avx2_joints; // packs of joints have four lanes
    if (level == Simd::sse41) return &sse41_joints;
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
    if (level == Simd::neon) return &neon_joints;
#elif defined(__wasm_simd128__)
    if (level == Simd::wasm128) return &wasm128_joints;
#endif
    return &scalar_joints;
}

} // namespace lockstone::solve
