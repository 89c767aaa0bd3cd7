// What contacts that bounce keep of a tick: at which speed their points come in, and the energy that these take.
//
// Included as kernel.h, by which this is used.
#pragma once

#include "solve/contacts/pack.h"
#include "solve/lanes/lane_fixed.h"

namespace lockstone::solve {

/// Of the passes K = Kernel<L>, which say how velocities are gathered and seen by rows.
template <class L, class K> class BounceKernel {
    static constexpr unsigned N = L::lanes;
    using Pack = ContactPack<N>;
    using V = typename L::V;
    using Speed = LaneFixed<L, speed_bits>;

    /// Whether all velocities are below 16 m/s: then no speed of a row meets the end of its range, 512 m/s.
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
    /// measure_approach() of all lanes at once.
    static void measure(const Pack& c, const PassData& data) {
        typename K::Pair p;
        K::gather(c, data.bodies, p);
        if (!is_slow(p)) return measure_approach<N>(c, data.bounces, data.bodies);
        p.round();
        Speed speed[3];
        K::find_speeds(c, p, speed);
        std::int32_t at[4][N];
        for (int k = 0; k < c.point_count; ++k) K::at_point(c.points[k], speed).store(at[k]);
        keep_approach<N>(c, data.bounces, at);
    }

    /// The speeds of the points before (level and tilts) and after, for the energy that a bounce may give back.
    template <class Pair>
    [[gnu::noinline]] static void note(Pack& c, const PassData& data, const PassSettings& s,
                                       const Speed (&speed)[3], const Speed (&old)[4], Pair& p) {
        std::int32_t before[4][N] = {}, after[4][N] = {}, impulse[4][N] = {};
        Speed then[3];
        p.round();
        K::find_speeds(c, p, then);
        for (int k = 0; k < c.point_count; ++k) {
            K::at_point(c.points[k], speed).store(before[k]);
            K::at_point(c.points[k], then).store(after[k]);
            old[k].store(impulse[k]);
        }
        note_bounce<N>(c, data.bounces, s.bounce_speed_min, before, after, impulse);
    }
};

} // namespace lockstone::solve
