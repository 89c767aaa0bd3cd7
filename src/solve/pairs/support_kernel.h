// The farthest corner of a hull in lanes, written once over the lanes L; see shapes/hull/support_kernel.h.
//
// Only files that are compiled for one instruction set include this. It must not use inline functions that other files
// use too, since the linker keeps only one of their copies.
#pragma once

#include "shapes/hull/support_kernel.h"
#include "solve/lanes/lane_fixed.h"

#include <cstddef>

namespace lockstone::solve {

template <class L> class HullSupport {
    static constexpr unsigned N = L::lanes;
    using V = typename L::V;

    static constexpr std::int32_t numbers[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

    /// Replaces the first corner by the second if that is farther, or equally far with a lower number. Uses masks:
    /// both outcomes are equally likely, so a processor would often predict a branch wrongly.
    static void keep_further(std::int64_t& reach, std::int64_t& corner, std::int64_t reach_of_other,
                             std::int64_t other) {
        const bool is_further = reach_of_other + std::int64_t{other < corner} > reach;
        const std::int64_t all = -std::int64_t{is_further};
        reach ^= (reach ^ reach_of_other) & all;
        corner ^= (corner ^ other) & all;
    }

    /// Each lane visits every Nth corner and keeps the first of its farthest ones.
    static std::uint32_t furthest(const std::int32_t* corners, std::uint32_t stride,
                                  const std::int32_t (&direction)[3]) {
        static_assert(N <= 16);
        const V x = L::splat(direction[0]), y = L::splat(direction[1]), z = L::splat(direction[2]);
        const std::size_t count = stride;
        const std::int32_t *const ys = corners + count, *const zs = ys + count;
        const auto along = [&](std::size_t k) {
            return L::add(L::add(L::mul(L::load32(corners + k), x), L::mul(L::load32(ys + k), y)),
                          L::mul(L::load32(zs + k), z));
        };
        const V lanes = L::splat(N);
        // Whole lanes, since the numbers are compared as 64 bits below.
        V number = load_extended<L>(numbers), most = along(0), corner = number;
        for (std::size_t k = N; k < count; k += N) {
            const V next = along(k), more = L::greater64(next, most);
            number = L::add(number, lanes);
            most = L::select(more, next, most);
            corner = L::select(more, number, corner);
        }
        std::int64_t reach[N], best[N];
        L::store64(reach, most), L::store64(best, corner);
        for (unsigned half = N / 2; half != 0; half /= 2)
            for (unsigned lane = 0; lane < half; ++lane)
                keep_further(reach[lane], best[lane], reach[lane + half], best[lane + half]);
        return static_cast<std::uint32_t>(best[0]);
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
