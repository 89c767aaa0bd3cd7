// The furthest corner of a hull in lanes, written once over the lanes L: shapes/support_kernel.h.
//
// Only files that are compiled for one instruction set include this; it must not use inline functions that other files use
// too, since the linker keeps one of their copies.
#pragma once

#include "shapes/support_kernel.h"
#include "solve/lanes/lane_fixed.h"

namespace lockstone::solve {

template <class L> class HullSupport {
    static constexpr unsigned N = L::lanes;
    using V = typename L::V;

    /// Each lane looks at every Nth corner and keeps the first of its furthest.
    static std::uint32_t furthest(const std::int32_t* corners, std::uint32_t stride,
                                  const std::int32_t (&direction)[3]) {
        const V x = L::splat(direction[0]), y = L::splat(direction[1]), z = L::splat(direction[2]);
        const auto along = [&](std::uint32_t k) {
            return L::add(L::add(L::mul(L::load32(corners + k), x), L::mul(L::load32(corners + stride + k), y)),
                          L::mul(L::load32(corners + 2 * stride + k), z));
        };
        V most = along(0), block = L::splat(0);
        for (std::uint32_t k = N; k < stride; k += N) {
            const V next = along(k), more = L::greater64(next, most);
            most = L::select(more, next, most);
            block = L::select(more, L::splat(k), block);
        }
        std::int64_t reach[N], first[N];
        L::store64(reach, most), L::store64(first, block);
        std::int64_t best = first[0];
        for (unsigned lane = 1; lane < N; ++lane) {
            const std::int64_t corner = first[lane] + lane;
            const bool better = reach[lane] > reach[0] || (reach[lane] == reach[0] && corner < best);
            reach[0] = better ? reach[lane] : reach[0];
            best = better ? corner : best;
        }
        return static_cast<std::uint32_t>(best);
    }

  public:
    static constexpr shapes::SupportKernel table() { return {furthest}; }
};

} // namespace lockstone::solve
