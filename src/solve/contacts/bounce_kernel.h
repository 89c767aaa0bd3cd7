// Finds the contacts that bounce and are hit in a substep.
//
// kernel.h includes this; the rules for its inclusion are there.
#pragma once

#include "solve/contacts/pack.h"
#include "solve/lanes/lane_fixed.h"

namespace lockstone::solve {

/// K = Kernel<L>, the passes: it has the functions that gather velocities and project them on rows.
template <class L, class K> class BounceKernel {
    using Pack = ContactPack<L::lanes>;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Speed = LaneFixed<L, speed_bits>;
    using Gap = LaneFixed<L, gap_bits>;

    /// True if all velocities are below 16 m/s: then no speed of a row reaches the end of its range, 512 m/s.
    template <class Pair> static bool is_slow(const Pair& p) {
        constexpr std::int64_t limit = std::int64_t{1} << (accumulator_bits + 4);
        V beyond = L::splat(0);
        for (int i = 0; i < 6; ++i)
            for (const V x : {p.a[i].raw, p.b[i].raw})
                beyond = L::either(
                    beyond, L::either(L::greater64(x, L::splat(limit)), L::greater64(L::splat(-limit), x)));
        return L::lanes_of(beyond) == 0;
    }

  public:
    /// find_hits() for all lanes at once.
    static void find(Pack& c, const PassData& data, const PassSettings& s) {
        typename K::Pair p;
        K::gather(c, data.bodies, p);
        if (!is_slow(p)) return find_hits<L::lanes>(c, data.bodies, s);
        p.round();
        Speed speed[3];
        K::find_speeds(c, p, speed);
        const Speed zero = Speed::splat(0);
        const LaneFixed<L, 0> rate = LaneFixed<L, 0>::splat(s.substeps_per_second);
        Mask hits = Mask::none();
        for (int k = 0; k < c.point_count; ++k) {
            const auto& point = c.points[k];
            const Speed closing = zero - K::at_point(point, speed);
            const Gap gap = min(max(Gap::load(point.gap), Gap::splat(0)), Gap::splat(s.gap_max));
            const Speed limit = rounded<speed_bits>(gap * rate);
            const Mask can_push =
                LaneFixed<L, kappa_bits>::load(point.kappa) > LaneFixed<L, kappa_bits>::splat(0);
            hits = hits | (can_push & (closing > Speed::splat(s.bounce_speed_min)) & ~(limit > closing));
        }
        c.struck = (hits & Mask::load(c.bounces)).lanes();
    }
};

} // namespace lockstone::solve
