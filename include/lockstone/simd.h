// Instruction sets of the solver and of collision detection. All give equal bits.
#pragma once

#include "lockstone/result.h"

#include <string_view>

namespace lockstone {

/// An instruction set.
enum class Simd : unsigned char {
    scalar, ///< no vector instructions
    sse41,  ///< x86: SSE4.1
    avx2,   ///< x86: AVX2
    avx512, ///< x86: AVX-512
    neon,   ///< 64-bit ARM
    wasm128 ///< WebAssembly SIMD
};
/// All instruction sets.
inline constexpr Simd every_simd[] = {Simd::scalar, Simd::sse41, Simd::avx2,
                                      Simd::avx512, Simd::neon,  Simd::wasm128};

/// Name of the enumerator; "unknown" for any other value. Static string.
std::string_view name_of(Simd level);
/// True if this build and this machine support it.
bool has_simd(Simd level);
/// The fastest supported one: the default of a world.
Simd best_simd();

} // namespace lockstone
