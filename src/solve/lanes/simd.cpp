#include "lockstone/simd.h"

#include <algorithm>

namespace lockstone {

std::string_view name_of(Simd level) {
    switch (level) {
    case Simd::scalar:
        return "scalar";
    case Simd::sse41:
        return "sse41";
    case Simd::avx2:
        return "avx2";
    case Simd::avx512:
        return "avx512";
    case Simd::neon:
        return "neon";
    case Simd::wasm128:
        return "wasm128";
    }
    return "unknown";
}

bool has_simd(Simd level) {
#if defined(__x86_64__) || defined(__i386__)
    switch (level) {
    case Simd::sse41:
        return __builtin_cpu_supports("sse4.1") != 0;
    case Simd::avx2:
        return __builtin_cpu_supports("avx2") != 0;
    case Simd::avx512:
        return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
               __builtin_cpu_supports("avx512vl") != 0;
    default:
        break;
    }
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
    if (level == Simd::neon) return true;
#elif defined(__wasm_simd128__)
    if (level == Simd::wasm128) return true;
#endif
    return level == Simd::scalar;
}

Simd best_simd() {
    Simd best = Simd::scalar;
    for (const Simd level : every_simd)
        if (has_simd(level)) best = std::max(best, level);
    return best;
}

} // namespace lockstone
