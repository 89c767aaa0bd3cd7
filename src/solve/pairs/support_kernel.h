// The furthest corner of a hull in lanes, written once over the lanes L: shapes/hull/support_kernel.h.
//
// Only files that are compiled for one instruction set include this; it must not use inline functions that other files use
// too, since the linker keeps one of their copies.
#pragma once

#include "shapes/hull/support_kernel.h"
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
            return L::add(
                L::add(L::mul(L::load32(corners + k), x), L::mul(L::load32(corners + stride + k), y)),
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

    static void reach(const std::int32_t* corners, std::uint32_t stride,
                      const std::int32_t (&directions)[3][3], std::int64_t (&low)[3],
                      std::int64_t (&high)[3]) {
        V axis[3][3], least[3], most[3];
        for (int r = 0; r < 3; ++r)
            for (int i = 0; i < 3; ++i) axis[r][i] = L::splat(directions[r][i]);
        for (std::uint32_t k = 0; k < stride; k += N) {
            V corner[3];
            for (unsigned i = 0; i < 3; ++i) corner[i] = L::load32(corners + i * stride + k);
            for (int r = 0; r < 3; ++r) {
                const V along = L::add(L::add(L::mul(corner[0], axis[r][0]), L::mul(corner[1], axis[r][1])),
                                       L::mul(corner[2], axis[r][2]));
                least[r] = k == 0 ? along : L::select(L::greater64(least[r], along), along, least[r]);
                most[r] = k == 0 ? along : L::select(L::greater64(along, most[r]), along, most[r]);
            }
        }
        for (int r = 0; r < 3; ++r) {
            std::int64_t lows[N], highs[N];
            L::store64(lows, least[r]), L::store64(highs, most[r]);
            low[r] = lows[0], high[r] = highs[0];
            for (unsigned lane = 1; lane < N; ++lane) {
                low[r] = lows[lane] < low[r] ? lows[lane] : low[r];
                high[r] = highs[lane] > high[r] ? highs[lane] : high[r];
            }
        }
    }

  public:
    static constexpr shapes::SupportKernel table() { return {furthest, reach}; }
};

} // namespace lockstone::solve
