// Axes and bounds of rotated capsules and boxes in lanes, written once over the lanes L; see collide/bounds_kernel.h.
//
// Only files that are compiled for one instruction set include this. It must not use inline functions that other files
// use too, since the linker keeps only one of their copies.
#pragma once

#include "collide/bounds_kernel.h"
#include "solve/lanes/lane_rotation.h"

namespace lockstone::solve {

template <class L> class PlacedBoxes {
    static constexpr unsigned N = L::lanes;
    using V = typename L::V;
    using Boxes = collide::RoundBoxes;
    static_assert(N <= Boxes::lanes_max && Boxes::lanes_max % N == 0 && Boxes::room % Boxes::lanes_max == 0);

    /// |r half|; half is at least zero.
    static V along(V r, const std::int32_t* half) {
        const V product = L::mul(r, L::load32(half));
        return L::select(L::greater64(L::splat(0), product), L::sub(L::splat(0), product), product);
    }
    /// The distance that a shape reaches along a world axis; (x, y, z) is that axis in the axes of the shape. Like
    /// bounds_of(), in units of Real.
    static V reach(const Boxes& boxes, unsigned lane, V x, V y, V z) {
        constexpr int axis_bits = 30, finer = 8; // Real has 8 bits more than Length
        const V sum = L::add(L::add(along(x, &boxes.half[0][lane]), along(y, &boxes.half[1][lane])),
                             along(z, &boxes.half[2][lane]));
        const V whole =
            L::template shift_right<axis_bits>(L::add(sum, L::splat((std::int64_t{1} << axis_bits) - 1)));
        const V tight = L::add(whole, L::load64(&boxes.radius[lane]));
        const V all =
            L::add(L::add(tight, L::load64(&boxes.margin[lane])), L::template shift_right<27>(tight));
        return L::template shift_left<finer>(all);
    }
    static void store_axes(const Boxes& boxes, unsigned lane, const V (&r)[3][3]) {
        std::int32_t* to[N];
        for (unsigned i = 0; i < N; ++i) to[i] = boxes.axes[lane + i];
        const V all[9] = {r[0][0], r[0][1], r[0][2], r[1][0], r[1][1], r[1][2], r[2][0], r[2][1], r[2][2]};
        L::store_quads(to, all);
        for (auto& at : to) at += 4;
        L::store_quads(to, all + 4);
        for (auto& at : to) at += 1; // the last number, with three numbers that are stored already
        L::store_quads(to, all + 5);
    }
    static void store_bounds(const Boxes& boxes, unsigned lane, const V (&bounds)[6]) {
        std::int32_t* to[N];
        for (unsigned i = 0; i < N; ++i) to[i] = boxes.bounds[lane + i];
        L::store_quads(to, bounds);
        for (auto& at : to) at += 2;
        L::store_quads(to, bounds + 2);
    }
    static unsigned place_lanes(const Boxes& boxes, unsigned lane, int drop) {
        constexpr int near_bits = 32 + 14;
        const V near = L::splat(std::int64_t{1} << near_bits), by = L::splat(drop), one = L::splat(1);
        V q[4], r[3][3], bounds[6], any = L::splat(0);
        L::quads(&boxes.rotation[lane], q);
        const V no_rotation = rotation_of<L>(q, r);
        for (int i = 0; i < 3; ++i) {
            const V all = reach(boxes, lane, r[0][i], r[1][i], r[2][i]),
                    at = L::load64(&boxes.position[i][lane]);
            const V low = L::sub(at, all), high = L::add(at, all);
            any = L::either(any, L::either(L::add(low, near), L::add(high, near)));
            bounds[i] = L::shift_right_by(low, by);
            bounds[3 + i] = L::add(L::shift_right_by(high, by), one);
        }
        store_axes(boxes, lane, r), store_bounds(boxes, lane, bounds);
        const V beyond = L::greater64(L::template shift_right<near_bits + 1>(any), L::splat(0));
        return L::lanes_of(L::either(no_rotation, beyond));
    }

    static std::uint32_t place(const Boxes& boxes, std::uint32_t count, int drop) {
        std::uint32_t left = 0;
        for (unsigned lane = 0; lane < count; lane += N) left |= place_lanes(boxes, lane, drop) << lane;
        return left;
    }

  public:
    static constexpr collide::BoundsKernel table() { return {place}; }
};

} // namespace lockstone::solve
