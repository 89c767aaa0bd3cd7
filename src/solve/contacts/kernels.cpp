#include "solve/contacts/kernels.h"

namespace lockstone::solve {

const ContactKernel* kernel_of(Simd level) {
    if (!has_simd(level)) return nullptr;
#if defined(__x86_64__) || defined(__i386__)
    if (level == Simd::avx512) return &avx512_kernel;
    if (level == Simd::avx2) return &avx2_kernel;
    if (level == Simd::sse41) return &sse41_kernel;
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
    if (level == Simd::neon) return &neon_kernel;
#elif defined(__wasm_simd128__)
    if (level == Simd::wasm128) return &wasm128_kernel;
#endif
    return &scalar_kernel;
}

} // namespace lockstone::solve
