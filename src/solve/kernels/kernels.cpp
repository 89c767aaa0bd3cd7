#include "solve/kernels/kernels.h"

#include "lockstone/compiler.h"

namespace lockstone::solve {

const Kernels* kernels_of(Simd level) {
    if (!has_simd(level)) return nullptr;
#if LOCKSTONE_HAS_X86
    // Packs of joints have four lanes, bodies have six velocities, and axes have nine numbers, so AVX-512 adds nothing
    // there.
    static constexpr Kernels avx512{&avx512_contacts, &avx2_joints,  &avx2_bodies,
                                    &avx512_pairs,    &avx512_hulls, &avx2_bounds},
        avx2{&avx2_contacts, &avx2_joints, &avx2_bodies, &avx2_pairs, &avx2_hulls, &avx2_bounds},
        sse41{&sse41_contacts, &sse41_joints, &sse41_bodies, &sse41_pairs, &sse41_hulls, &sse41_bounds};
    if (level == Simd::avx512) return &avx512;
    if (level == Simd::avx2) return &avx2;
    if (level == Simd::sse41) return &sse41;
#elif LOCKSTONE_HAS_NEON
    static constexpr Kernels neon{&neon_contacts, &neon_joints, &neon_bodies,
                                  &neon_pairs,    &neon_hulls,  &neon_bounds};
    if (level == Simd::neon) return &neon;
#elif LOCKSTONE_HAS_WASM128
    static constexpr Kernels wasm128{&wasm128_contacts, &wasm128_joints, &wasm128_bodies,
                                     &wasm128_pairs,    &wasm128_hulls,  &wasm128_bounds};
    if (level == Simd::wasm128) return &wasm128;
#endif
    static constexpr Kernels scalar{&scalar_contacts, &scalar_joints, &scalar_bodies,
                                    &scalar_pairs,    &scalar_hulls,  &scalar_bounds};
    return &scalar;
}

} // namespace lockstone::solve
