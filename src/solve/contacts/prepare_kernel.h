// Prepares a pack: from contacts side by side to rows, effective masses, inverses and first impulses. Written once over
// the lanes L; see kernel.h for the files that may include it, contact_solver.h for the symbols, and pack.h for the
// formats.
//
// Values of one contact with more than 32 bits are LaneSum. Divisions and roots are computed lane by lane.
#pragma once

#include "math/roots.h"
#include "solve/contacts/layout_kernel.h"

namespace lockstone::solve {

template <class L> class PrepareKernel {
    static constexpr unsigned N = L::lanes;
    static constexpr int length_bits = 24;
    using Pack = ContactPack<N>;
    using Input = ContactInput<L>;
    using Side = typename Input::Side;
    using Layout = typename LayoutKernel<L>::Layout;
    using Gram = typename LayoutKernel<L>::Gram;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Row = LaneFixed<L, row_bits>;
    using Speed = LaneFixed<L, speed_bits>;
    using Unit = LaneFixed<L, unit_bits>;
    using Gap = LaneFixed<L, gap_bits>;
    using Response = LaneFixed<L, response_bits>;
    using Length = LaneFixed<L, length_bits>;
    template <int F> using Sum = LaneSum<L, F>;
    using Lanes64 = std::int64_t[N];

    static constexpr std::int64_t softness_limit = std::int64_t{1} << 30;
    static bool has(unsigned lanes, unsigned lane) { return ((lanes >> lane) & 1u) != 0; }

    // ---- directions ----------------------------------------------------------------------------------------------

    /// Computes tangents_of() the normal of each lane, and the velocities of surfaces along the tangents.
    static void find_tangents(Pack& c, Input& in) {
        constexpr std::int64_t one = std::int64_t{1} << unit_bits;
        Unit n[3], pole[3], from[3], first[3];
        Sum<2 *unit_bits> along = Sum<2 * unit_bits>::splat(0), off = along;
        for (int i = 0; i < 3; ++i) {
            n[i] = in.d[0][i];
            pole[i] = Unit::splat(solve::tangent_pole[i]), from[i] = Unit::splat(solve::tangent_from[i]);
            along = along + n[i] * pole[i], off = off + n[i] * from[i];
        }
        Lanes64 height, way, share;
        round_to<unit_bits>(along).store64(height), round_to<unit_bits>(off).store64(way);
        unsigned at_pole = 0;
        for (unsigned lane = 0; lane < N; ++lane) {
            share[lane] = 0;
            if (height[lane] < solve::tangent_pole_limit) {
                at_pole |= 1u << lane;
                continue;
            }
            const std::int64_t numerator = 2 * way[lane] * one + (one + height[lane]),
                               denominator = 2 * (one + height[lane]);
            share[lane] =
                numerator / denominator - (numerator % denominator < 0 ? 1 : 0); // to nearest, below 16
        }
        const Sum<unit_bits> by = Sum<unit_bits>::from_lanes(share);
        const Mask filled = in.count > LaneFixed<L, 0>::splat(0);
        for (int i = 0; i < 3; ++i) {
            const auto less = round_to<unit_bits>(wide(pole[i] + n[i]) * by);
            first[i] = low(clamp(wide(from[i]) - less, one)) & filled;
        }
        if (at_pole != 0) tangents_at_pole(at_pole, n, first);
        for (int i = 0; i < 3; ++i) in.d[1][i] = first[i];
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            in.d[2][i] = rounded_within<unit_bits>(n[j] * first[k] - n[k] * first[j], 0x7fffffff);
        }
        for (int r = 0; r < 2; ++r) {
            Sum<speed_bits + unit_bits> sum = Sum<speed_bits + unit_bits>::splat(0);
            for (int i = 0; i < 3; ++i) sum = sum + in.surface_velocity[i] * in.d[r + 1][i];
            rounded_within<speed_bits>(sum, 0x7fffffff).store(c.surface[r]);
        }
    }

