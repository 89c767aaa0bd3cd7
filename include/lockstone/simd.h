// The instruction sets that the solver can use. All give the same bits; the best that the machine has is chosen.
#pragma once

#include "lockstone/result.h"

#include <string_view>

namespace lockstone {

enum class Simd : unsigned char { scalar, sse41, avx2, avx512, neon, wasm128 };
inline constexpr Simd every_simd[] = {Simd::scalar, Simd::sse41, Simd::avx2,
                                      Simd::avx512, Simd::neon,  Simd::wasm128};

/// As the enumerators; "unknown" for any other value.
std::string_view name_of(Simd level);
/// Whether this build and this machine have it.
bool has_simd(Simd level);
/// The fastest that this machine has.
Simd best_simd();

} // namespace lockstone
