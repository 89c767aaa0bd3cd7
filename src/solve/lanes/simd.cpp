// Finds the instruction sets of this machine.
#include "lockstone/simd.h"

#include "lockstone/compiler.h"
#include "solve/lanes/cpuid.h"

#include <algorithm>

#if LOCKSTONE_HAS_X86 && defined(_MSC_VER)
#include <intrin.h>
#endif

namespace lockstone {

namespace {

#if LOCKSTONE_HAS_X86 && defined(_MSC_VER)
#if defined(__clang__)
[[gnu::target("xsave")]]
#endif
solve::CpuidWords
ask_processor() {
    int leaf0[4], leaf1[4], leaf7[4] = {};
    __cpuid(leaf0, 0);
    __cpuid(leaf1, 1);
    if (leaf0[0] >= 7) __cpuidex(leaf7, 7, 0);
    solve::CpuidWords words{static_cast<std::uint32_t>(leaf1[2]), static_cast<std::uint32_t>(leaf7[1]), 0};
    if (solve::has_xgetbv(words.leaf1_ecx)) words.kept = static_cast<std::uint32_t>(_xgetbv(0));
    return words;
}

bool machine_has(Simd level) {
    static const solve::CpuidWords words = ask_processor();
    return solve::has_simd(words, level);
}
#elif LOCKSTONE_HAS_X86
bool machine_has(Simd level) {
    switch (level) {
    case Simd::sse41:
        return __builtin_cpu_supports("sse4.1") != 0;
    case Simd::avx2:
        return __builtin_cpu_supports("avx2") != 0;
    case Simd::avx512:
        return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
               __builtin_cpu_supports("avx512vl") != 0;
    default:
        return false;
    }
}
#else
bool machine_has(Simd level) {
    return LOCKSTONE_HAS_NEON ? level == Simd::neon : LOCKSTONE_HAS_WASM128 && level == Simd::wasm128;
}
#endif

} // namespace

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

bool has_simd(Simd level) { return level == Simd::scalar || machine_has(level); }

Simd best_simd() {
    Simd best = Simd::scalar;
    for (const Simd level : every_simd)
        if (has_simd(level)) best = std::max(best, level);
    return best;
}

} // namespace lockstone