    [[gnu::noinline]] static void tangents_at_pole(unsigned lanes, const Unit (&n)[3], Unit (&first)[3]) {
        std::int32_t normals[3][N], tangents[3][N];
        for (int i = 0; i < 3; ++i) n[i].store(normals[i]), first[i].store(tangents[i]);
        for (unsigned lane = 0; lane < N; ++lane) {
            if (!has(lanes, lane)) continue;
            std::int32_t normal[3] = {normals[0][lane], normals[1][lane], normals[2][lane]}, tangent[3];
            tangent_at_pole(normal, tangent);
            for (int i = 0; i < 3; ++i) tangents[i][lane] = tangent[i];
        }
        for (int i = 0; i < 3; ++i) first[i] = Unit::load(tangents[i]);
    }

    // ---- rows ----------------------------------------------------------------------------------------------------

    /// K^-1 of the bodies of one side, and the half that rounds its products.
    struct Turner {
        const Side& side;
        V half;
        explicit Turner(const Side& of)
            : side(of), half(L::shift_left_by(L::splat(1), L::sub(of.shift, L::splat(1)))) {}
    };
    /// Component i of K^-1 r, about the axes that are not locked. Mantissas are below 2^30, so sums stay below 2^63.
    static V turned(const Turner& t, const Length (&r)[3], int i) {
        constexpr int at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
        const auto part = [&](int k) {
            return L::mul(t.side.inverse[at[i][k]], L::both(r[k].raw, t.side.turns[k]));
        };
        return L::shift_right_by(L::add(L::add(part(0), part(1)), L::add(part(2), t.half)), t.side.shift);
    }
    /// K^-1 r as an angular row, each component within 4.
    static void turn(const Turner& t, const Length (&r)[3], bool negative, std::int32_t (&out)[3][N]) {
        for (int i = 0; i < 3; ++i) {
            const V x = clamp(Sum<row_bits>{turned(t, r, i)}, std::int64_t{4} << row_bits).raw;
            L::store32(out[i], negative ? L::sub(L::splat(0), x) : x);
        }
    }
    /// The largest component of K^-1 r, without a limit; 0 for a body that does not turn.
    static void find_largest(const Turner& t, const Length (&r)[3], std::int64_t (&out)[N]) {
        for (int i = 0; i < 3; ++i) {
            std::int64_t entry[N];
            L::store64(entry, turned(t, r, i));
            for (unsigned lane = 0; lane < N; ++lane) {
                const std::int64_t size = entry[lane] < 0 ? -entry[lane] : entry[lane];
                if (size > out[lane]) out[lane] = size;
            }
        }
    }
    /// x cross y; y is a unit vector.
    static void cross(const Length (&x)[3], const Unit (&y)[3], Length (&out)[3]) {
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            out[i] = rounded_within<length_bits>(x[j] * y[k] - x[k] * y[j], 0x7fffffff);
        }
    }
    static Sum<2 * row_bits> product(const std::int32_t (&x)[3][N], const std::int32_t (&y)[3][N]) {
        return Row::load(x[0]) * Row::load(y[0]) + Row::load(x[1]) * Row::load(y[1]) +
               Row::load(x[2]) * Row::load(y[2]);
    }
    /// This product without the locked axes.
    static Sum<2 * row_bits> product(const std::int32_t (&x)[3][N], const std::int32_t (&y)[3][N],
                                     const V (&keep)[3]) {
        Sum<2 * row_bits> sum = Sum<2 * row_bits>::splat(0);
        for (int i = 0; i < 3; ++i) sum = sum + (Row::load(x[i]) * Row::load(y[i]) & Mask::of(keep[i]));
        return sum;
    }
    /// Rows times the pair's inverse mass times rows, below 52: the response of their speeds to their impulses. The
    /// first `Lines` rows have linear parts, from `direction` on.
    template <int Lines>
    static void respond(const Pack& c, const Input& in, int direction, int rows,
                        const std::int32_t (&xa)[3][3][N], const std::int32_t (&xb)[3][3][N],
                        Response (&out)[6]) {
        const Unit alpha = Unit::load(c.share_a), beta = Unit::load(c.share_b);
        const auto narrow = [](Sum<2 * row_bits> q) { // rounds towards minus infinity
            return Response::of(L::template shift_right<2 * row_bits - response_bits>(q.raw));
        };
        int at = 0;
        for (int r = 0; r < 3; ++r)
            for (int s = 0; s <= r; ++s, ++at) {
                if (r >= rows) {
                    out[at] = Response::splat(0);
                    continue;
                }
                auto qa = product(xa[r], xa[s]), qb = product(xb[r], xb[s]);
                if (r < Lines) {
                    const auto &x = c.d[direction + r], &y = c.d[direction + s];
                    const auto line = product(x, y);
                    qa = qa + (c.locked != 0 ? product(x, y, in.a.keep) : line);
                    qb = qb + (c.locked != 0 ? product(x, y, in.b.keep) : line);
                }
                out[at] = rounded<response_bits>(narrow(qa) * alpha + narrow(qb) * beta);
            }
    }
    /// The rows of a contact: level and tilts, tangents and twist.
    static void make_rows(Pack& c, const Input& in, const Layout& l) {
        const Turner a(in.a), b(in.b);
        const auto row = [&](const Length(&at_a)[3], const Length(&at_b)[3], std::int32_t(&xa)[3][N],
                             std::int32_t(&xb)[3][N]) { turn(a, at_a, true, xa), turn(b, at_b, false, xb); };
        for (int r = 0; r < 3; ++r)
            for (int i = 0; i < 3; ++i) low(round_to<row_bits>(wide(in.d[r][i]))).store(c.d[r][i]);
        Length r[3], s[3];
        for (int k = 0; k < 3; ++k) {
            cross(l.centre_a, in.d[k], r), cross(l.centre_b, in.d[k], s);
            if (k == 0)
                row(r, s, c.normal_a[0], c.normal_b[0]);
            else
                row(r, s, c.slide_a[k - 1], c.slide_b[k - 1]);
        }
        if (c.point_count < 2) return;
        for (int k = 0; k < 2; ++k) {
            cross(l.along[k], in.d[0], r);
            row(r, r, c.normal_a[k + 1], c.normal_b[k + 1]);
        }
        for (int i = 0; i < 3; ++i) r[i] = rounded_within<length_bits>(l.size * in.d[0][i], 0x7fffffff);
        row(r, r, c.slide_a[2], c.slide_b[2]);
    }

    // ---- quantities from the rows ----------------------------------------------------------------------------------

    /// Computes the effective masses of the points. Returns the mean of the points' responses to their own impulses.
    static Sum<response_bits> fill_points(Pack& c, const Input& in, int points, const Layout& l,
                                          const Sum<response_bits> (&s)[6]) {
        Sum<response_bits> sum = Sum<response_bits>::splat(0);
        std::int64_t reach[4][N];
        for (int k = 0; k < points; ++k) {
            PointLanes<N>& point = c.points[k];
            in.separation[k].store(point.gap0), in.separation[k].store(point.gap);
            auto answer = s[0];
            if (points > 1) {
                const Unit a = low(l.arm[0][k]), b = low(l.arm[1][k]);
                a.store(point.arm[0]), b.store(point.arm[1]);
                // The response arm^T S arm: S is below 2^31, arms at most 2^30.
                const auto by_a = round_to<response_bits>(low(s[2]) * a) + (s[1] + s[1]);
                const auto sa = round_to<response_bits>(low(s[4]) * a);
                const auto by_b = round_to<response_bits>(low(s[5]) * b) + (s[3] + s[3]) + (sa + sa);
                answer = answer + round_to<response_bits>(by_a * l.arm[0][k]) +
                         round_to<response_bits>(by_b * l.arm[1][k]);
                (a * a + b * b).store64(reach[k]);
            }
            answer = answer & l.exists[k];
            sum = sum + answer;
            const Mask answers = ~(Sum<response_bits>::splat(least_response) > answer);
            Lanes64 of;
            select(answers, answer, Sum<response_bits>::splat(1)).store64(of);
            for (std::int64_t& x : of) x = (std::int64_t{1} << (kappa_bits + response_bits)) / x;
            (low(Sum<kappa_bits>::from_lanes(of)) & answers).store(point.kappa);
        }
        if (points > 1) {
            detail::take_roots(reach[0], static_cast<unsigned>(points) * N);
            for (int k = 0; k < points; ++k) low(Sum<unit_bits>::load64(reach[k])).store(c.points[k].reach);
        }
        Lanes64 mean;
        sum.store64(mean);
        for (unsigned lane = 0; lane < N; ++lane)
            mean[lane] = in.counts[lane] > 1 ? mean[lane] / in.counts[lane] : mean[lane];
        return Sum<response_bits>::from_lanes(mean);
    }

    /// X, the softness of a pair that gives up the share `ease` of its impulse in a substep. Adds X to S.
    static void soften(Pack& c, const Input& in, const Gram& g, Sum<response_bits> mean,
                       Sum<response_bits> (&s)[6]) {
        constexpr int place[4] = {0, 2, 4, 5};
        const auto gamma = round_to<response_bits>(mean * in.ease); // below 2^31
        const Sum<response_bits> zero = Sum<response_bits>::splat(0);
        for (int i = 0; i < (c.point_count > 1 ? 4 : 1); ++i) {
            const auto x =
                clamp(floor_to<response_bits>(gamma * floor_to<fit_bits - 4>(g.of[i])), softness_limit);
            low(x).store(c.softness[i]);
            Sum<response_bits>& entry = s[place[i]];
            entry = i == 0 ? entry + x : entry + (x & ((entry > zero) | (zero > entry)));
        }
    }

    static constexpr std::int64_t range = 0x7fffffff;
    /// Clamps a factor of a matrix that is no response matrix.
    static Sum<27> bounded_factor(Sum<27> x) { return clamp(x, range); }

    static constexpr int factor_bits = 27, ratio_bits = 20; ///< fraction bits of L and of L^-1

    /// A symmetric matrix during its inversion by L D L^T. Rows: level and two tilts, or two tangents and the twist.
    struct Factors {
        Sum<response_bits> m[6], e21, p2;
        LaneFixed<L, factor_bits> l10, l20;
        LaneFixed<L, ratio_bits> l21, i20; ///< i20: of L^-1
        Sum<inverse_bits> d0, d1;
        Mask answers;
        alignas(64) Lanes64 pivot, part;
    };
    /// Stores the divisors of the next step. A lane without response gets 1, so that the divisions need no test.
    static void store_pivot(Sum<response_bits> pivot, Sum<response_bits> least, Factors& f) {
        f.answers = ~(least > pivot);
        select(f.answers, pivot, Sum<response_bits>::splat(1)).store64(f.pivot);
    }
    /// The smallest pivot of a row. A row whose pivot is below a 1024th of its own response depends on the rows
    /// before it.
    static Sum<response_bits> least_of(Sum<response_bits> alone) {
        const Sum<response_bits> floor{L::template shift_right_signed<10>(alone.raw)},
            least = Sum<response_bits>::splat((1 << 12) + 1);
        return select(floor > least, floor, least);
    }
    static Sum<inverse_bits> inverse_of(Factors& f) {
        constexpr std::int64_t top = std::int64_t{1} << (response_bits + inverse_bits);
        Lanes64 x;
        for (unsigned lane = 0; lane < N; ++lane) x[lane] = top / f.pivot[lane];
        return Sum<inverse_bits>::from_lanes(x) & f.answers;
    }
    /// Clamps the entries of m at 2^31.
    static void begin_inverse(const Sum<response_bits> (&entries)[6], Factors& f) {
        for (int i = 0; i < 6; ++i) f.m[i] = clamp(entries[i], range);
        store_pivot(f.m[0], Sum<response_bits>::splat(least_response), f);
    }
    static void clear_first(Factors& f) {
        Lanes64 x;
        for (unsigned lane = 0; lane < N; ++lane) // 28 fraction bits, at most 4
            x[lane] = (std::int64_t{1} << (response_bits + 28)) / f.pivot[lane];
        const Sum<28> inverse = Sum<28>::from_lanes(x) & f.answers;
        const auto at = [&](int i) { return low(f.m[i]); };
        f.d0 = floor_to<inverse_bits>(inverse);
        f.l10 = low(bounded_factor(round_to<factor_bits>(at(1) * low(inverse))));
        f.l20 = low(bounded_factor(round_to<factor_bits>(at(3) * low(inverse))));
        f.e21 = clamp(f.m[4] - round_to<response_bits>(f.l20 * at(1)), range);
        f.p2 = f.m[5] - round_to<response_bits>(f.l20 * at(3));
        store_pivot(f.m[2] - round_to<response_bits>(f.l10 * at(1)), least_of(f.m[2]), f);
        (f.e21 & f.answers).store64(f.part);
    }
    static void clear_second(Factors& f) {
        f.d1 = inverse_of(f);
        Lanes64 x;
        for (unsigned lane = 0; lane < N; ++lane) x[lane] = f.part[lane] * (1 << ratio_bits) / f.pivot[lane];
        const auto ratio = clamp(Sum<ratio_bits>::from_lanes(x), range);
        f.l21 = low(ratio);
        const auto l = round_to<ratio_bits>(f.l10 * f.l21) - round_to<ratio_bits>(wide(f.l20));
        f.i20 = low(clamp(l, range));
        store_pivot(f.p2 - round_to<response_bits>(f.l21 * low(f.e21)), least_of(f.m[5]), f);
        f.answers = f.answers & is_inside(l) & is_inside(ratio);
    }
    /// True if |x| is less than `range`.
    static Mask is_inside(Sum<ratio_bits> x) {
        return (Sum<ratio_bits>::splat(range) > x) & (x > Sum<ratio_bits>::splat(-range));
    }
    /// The inverse of a matrix whose third row is zero.
    static void invert_two(const Sum<response_bits> (&entries)[6], std::int32_t (&out)[6][N]) {
        Factors f;
        begin_inverse(entries, f), clear_first(f);
        f.d1 = inverse_of(f);
        const auto r = round_to<inverse_bits>(f.l10 * low(f.d1));
        const auto r00 = f.d0 + round_to<inverse_bits>(f.l10 * low(clamp(r, range)));
        low(clamp(r00, range)).store(out[0]), low(clamp(-r, range)).store(out[1]);
        low(clamp(f.d1, range)).store(out[2]);
    }
    /// m^-1 of symmetric matrices, by rows of the lower triangle. A row without response, or one that depends on the
    /// rows before it, becomes zero. The matrices go through each step together: a step depends on the step before it
    /// of the same matrix alone, so the processor overlaps their divisions.
    template <std::size_t Count>
    [[gnu::noinline]] static void invert(const Sum<response_bits> (&entries)[Count][6],
                                         std::int32_t (*const (&out)[Count])[N]) {
        Factors f[Count];
        for (std::size_t k = 0; k < Count; ++k) begin_inverse(entries[k], f[k]);
        for (Factors& each : f) clear_first(each);
        for (Factors& each : f) clear_second(each);
        for (std::size_t k = 0; k < Count; ++k) finish_inverse(f[k], out[k]);
    }
    static Mask within(Sum<inverse_bits> x) {
        return ~((x > Sum<inverse_bits>::splat(range)) | (Sum<inverse_bits>::splat(-range) > x));
    }
    static void finish_inverse(Factors& f, std::int32_t (*out)[N]) {
        auto d2 = inverse_of(f);
        const auto r = round_to<inverse_bits>(f.l10 * low(f.d1));
        const auto r00 = f.d0 + round_to<inverse_bits>(f.l10 * low(clamp(r, range)));
        for (;;) {
            const auto i20 = round_to<inverse_bits>(f.i20 * low(d2)),
                       i21 = -round_to<inverse_bits>(f.l21 * low(d2));
            const Sum<inverse_bits> all[6] = {r00 + round_to<inverse_bits>(f.i20 * low(i20)),
                                              -r - round_to<inverse_bits>(f.l21 * low(i20)),
                                              f.d1 - round_to<inverse_bits>(f.l21 * low(i21)),
                                              i20,
                                              i21,
                                              d2};
            Mask fits = within(all[0]);
            for (int i = 1; i < 6; ++i) fits = fits & within(all[i]);
            const Mask again = ~fits & (d2 > Sum<inverse_bits>::splat(0));
            if (!again.any()) {
                for (int i = 0; i < 6; ++i) low(clamp(all[i], range)).store(out[i]);
                return;
            }
            d2 = d2 & ~again; // drops the last row where its inverse exceeds the format
        }
    }

    /// The impulses of the last tick, except those of points that part now.
    static void start_impulses(Pack& c, const Input& in, int points, const Layout& l,
                               const solve::SolverBody* bodies) {
        const Speed zero = Speed::splat(0), most = Speed::splat(impulse_limit);
        Mask carries = Mask::none();
        for (int k = 0; k < points; ++k) carries = carries | (in.impulse[k] > zero);
        if (!carries.any()) return;
        const solve::SolverBody *a[N], *b[N];
        for (unsigned lane = 0; lane < N; ++lane)
            a[lane] = &bodies[c.body_a[lane]], b[lane] = &bodies[c.body_b[lane]];
        V raw[12];
        L::gather6(a, raw);
        L::gather6(b, raw + 6);
        constexpr int sum_bits = row_bits + speed_bits;
        static_assert(sum_bits == accumulator_bits);
        const auto speed = [&](int i) {
            return Speed::of(L::template shift_right<accumulator_bits - speed_bits>(raw[i]));
        };
        Sum<speed_bits> level;
        Speed tilt[2];
        for (int r = 0; r < (points > 1 ? 3 : 1); ++r) {
            Sum<sum_bits> sum = Sum<sum_bits>::splat(0);
            for (int i = 0; i < 3; ++i) {
                if (r == 0) sum = sum + Row::load(c.d[0][i]) * (speed(6 + i) - speed(i));
                sum = sum + Row::load(c.normal_a[r][i]) * speed(3 + i) +
                      Row::load(c.normal_b[r][i]) * speed(9 + i);
            }
            if (r == 0)
                level = round_to<speed_bits>(sum);
            else
                tilt[r - 1] = low(clamp(round_to<speed_bits>(sum), 0x7fffffff));
        }
        Mask rests = Mask::none();
        for (int k = 0; k < points; ++k) {
            auto leaves = level;
            if (points > 1)
                leaves = leaves + round_to<speed_bits>(low(l.arm[0][k]) * tilt[0]) +
                         round_to<speed_bits>(low(l.arm[1][k]) * tilt[1]);
            const Speed p =
                min(max(in.impulse[k], zero), most) & ~(leaves > Sum<speed_bits>::splat(leaving_speed));
            p.store(c.points[k].impulse);
            rests = rests | (p > zero);
        }
        for (int r = 0; r < 2; ++r) (clamp(in.slide[r], most) & rests).store(c.slide[r]);
        std::int32_t size[N], twists[N];
        l.size.store(size), in.twist.store(twists);
        for (unsigned lane = 0; lane < N; ++lane) {
            if (!has(rests.lanes(), lane) || size[lane] == 0) continue;
            const std::int64_t twist = std::int64_t{twists[lane]} * (1 << speed_bits), half = size[lane] / 2;
            const std::int64_t impulse = (twist + (twist < 0 ? -half : half)) /
                                         size[lane]; // to nearest: otherwise friction yields in every tick
            c.slide[2][lane] = static_cast<std::int32_t>(impulse > impulse_limit    ? impulse_limit
                                                         : impulse < -impulse_limit ? -impulse_limit
                                                                                    : impulse);
        }
    }

    /// The patch of a long body, such as a beam, is narrow across its longest arm, and the body turns easily about that
    /// arm. So the row of that tilt would leave its range, and the fit would take the members for a line. Without a
    /// response to rolling over, a beam rocks without end. So this shortens the unit of the arms across by a power of
    /// two, until the row is within 2 or the arms fill their range.
    static void widen(const Input& in, int points, Layout& l) {
        constexpr int narrow_bits = unit_bits - 2;
        std::int64_t across[4][N];
        int up[N];
        bool any = false;
        for (int k = 0; k < points; ++k) l.arm[1][k].store64(across[k]);
        for (unsigned lane = 0; lane < N; ++lane) {
            std::int64_t widest = 0;
            for (int k = 0; k < points; ++k)
                widest |= across[k][lane] < 0 ? -across[k][lane] : across[k][lane];
            const int bits = 64 - std::countl_zero(static_cast<std::uint64_t>(widest));
            up[lane] = widest == 0 || bits > narrow_bits ? 0 : unit_bits - bits;
            any = any || up[lane] != 0;
        }
        if (!any) return;
        std::int64_t row[N] = {};
        Length r[3];
        cross(l.along[1], in.d[0], r);
        find_largest(Turner(in.a), r, row), find_largest(Turner(in.b), r, row);
        for (unsigned lane = 0; lane < N; ++lane) {
            const int by_row = 64 - std::countl_zero(static_cast<std::uint64_t>(row[lane])) - (row_bits + 1);
            up[lane] = by_row < 0 ? 0 : up[lane] < by_row ? up[lane] : by_row;
            for (int k = 0; k < points; ++k) across[k][lane] *= std::int64_t{1} << up[lane];
        }
        for (int k = 0; k < points; ++k) l.arm[1][k] = Sum<unit_bits>::from_lanes(across[k]);
        for (int i = 0; i < 3; ++i) {
            std::int32_t along[N];
            l.along[1][i].store(along);
            for (unsigned lane = 0; lane < N; ++lane)
                along[lane] = static_cast<std::int32_t>(
                    // has more than 31 bits in between
                    shift_right_rounded(std::int64_t{along[lane]}, up[lane]));
            l.along[1][i] = Length::load(along);
        }
    }

    // ---- the steps --------------------------------------------------------------------------------------------------

    /// The results that a step passes to the next one.
    struct Work {
        Input in;
        Layout layout;
        Gram gram;
        Response of_slide[6], of_normals[6];
    };
    [[gnu::noinline]] static void lay_out(Pack& c, const PackSource& source, Work& w) {
        const int points = c.point_count;
        Input::read(source, points, w.in);
        find_tangents(c, w.in);
        LayoutKernel<L>::lay_out(w.in, points, w.layout);
        if (points > 1) widen(w.in, points, w.layout);
        w.layout.size.store(c.size);
        LayoutKernel<L>::fit_members(c, points, w.layout, w.gram);
    }
    [[gnu::noinline]] static void find_responses(Pack& c, Work& w) {
        const bool several = c.point_count > 1;
        make_rows(c, w.in, w.layout);
        respond<2>(c, w.in, 1, several ? 3 : 2, c.slide_a, c.slide_b, w.of_slide);
        respond<1>(c, w.in, 0, several ? 3 : 1, c.normal_a, c.normal_b, w.of_normals);
        for (int i = 0; i < 6; ++i) w.of_normals[i].store(c.response[i]);
    }
    [[gnu::noinline]] static void find_masses(Pack& c, Work& w, const solve::SolverBody* bodies) {
        const int points = c.point_count;
        Sum<response_bits> s[3][6]; // of friction, of normals, and of normals with softness
        for (int i = 0; i < 6; ++i) s[0][i] = wide(w.of_slide[i]), s[1][i] = wide(w.of_normals[i]);
        const Sum<response_bits> mean = fill_points(c, w.in, points, w.layout, s[1]);
        start_impulses(c, w.in, points, w.layout, bodies);
        if (points == 1) return invert_two(s[0], c.slide_inverse);
        for (int i : {1, 2}) s[1][i] = s[1][i] & w.gram.tilts;
        for (int i : {3, 4, 5}) s[1][i] = s[1][i] & w.gram.plane;
        for (int i = 0; i < 6; ++i) s[2][i] = s[1][i];
        soften(c, w.in, w.gram, mean, s[2]);
        invert<3>(s, {c.slide_inverse, c.inverse, c.soft_inverse});
    }

  public:
    /// Prepares packs whose heads are filled (fill_lane) from their contacts. All packs go through each step together:
    /// a cache of 32 KB has room for the instructions of one step, but not of all steps.
    static void prepare(void* packs, const PackSource* sources, unsigned count,
                        const solve::SolverBody* bodies) {
        Pack* const c = static_cast<Pack*>(packs);
        Work work[prepared_at_once];
        for (unsigned i = 0; i < count; ++i)
            if (c[i].point_count != 0) lay_out(c[i], sources[i], work[i]);
        for (unsigned i = 0; i < count; ++i)
            if (c[i].point_count != 0) find_responses(c[i], work[i]);
        for (unsigned i = 0; i < count; ++i)
            if (c[i].point_count != 0) find_masses(c[i], work[i], bodies);
    }
};

} // namespace lockstone::solve
