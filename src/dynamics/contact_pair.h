// The two bodies of N contacts while their rows are solved. See contact.h for the symbols.
#pragma once

#include "dynamics/contact.h"

#include "lockstone/math.h"

#include <algorithm>

namespace lockstone::dynamics {

inline constexpr std::int32_t impulse_limit = 1 << 30; ///< 2048 m/s

template <unsigned N> Pair<N> gather(const ContactPack<N>& c, const SolverBodies& bodies) {
    Pair<N> p;
    for (unsigned lane = 0; lane < N; ++lane) {
        const SolverBody& a = bodies.body[c.body_a[lane]];
        const SolverBody& b = bodies.body[c.body_b[lane]];
        for (int i = 0; i < 3; ++i) {
            p.va[i].lane[lane] = a.v[i];
            p.ua[i].lane[lane] = a.u[i];
            p.vb[i].lane[lane] = b.v[i];
            p.ub[i].lane[lane] = b.u[i];
        }
    }
    return p;
}

/// Bodies that nothing moves are shared by the packs of a colour, so they are not written.
template <unsigned N> void scatter(const ContactPack<N>& c, const Pair<N>& p, SolverBodies& bodies) {
    for (unsigned lane = 0; lane < N; ++lane) {
        if ((c.moves_a >> lane) & 1u) {
            SolverBody& a = bodies.body[c.body_a[lane]];
            for (int i = 0; i < 3; ++i) {
                a.v[i] = p.va[i].lane[lane] & a.keep[i];
                a.u[i] = p.ua[i].lane[lane];
            }
        }
        if ((c.moves_b >> lane) & 1u) {
            SolverBody& b = bodies.body[c.body_b[lane]];
            for (int i = 0; i < 3; ++i) {
                b.v[i] = p.vb[i].lane[lane] & b.keep[i];
                b.u[i] = p.ub[i].lane[lane];
            }
        }
    }
}

/// D . (v, u): the row's relative speed, Speed.
template <unsigned N>
inline Int32<N> row_speed(const Pair<N>& p, const Int32<N> (&d)[3], const Int32<N> (&xa)[3],
                          const Int32<N> (&xb)[3]) {
    Int64<N> sum{};
    for (int i = 0; i < 3; ++i) {
        const Int32<N> dv = rounded<row_bits>(p.vb[i] - p.va[i]);
        sum = sum + d[i] * dv + xa[i] * rounded<row_bits>(p.ua[i]) + xb[i] * rounded<row_bits>(p.ub[i]);
    }
    return rounded<row_bits>(sum);
}

/// Adds the impulse change dp along the row to both bodies.
template <unsigned N>
inline void push(Pair<N>& p, const Int32<N> (&d)[3], const PointPack<N>& point, int row, Int32<N> dp) {
    const Int32<N> da = rounded<30>(dp * point.ratio_a), db = rounded<30>(dp * point.ratio_b);
    for (int i = 0; i < 3; ++i) {
        p.va[i] = p.va[i] - d[i] * da;
        p.ua[i] = p.ua[i] + point.xa[row][i] * da;
        p.vb[i] = p.vb[i] + d[i] * db;
        p.ub[i] = p.ub[i] + point.xb[row][i] * db;
    }
}

/// How the bodies of N contacts moved since the start of the tick, gathered once for all points; Separation.
template <unsigned N> struct Motion { Int32<N> apart[3], ta[3], tb[3]; };

template <unsigned N> Motion<N> gather_motion(const ContactPack<N>& c, const SolverBodies& bodies) {
    Motion<N> m;
    for (unsigned lane = 0; lane < N; ++lane) {
        const SolverBody& a = bodies.body[c.body_a[lane]];
        const SolverBody& b = bodies.body[c.body_b[lane]];
        for (int i = 0; i < 3; ++i) {
            m.apart[i].lane[lane] = saturate_to_int32(std::int64_t{b.shift[i]} - a.shift[i]);
            m.ta[i].lane[lane] = a.theta[i];
            m.tb[i].lane[lane] = b.theta[i];
        }
    }
    return m;
}

/// Current separation of a point, Separation.
template <unsigned N>
inline Int32<N> current_separation(const ContactPack<N>& c, const PointPack<N>& point, const Motion<N>& m) {
    Int64<N> sum{};
    for (int i = 0; i < 3; ++i)
        sum = sum + c.d[0][i] * m.apart[i] + point.xa[0][i] * m.ta[i] + point.xb[0][i] * m.tb[i];
    Int32<N> s;
    for (unsigned lane = 0; lane < N; ++lane)
        s.lane[lane] =
            saturate_to_int32(point.separation.lane[lane] + shift_right_rounded(sum.lane[lane], row_bits));
    return s;
}

/// Shortens the friction impulse (t1, t2) to friction * normal impulse: a true cone.
inline void clamp_to_cone(std::int32_t friction, std::int32_t normal, std::int32_t& t1, std::int32_t& t2) {
    const std::int64_t limit =
        std::int64_t{saturate_to_int32(shift_right_rounded(std::int64_t{friction} * normal, row_bits))};
    const std::int64_t square = std::int64_t{t1} * t1 + std::int64_t{t2} * t2;
    if (square <= limit * limit) return;
    const std::int64_t size = isqrt(static_cast<std::uint64_t>(square));
    t1 = static_cast<std::int32_t>(t1 * limit / (size + 1));
    t2 = static_cast<std::int32_t>(t2 * limit / (size + 1));
}

template <unsigned N> Int32<N> clamped(Int32<N> p) {
    return max(min(p, splat<N>(impulse_limit)), splat<N>(-impulse_limit));
}

/// What the normal row aims at besides zero speed.
template <unsigned N> struct NormalTarget { Int32<N> kappa, bias, impulse_scale; };

/// Slower than this on average, a contact rests, and its points settle among themselves [m/s]. Towers rest the better
/// for it: a rigid mean row would take the softness from them.
inline constexpr std::int32_t impact_speed_min = decimal<Speed>("0.25").raw;

} // namespace lockstone::dynamics
