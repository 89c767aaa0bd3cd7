// The passes over contacts, written once over the lanes L. See contact_solver.h for the symbols, pack.h for the
// formats.
//
// Only files that are compiled for one instruction set include this. It must not use inline functions that other files
// use too, since the linker keeps only one of their copies.
// Long: normals, friction and impacts of a pack are one class, whose functions the compiler inlines into each other.
#pragma once

#include "math/roots.h"
#include "solve/contacts/ahead_kernel.h"
#include "solve/contacts/bounce_kernel.h"
#include "solve/contacts/pack.h"
#include "solve/contacts/prepare_kernel.h"
#include "solve/lanes/lane_fixed.h"

#include <bit>

#if LOCKSTONE_GNU && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" // arrays by point: every pack has at least one point
#endif

namespace lockstone::solve {

template <class L> class Kernel {
    using Bounces = BounceKernel<L, Kernel>;
    friend Bounces;
    static constexpr unsigned N = L::lanes;
    using Pack = ContactPack<N>;
    using Point = PointLanes<N>;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Row = LaneFixed<L, row_bits>;
    using Speed = LaneFixed<L, speed_bits>;
    using Unit = LaneFixed<L, unit_bits>;
    using Gap = LaneFixed<L, gap_bits>;
    using Kappa = LaneFixed<L, kappa_bits>;
    using Response = LaneFixed<L, response_bits>;
    using Inverse = LaneFixed<L, inverse_bits>;
    using Fit = LaneFixed<L, fit_bits>;
    using Velocity = LaneSum<L, accumulator_bits>;

    static constexpr std::int32_t speed_limit = 1 << 28;  ///< 512 m/s, of an error of speed
    static constexpr std::int32_t answer_limit = 1 << 29; ///< of an impulse that corrects such an error
    static constexpr std::int32_t impact_speed = 1 << 17; ///< 0.25 m/s: a faster impact is a hit
    static constexpr std::int32_t pull_tolerance = 16;    ///< 3e-5 m/s: a smaller pull is rounding
    /// 1 m: a deeper overlap is pushed out no faster
    static constexpr std::int32_t overlap_max = 1 << gap_bits;
    static constexpr int lower[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};

    /// Velocities of the two bodies of each lane, and the same rounded to the format of rows.
    struct Pair {
        Velocity a[6], b[6]; ///< v, u
        Speed apart[3], ua[3], ub[3];

        void round() {
            for (int i = 0; i < 3; ++i) {
                apart[i] = rounded<speed_bits>(b[i] - a[i]);
                ua[i] = rounded<speed_bits>(a[3 + i]);
                ub[i] = rounded<speed_bits>(b[3 + i]);
            }
        }
    };

    /// `of`: bodies, or the velocities with which they start the next substep.
    template <class Body> static void gather(const Pack& c, const Body* of, Pair& p) {
        const Body *a[N], *b[N];
        for (unsigned lane = 0; lane < N; ++lane)
            a[lane] = &of[c.body_a[lane]], b[lane] = &of[c.body_b[lane]];
        V raw[12];
        L::gather6(a, raw);
        L::gather6(b, raw + 6);
        for (int i = 0; i < 6; ++i) p.a[i] = {raw[i]}, p.b[i] = {raw[6 + i]};
    }

    /// Bodies that impulses do not move are shared by the packs of all workers, so they are not written.
    template <class Body> static void scatter(const Pack& c, Body* of, const Pair& p) {
        scatter_side(c.body_a, c.movable_a, of, p.a);
        scatter_side(c.body_b, c.movable_b, of, p.b);
    }
    template <class Body>
    static void scatter_side(const std::uint32_t (&rows)[N], std::uint32_t movable, Body* of,
                             const Velocity (&x)[6]) {
        V raw[6];
        for (int i = 0; i < 6; ++i) raw[i] = x[i].raw;
        Body* to[N];
        Body spare;
        for (unsigned lane = 0; lane < N; ++lane)
            to[lane] = (movable >> lane) & 1u ? &of[rows[lane]] : &spare;
        if (movable != 0) L::scatter6(to, raw);
    }

    /// Removes velocities along locked axes from the bodies that move.
    static void hold_locked(const Pack& c, const PassData& data, Pair& p) {
        for (int i = 0; i < 3; ++i) {
            std::int64_t a[N], b[N];
            for (unsigned lane = 0; lane < N; ++lane) {
                a[lane] = data.bodies[c.body_a[lane]].keep[i] | ((c.movable_a >> lane) & 1u ? 0 : -1);
                b[lane] = data.bodies[c.body_b[lane]].keep[i] | ((c.movable_b >> lane) & 1u ? 0 : -1);
            }
            p.a[i] = {L::both(p.a[i].raw, L::load64(a))};
            p.b[i] = {L::both(p.b[i].raw, L::load64(b))};
        }
    }

    static LaneSum<L, accumulator_bits> dot(const std::int32_t (&x)[3][N], const Speed (&y)[3]) {
        return Row::load(x[0]) * y[0] + Row::load(x[1]) * y[1] + Row::load(x[2]) * y[2];
    }
    static Speed bounded(Speed x) { return clamp(x, Speed::splat(speed_limit)); }
    static Speed turn_speed(const Pair& p, const std::int32_t (&xa)[3][N], const std::int32_t (&xb)[3][N]) {
        return bounded(rounded<speed_bits>(dot(xa, p.ua) + dot(xb, p.ub)));
    }
    static Speed line_speed(const Pair& p, const std::int32_t (&d)[3][N], const std::int32_t (&xa)[3][N],
                            const std::int32_t (&xb)[3][N]) {
        return bounded(rounded<speed_bits>(dot(d, p.apart) + dot(xa, p.ua) + dot(xb, p.ub)));
    }

    /// Adds impulses along rows. The first `Lines` rows have a linear part. The loop goes by component, so that each
    /// velocity is read and written once.
    template <int Lines, int Rows>
    static void push_rows(const Pack& c, int direction, const std::int32_t (&xa)[3][3][N],
                          const std::int32_t (&xb)[3][3][N], const Speed (&w)[3], Pair& p) {
        const Unit alpha = Unit::load(c.share_a), beta = Unit::load(c.share_b);
        Speed da[3], db[3];
        for (int r = 0; r < Rows; ++r)
            da[r] = rounded<speed_bits>(w[r] * alpha), db[r] = rounded<speed_bits>(w[r] * beta);
        for (int i = 0; i < 3; ++i) {
            Velocity va = p.a[i], vb = p.b[i], ua = p.a[3 + i], ub = p.b[3 + i];
            for (int r = 0; r < Lines; ++r) {
                const Row along = Row::load(c.d[direction + r][i]);
                va = va - along * da[r], vb = vb + along * db[r];
            }
            for (int r = 0; r < Rows; ++r) {
                ua = ua + Row::load(xa[r][i]) * da[r];
                ub = ub + Row::load(xb[r][i]) * db[r];
            }
            p.a[i] = va, p.b[i] = vb, p.a[3 + i] = ua, p.b[3 + i] = ub;
        }
    }
    template <int Lines>
    static void push(const Pack& c, int direction, const std::int32_t (&xa)[3][3][N],
                     const std::int32_t (&xb)[3][3][N], const Speed (&w)[3], Pair& p) {
        if (c.point_count > 1)
            push_rows<Lines, 3>(c, direction, xa, xb, w, p);
        else
            push_rows<Lines, Lines>(c, direction, xa, xb, w, p);
    }
    static void push_normal(const Pack& c, const Speed (&w)[3], Pair& p) {
        push<1>(c, 0, c.normal_a, c.normal_b, w, p);
    }
    static void push_slide(const Pack& c, const Speed (&w)[3], Pair& p) {
        push<2>(c, 1, c.slide_a, c.slide_b, w, p);
    }

    // ---- gaps ----------------------------------------------------------------------------------------------------

    /// Updates the gap of each point from the motion of the bodies since the tick began.
    static void measure_gaps(Pack& c, const PassData& data) {
        const solve::SolverBody *a[N], *b[N];
        for (unsigned lane = 0; lane < N; ++lane)
            a[lane] = &data.bodies[c.body_a[lane]], b[lane] = &data.bodies[c.body_b[lane]];
        V raw[12];
        L::gather_motion(a, raw);
        L::gather_motion(b, raw + 6);
        constexpr int sum_bits = gap_bits + row_bits;
        LaneSum<L, sum_bits> level{L::splat(0)};
        const auto at = [&](int i) { return Gap::of(raw[i]); };
        for (int i = 0; i < 3; ++i) {
            const Row n = Row::load(c.d[0][i]);
            level = level + (n * at(6 + i) - n * at(i)) + Row::load(c.normal_a[0][i]) * at(3 + i) +
                    Row::load(c.normal_b[0][i]) * at(9 + i);
        }
        if (c.point_count == 1) {
            after_motion(c.points[0], level).store(c.points[0].gap);
            return;
        }
        Gap tilt[2];
        for (int r = 0; r < 2; ++r) {
            LaneSum<L, sum_bits> sum{L::splat(0)};
            for (int i = 0; i < 3; ++i)
                sum = sum + Row::load(c.normal_a[r + 1][i]) * at(3 + i) +
                      Row::load(c.normal_b[r + 1][i]) * at(9 + i);
            tilt[r] = rounded_within<gap_bits>(sum, 1 << 29);
        }
        const Gap middle = rounded_within<gap_bits>(level, 1 << 30);
        constexpr std::int32_t one = 1 << unit_bits;
        for (int k = 0; k < c.point_count; ++k) {
            Point& point = c.points[k];
            const auto sum = middle * Unit::splat(one) + Gap::load(point.gap0) * Unit::splat(one) +
                             tilt[0] * Unit::load(point.arm[0]) + tilt[1] * Unit::load(point.arm[1]);
            Gap gap = rounded_within<gap_bits>(sum, gap_limit);
            // A contact of one point has to get the same gap as in a pack of such contacts alone, also where its motion
            // exceeds the limit of `middle`.
            if (k == 0) gap = select(Mask::load(c.several), gap, after_motion(point, level));
            gap.store(point.gap);
        }
    }
    static constexpr std::int32_t gap_limit = 0x7fffffff;
    static Gap after_motion(const Point& point, LaneSum<L, gap_bits + row_bits> motion) {
        const auto start = Gap::load(point.gap0) * Row::splat(1 << row_bits);
        return rounded_within<gap_bits>(start + motion, gap_limit);
    }

    // ---- normals -------------------------------------------------------------------------------------------------

    /// The normals of a pack during one solve.
    struct Normals {
        Speed speed[3];                  ///< D v: level and tilts
        Speed bias[4], error[4], old[4]; ///< of points
        Speed now[4];                    ///< new impulses
        Mask soft, hit, idle;
        Mask leaves; ///< the block cannot be used: a point would pull, or a point that is no member is hit
    };

    /// True for points that the contact has. A missing point has the largest gap, and at the limit of speeds even such
    /// a gap would close.
    static Mask is_there(const Point& point) { return Gap::splat(gap_limit) > Gap::load(point.gap0); }
    static Speed at_point(const Point& point, const Speed (&x)[3]) {
        const auto tilts = x[1] * Unit::load(point.arm[0]) + x[2] * Unit::load(point.arm[1]);
        return x[0] + rounded<speed_bits>(tilts);
    }

    /// The bias of a point: the speed that closes a gap by the end of the substep, or minus the speed that pushes
    /// overlap out.
    static Speed bias_of(const Pack& c, const Point& point, const PassSettings& s, Mask& overlaps) {
        const Gap gap = Gap::load(point.gap);
        const LaneFixed<L, 0> rate = LaneFixed<L, 0>::splat(s.substeps_per_second);
        const Speed closes = rounded<speed_bits>(min(gap, Gap::splat(s.gap_max)) * rate);
        const Mask apart = gap > Gap::splat(0);
        overlaps = ~apart;
        if (!s.soft) return closes & apart;
        const Speed parts =
            rounded<speed_bits>(max(gap, Gap::splat(-overlap_max)) * Speed::load(c.bias_rate));
        return select(apart, closes, max(parts, Speed::load(c.push)));
    }

    /// Speeds along the normal rows: level and tilts.
    static void find_speeds(const Pack& c, const Pair& p, Speed (&speed)[3]) {
        speed[0] = line_speed(p, c.d[0], c.normal_a[0], c.normal_b[0]);
        speed[1] = speed[2] = Speed::splat(0);
        if (c.point_count > 1)
            for (int r = 1; r < 3; ++r) speed[r] = turn_speed(p, c.normal_a[r], c.normal_b[r]);
    }

    static void measure_normals(const Pack& c, const PassSettings& s, const Pair& p, Normals& n) {
        find_speeds(c, p, n.speed);
        const Speed zero = Speed::splat(0), fast = Speed::splat(impact_speed);
        n.soft = n.hit = n.leaves = Mask::none();
        Mask busy = Mask::none();
        for (int k = 0; k < c.point_count; ++k) {
            const Point& point = c.points[k];
            Mask overlaps;
            n.bias[k] = bias_of(c, point, s, overlaps);
            n.old[k] = Speed::load(point.impulse);
            const Speed speed = at_point(point, n.speed);
            // An impact that comes in the next substep is left to rebound(). If this pass stopped it, the bodies would
            // not part.
            Mask comes_in = Mask::none();
            if (!s.soft && c.bounce_count != 0) {
                comes_in = Mask::load(c.bounces) & (-speed > Speed::splat(s.bounce_speed_min));
                n.bias[k] = select(comes_in, max(n.bias[k], -speed), n.bias[k]);
            }
            n.error[k] = speed + n.bias[k];
            const Mask carries = n.old[k] > zero, closes = (zero > n.error[k]) & is_there(point);
            const Mask member = Fit::load(point.fit[0]) > Fit::splat(0);
            busy = busy | carries | closes;
            const Speed stops = speed + (n.bias[k] & ~overlaps);
            n.hit = n.hit | (member & ~comes_in & ((-fast > stops) | ((stops > fast) & carries)));
            n.leaves = n.leaves | (~member & (carries | closes));
            if (s.soft) n.soft = n.soft | (member & overlaps);
        }
        n.idle = ~busy;
    }

    static void moments(const Pack& c, const Speed (&p)[4], Speed (&q)[3]) {
        q[0] = p[0];
        LaneSum<L, speed_bits + unit_bits> a = p[0] * Unit::load(c.points[0].arm[0]);
        LaneSum<L, speed_bits + unit_bits> b = p[0] * Unit::load(c.points[0].arm[1]);
        for (int k = 1; k < c.point_count; ++k) {
            q[0] = q[0] + p[k];
            a = a + p[k] * Unit::load(c.points[k].arm[0]);
            b = b + p[k] * Unit::load(c.points[k].arm[1]);
        }
        q[1] = rounded<speed_bits>(a);
        q[2] = rounded<speed_bits>(b);
    }

    /// The impulse that corrects `error`: -(inverse) error.
    static Speed answer(const std::int32_t (&inverse)[6][N], int row, const Speed (&error)[3]) {
        return -rounded_within<speed_bits>(Inverse::load(inverse[lower[row][0]]) * error[0] +
                                               Inverse::load(inverse[lower[row][1]]) * error[1] +
                                               Inverse::load(inverse[lower[row][2]]) * error[2],
                                           answer_limit);
    }
    /// X Q, the part of the impulses that softness takes away.
    static void yield(const Pack& c, const Speed (&q)[3], Speed (&out)[3]) {
        const auto x = [&](int i) { return Response::load(c.softness[i]); };
        out[0] = rounded_within<speed_bits>(x(0) * q[0], speed_limit);
        out[1] = rounded_within<speed_bits>(x(1) * q[1] + x(2) * q[2], speed_limit);
        out[2] = rounded_within<speed_bits>(x(2) * q[1] + x(3) * q[2], speed_limit);
    }

    /// Solves all members at once.
    static void solve_block(const Pack& c, const PassSettings& s, const Speed (&q)[3], Normals& n) {
        Speed error[3], after[3];
        for (int i = 0; i < 3; ++i) {
            auto sum = Fit::load(c.points[0].fit[i]) * n.bias[0];
            for (int k = 1; k < c.point_count; ++k) sum = sum + Fit::load(c.points[k].fit[i]) * n.bias[k];
            error[i] = bounded(n.speed[i] + rounded_within<speed_bits>(sum, speed_limit));
        }
        if (s.soft) {
            Speed lost[3], soft[3];
            yield(c, q, lost);
            for (int i = 0; i < 3; ++i) soft[i] = bounded(error[i] + lost[i]);
            for (int i = 0; i < 3; ++i) after[i] = q[i] + answer(c.soft_inverse, i, soft);
            if ((~n.soft).any())
                for (int i = 0; i < 3; ++i)
                    after[i] = select(n.soft, after[i], q[i] + answer(c.inverse, i, error));
        } else
            for (int i = 0; i < 3; ++i) after[i] = q[i] + answer(c.inverse, i, error);
        const Speed zero = Speed::splat(0), tolerated = Speed::splat(-pull_tolerance);
        for (int k = 0; k < c.point_count; ++k) {
            const Point& point = c.points[k];
            const auto sum = Fit::load(point.fit[0]) * after[0] + Fit::load(point.fit[1]) * after[1] +
                             Fit::load(point.fit[2]) * after[2];
            const Speed p = rounded_within<speed_bits>(sum, impulse_limit);
            n.leaves = n.leaves | (tolerated > p);
            n.now[k] = max(p, zero);
        }
    }

    /// Solves each point in turn, forwards and backwards, on the three speeds of the contact; S gives the change of
    /// these speeds by an impulse. It starts from the impulses before this pass and not from the result of the block:
    /// where points are close together, that result may be far off and would add energy.
    static void sweep_points(const Pack& c, Unit mass_scale, Unit impulse_scale, Normals& n) {
        Speed p[4], speed[3] = {n.speed[0], n.speed[1], n.speed[2]};
        const Speed zero = Speed::splat(0);
        for (int k = 0; k < c.point_count; ++k) p[k] = n.old[k];
        Response s[6];
        for (int i = 0; i < 6; ++i) s[i] = Response::load(c.response[i]);
        constexpr int answer_bits = response_bits - 2; // S times an arm is below 156
        LaneFixed<L, answer_bits> answer[4][3];
        Kappa kappa[4];
        for (int k = 0; k < c.point_count; ++k) {
            const Unit a = Unit::load(c.points[k].arm[0]), b = Unit::load(c.points[k].arm[1]);
            const Unit one = Unit::splat(1 << unit_bits);
            for (int i = 0; i < 3; ++i)
                answer[k][i] =
                    rounded<answer_bits>(s[lower[i][0]] * one + s[lower[i][1]] * a + s[lower[i][2]] * b);
            kappa[k] = rounded<kappa_bits>(Kappa::load(c.points[k].kappa) * mass_scale);
        }
        const auto visit = [&](int k) {
            const Speed error = bounded(at_point(c.points[k], speed) + n.bias[k]);
            const Speed less =
                rounded<speed_bits>(error * kappa[k]) + rounded<speed_bits>(p[k] * impulse_scale);
            const Speed now = min(max(p[k] - less, zero), Speed::splat(impulse_limit));
            const Speed change = now - p[k];
            p[k] = now;
            for (int i = 0; i < 3; ++i) speed[i] = speed[i] + rounded<speed_bits>(answer[k][i] * change);
        };
        for (int round = 0; round < 2; ++round) {
            for (int k = 0; k < c.point_count; ++k) visit(k);
            for (int k = c.point_count - 1; k >= 0; --k) visit(k);
        }
        for (int k = 0; k < c.point_count; ++k) n.now[k] = select(n.leaves, p[k], n.now[k]);
    }

    /// The new impulse of a contact with one point.
    static Speed single(const Pack& c, Unit mass_scale, Unit impulse_scale, const Normals& n) {
        const Kappa kappa = rounded<kappa_bits>(Kappa::load(c.points[0].kappa) * mass_scale);
        const Speed less =
            rounded<speed_bits>(bounded(n.error[0]) * kappa) + rounded<speed_bits>(n.old[0] * impulse_scale);
        return min(max(n.old[0] - less, Speed::splat(0)), Speed::splat(impulse_limit));
    }

    /// Contacts of one point get the same impulses as in a pack of such contacts alone: bits must not depend on the
    /// other lanes of the pack.
    static void solve_several(const Pack& c, const PassSettings& s, Unit mass_scale, Unit impulse_scale,
                              Normals& n, Speed (&w)[3]) {
        Speed q[3];
        moments(c, n.old, q);
        solve_block(c, s, q, n);
        const Mask several = Mask::load(c.several);
        if ((~several).any()) n.now[0] = select(several, n.now[0], single(c, mass_scale, impulse_scale, n));
        n.leaves = n.leaves & several & ~n.idle;
        for (int k = 0; k < c.point_count; ++k) n.now[k] = n.now[k] & ~n.idle;
        if (n.leaves.any()) sweep_points(c, mass_scale, impulse_scale, n);
        moments(c, n.now, w); // from the rounded impulses that are stored
        for (int i = 0; i < 3; ++i) w[i] = w[i] - q[i];
    }

    /// Keeps a hit only where the bodies also approach each other faster than 0.25 m/s by their arrival velocities.
    /// Speeds that come from passes or from overlap are a load, and the impulses of a load have to grow until all
    /// contacts that carry it share it.
    [[gnu::noinline]] static void keep_hits_of_arrivals(const Pack& c, const PassData& data, Pair& arrival,
                                                        Normals& n) {
        Speed speed[3];
        gather(c, data.arrival, arrival), arrival.round(), find_speeds(c, arrival, speed);
        Mask arrives = Mask::none();
        for (int k = 0; k < c.point_count; ++k)
            arrives = arrives |
                      (is_there(c.points[k]) & (-Speed::splat(impact_speed) > at_point(c.points[k], speed)));
        n.hit = n.hit & arrives;
    }

    /// Adds the impulses of hits to the arrival velocities, so that contacts that are solved later find them there.
    [[gnu::noinline]] static void pass_hits_on(const Pack& c, const PassData& data, const Normals& n,
                                               Pair& arrival) {
        Speed change[4], w[3];
        for (int k = 0; k < c.point_count; ++k) change[k] = (n.now[k] - n.old[k]) & n.hit;
        moments(c, change, w);
        push_normal(c, w, arrival);
        if (c.locked != 0) hold_locked(c, data, arrival);
        scatter(c, data.arrival, arrival);
    }

    /// Solves all normals once. Returns false if all lanes are idle: no point carries or closes.
    static bool solve_normals(Pack& c, const PassData& data, const PassSettings& s, Pair& p) {
        Normals n;
        measure_normals(c, s, p, n);
        if (!(~n.idle).any()) return false;
        Pair arrival;
        if (n.hit.any()) keep_hits_of_arrivals(c, data, arrival, n);
        n.soft = n.soft & ~n.hit;
        const Unit one = Unit::splat(1 << unit_bits), zero = Unit::splat(0);
        const Unit mass_scale = s.soft ? select(n.soft, Unit::load(c.mass_scale), one) : one;
        const Unit impulse_scale = s.soft ? Unit::load(c.impulse_scale) & n.soft : zero;
        Speed w[3];
        if (c.point_count == 1) {
            // Without the mask an idle lane would get an impulse, but only where another lane of the pack is busy.
            n.now[0] = single(c, mass_scale, impulse_scale, n) & ~n.idle;
            w[0] = n.now[0] - n.old[0];
            w[1] = w[2] = Speed::splat(0);
        } else
            solve_several(c, s, mass_scale, impulse_scale, n, w);
        push_normal(c, w, p);
        if (c.locked != 0) hold_locked(c, data, p);
        const bool hit = n.hit.any();
        for (int k = 0; k < c.point_count; ++k) {
            Point& point = c.points[k];
            n.now[k].store(point.impulse);
            if (hit) (Speed::load(point.impact) + ((n.now[k] - n.old[k]) & n.hit)).store(point.impact);
        }
        if (hit) {
            c.impacts = 1, c.hit |= n.hit.lanes();
            pass_hits_on(c, data, n, arrival);
        }
        return true;
    }

    // ---- friction ------------------------------------------------------------------------------------------------

    /// Solves both tangents and the twist, within the limit of the present normal impulses. Returns false if no lane
    /// has an impulse.
    static bool solve_friction(Pack& c, const PassData& data, Pair& p) {
        const bool turns = c.point_count > 1;
        Speed pressing = Speed::load(c.points[0].impulse);
        LaneSum<L, speed_bits + unit_bits> reach = pressing * Unit::load(c.points[0].reach);
        for (int k = 1; k < c.point_count; ++k) {
            const Speed impulse = Speed::load(c.points[k].impulse);
            pressing = pressing + impulse;
            reach = reach + impulse * Unit::load(c.points[k].reach);
        }
        Speed old[3];
        Mask busy = pressing > Speed::splat(0);
        const Speed zero = Speed::splat(0);
        for (int r = 0; r < 3; ++r) {
            old[r] = Speed::load(c.slide[r]);
            busy = busy | (old[r] > zero) | (zero > old[r]);
        }
        if (!busy.any()) return false;
        const Row friction = Row::load(c.friction);
        const Speed limit = rounded_within<speed_bits>(friction * pressing, speed_limit);
        Speed speed[3], now[3], w[3];
        for (int r = 0; r < 2; ++r)
            speed[r] = line_speed(p, c.d[r + 1], c.slide_a[r], c.slide_b[r]) + Speed::load(c.surface[r]);
        speed[2] = turns ? turn_speed(p, c.slide_a[2], c.slide_b[2]) : zero;
        for (int r = 0; r < 3; ++r) {
            if (r == 2 && !turns) {
                now[2] = zero;
                break;
            }
            auto sum = Inverse::load(c.slide_inverse[lower[r][0]]) * speed[0] +
                       Inverse::load(c.slide_inverse[lower[r][1]]) * speed[1];
            if (turns) sum = sum + Inverse::load(c.slide_inverse[lower[r][2]]) * speed[2];
            now[r] = old[r] - rounded_within<speed_bits>(sum, speed_limit);
        }
        Speed from[3] = {old[0], old[1], zero};
        const Speed least[3] = {now[0], now[1], now[2]};
        if (turns) {
            const Speed most = rounded_within<speed_bits>(friction * rounded<speed_bits>(reach), speed_limit);
            limit_twist(c, most, now);
            from[2] = clamp(old[2], most);
        }
        hold_in_cone(c, limit, from, least, now);
        for (int r = 0; r < 3; ++r) {
            w[r] = now[r] - old[r];
            now[r].store(c.slide[r]);
        }
        push_slide(c, w, p);
        if (c.locked != 0) hold_locked(c, data, p);
        return true;
    }

    /// Limits the impulse about the normal. Where that shortens it, the function solves the two tangents again: with the inverse
    /// matrix B of the three rows, a twist that is shorter by d moves tangent r by d B[r][2] / B[2][2]. Tangents that belong to
    /// the full twist may push a body in the direction in which it slides. A plate that hit the floor with one of its two
    /// points gained energy by it.
    static void limit_twist(const Pack& c, Speed most, Speed (&now)[3]) {
        const Speed within = clamp(now[2], most);
        const unsigned cut = ((within > now[2]) | (now[2] > within)).lanes();
        if (cut == 0) return;
        std::int32_t full[N], limited[N], tangents[2][N];
        now[2].store(full), within.store(limited);
        for (int r = 0; r < 2; ++r) now[r].store(tangents[r]);
        for (unsigned lane = 0; lane < N; ++lane) {
            const std::int64_t own = c.slide_inverse[lower[2][2]][lane];
            if (((cut >> lane) & 1u) == 0 || own <= 0) continue;
            const std::int64_t change = std::int64_t{limited[lane]} - full[lane];
            for (int r = 0; r < 2; ++r) {
                const std::int64_t moved =
                    tangents[r][lane] + change * c.slide_inverse[lower[2][r]][lane] / own;
                tangents[r][lane] = static_cast<std::int32_t>(moved > speed_limit    ? speed_limit
                                                              : moved < -speed_limit ? -speed_limit
                                                                                     : moved);
            }
        }
        for (int r = 0; r < 2; ++r) now[r] = Speed::load(tangents[r]);
        now[2] = within;
    }

    /// Shortens the impulse along the tangents to `limit`: an exact cone, no pyramid. `from`: the impulse before this
    /// pass, within its present limits but for a normal impulse that has become smaller. `least`: the impulse without
    /// limits, with which the bodies have the least energy. Where the rows respond very differently, as those of a rod,
    /// the shortened impulse may add energy; then the impulse goes only as far from `from` as the limit allows.
    static void hold_in_cone(const Pack& c, Speed limit, const Speed (&from)[3], const Speed (&least)[3],
                             Speed (&now)[3]) {
        const auto square = now[0] * now[0] + now[1] * now[1];
        const unsigned outside = (square > limit * limit).lanes();
        if (outside == 0) return;
        std::int64_t size[N], most[N];
        std::int32_t to[3][N], old[3][N], best[3][N];
        square.store64(size), wide(limit).store64(most);
        for (int r = 0; r < 3; ++r) now[r].store(to[r]), from[r].store(old[r]), least[r].store(best[r]);
        detail::take_roots(size, N);
        for (unsigned lane = 0; lane < N; ++lane) {
            if (((outside >> lane) & 1u) == 0) continue;
            const Impulse goal{to[0][lane], to[1][lane], to[2][lane]},
                start{old[0][lane], old[1][lane], old[2][lane]};
            Impulse end{goal.t[0] * most[lane] / (size[lane] + 1), goal.t[1] * most[lane] / (size[lane] + 1),
                        goal.t[2]};
            if (start.is_within(most[lane]) &&
                adds_energy(c, lane, {best[0][lane], best[1][lane], best[2][lane]}, start, end))
                end = cut(start, goal, most[lane], end);
            for (int r = 0; r < 3; ++r) to[r][lane] = static_cast<std::int32_t>(end.t[r]);
        }
        for (int r = 0; r < 3; ++r) now[r] = Speed::load(to[r]);
    }

    /// Two tangents and the twist of one lane.
    struct Impulse {
        std::int64_t t[3];
        bool is_within(std::int64_t most) const {
            const auto square = [](std::int64_t x) { return static_cast<std::uint64_t>(x * x); };
            return square(t[0]) + square(t[1]) <= square(most);
        }
    };
    static std::int64_t size_of(std::int64_t x) { return x < 0 ? -x : x; }
    /// Shifts values right, alike, until they have at most `bits` bits.
    static void shorten_to(int bits, std::int64_t (&x)[6]) {
        std::uint64_t all = 0;
        for (const std::int64_t i : x) all |= static_cast<std::uint64_t>(size_of(i));
        const int drop = 64 - std::countl_zero(all) - bits;
        if (drop > 0)
            for (std::int64_t& i : x) i >>= drop;
    }
    /// True if the three rows respond about alike and independently. The shortened impulse then adds no energy.
    static bool is_even(const std::int64_t (&m)[6]) {
        constexpr int part = 16;
        const std::int64_t both = m[0] + m[2];
        return size_of(m[0] - m[2]) <= both / part && size_of(m[1]) <= both / part &&
               m[3] * m[3] <= m[0] * m[5] / part && m[4] * m[4] <= m[2] * m[5] / part;
    }
    /// True if the bodies have more energy with the impulse `end` than with `start`, by over 1 / 256: rounding alone makes
    /// no difference. The energy above the least is a square in the metric of the matrix of the rows. The adjugate of its
    /// inverse is that matrix but for a factor.
    static bool adds_energy(const Pack& c, unsigned lane, const Impulse& least, const Impulse& start,
                            const Impulse& end) {
        std::int64_t m[6];
        for (int i = 0; i < 6; ++i) m[i] = c.slide_inverse[i][lane] / 2; // products of two stay below 2^60
        if (is_even(m)) return false;
        std::int64_t k[6] = {m[2], -m[1], m[0]}; // of a single point, which has no twist
        if (m[5] > 0) {
            k[0] = m[2] * m[5] - m[4] * m[4], k[1] = m[3] * m[4] - m[1] * m[5];
            k[2] = m[0] * m[5] - m[3] * m[3], k[3] = m[1] * m[4] - m[2] * m[3];
            k[4] = m[1] * m[3] - m[0] * m[4], k[5] = m[0] * m[2] - m[1] * m[1];
        }
        std::int64_t x[6];
        for (int r = 0; r < 3; ++r) x[r] = end.t[r] - least.t[r], x[3 + r] = start.t[r] - least.t[r];
        shorten_to(24, k), shorten_to(17, x); // the sums of nine products of three stay below 2^62
        const auto energy = [&k](const std::int64_t* y) {
            return k[0] * y[0] * y[0] + k[2] * y[1] * y[1] + k[5] * y[2] * y[2] +
                   2 * (k[1] * y[0] * y[1] + k[3] * y[0] * y[2] + k[4] * y[1] * y[2]);
        };
        const std::int64_t before = energy(x + 3);
        return energy(x) - before > before / 256;
    }
    /// The last of 4096 steps from `start` to `goal` at which the tangents are within `most`; `otherwise` if that is the
    /// start. The energy falls along this way, since it is convex and least at the goal.
    static Impulse cut(const Impulse& start, const Impulse& goal, std::int64_t most,
                       const Impulse& otherwise) {
        constexpr int bits = 12;
        const auto at = [&](std::int64_t step) {
            Impulse i;
            for (int r = 0; r < 3; ++r) i.t[r] = start.t[r] + (((goal.t[r] - start.t[r]) * step) >> bits);
            return i;
        };
        std::int64_t step = 0;
        for (int bit = bits - 1; bit >= 0; --bit)
            if (const std::int64_t next = step + (std::int64_t{1} << bit); at(next).is_within(most))
                step = next;
        return step == 0 ? otherwise : at(step);
    }

    // ---- impacts -------------------------------------------------------------------------------------------------

    /// forget_impacts() for all lanes at once, where no lane keeps its impact.
    static void forget_all_impacts(Pack& c, const PassData& data) {
        const Speed zero = Speed::splat(0);
        Speed taken[3] = {zero, zero, zero}, before = zero, after = zero;
        for (int k = 0; k < c.point_count; ++k) {
            Point& point = c.points[k];
            const Speed old = Speed::load(point.impulse),
                        impact = min(max(Speed::load(point.impact), zero), old);
            before = before + old;
            after = after + (old - impact);
            taken[0] = taken[0] - impact;
            for (int i = 0; i < 2; ++i)
                taken[i + 1] = taken[i + 1] - rounded<speed_bits>(Unit::load(point.arm[i]) * impact);
            (old - impact).store(point.impulse);
            zero.store(point.impact);
        }
        c.impacts = 0;
        const unsigned some = (zero > taken[0]).lanes();
        if (some == 0) return;
        std::int32_t was[N], left[N], change[3][N] = {};
        before.store(was), after.store(left);
        for (unsigned lane = 0; lane < N; ++lane)
            if ((some >> lane) & 1u)
                for (int r = 0; r < 3; ++r) { // friction shrinks in the ratio of the normal impulses
                    const std::int32_t old = c.slide[r][lane];
                    c.slide[r][lane] = static_cast<std::int32_t>(std::int64_t{old} * left[lane] / was[lane]);
                    change[r][lane] = c.slide[r][lane] - old;
                }
        const Speed slide[3] = {Speed::load(change[0]), Speed::load(change[1]), Speed::load(change[2])};
        Pair start;
        gather(c, data.warm, start);
        push_normal(c, taken, start);
        push_slide(c, slide, start);
        scatter(c, data.warm, start);
    }

    // ---- passes --------------------------------------------------------------------------------------------------

    static void warm_start_pack(const Pack& c, const PassData& data) {
        Speed impulse[4], q[3], slide[3];
        for (int k = 0; k < c.point_count; ++k) impulse[k] = Speed::load(c.points[k].impulse);
        for (int r = 0; r < 3; ++r) slide[r] = Speed::load(c.slide[r]);
        moments(c, impulse, q);
        Pair p;
        gather(c, data.bodies, p);
        push_normal(c, q, p);
        push_slide(c, slide, p);
        if (c.locked != 0) hold_locked(c, data, p);
        scatter(c, data.bodies, p);
    }

    /// The soft pass ends with the normals, the relaxing pass with friction. In the soft pass the normal impulse also
    /// pushes overlap out: friction within the limit of that impulse would brake a sliding body too much while it
    /// overlaps.
    static void solve_pack(Pack& c, const PassData& data, const PassSettings& s) {
        Pair p;
        gather(c, data.bodies, p);
        p.round();
        bool pushed = false;
        if (s.soft) {
            pushed = solve_friction(c, data, p);
            if (pushed) p.round();
            pushed = solve_normals(c, data, s, p) || pushed;
        } else {
            measure_gaps(c, data);
            pushed = solve_normals(c, data, s, p);
            if (pushed) p.round();
            pushed = solve_friction(c, data, p) || pushed;
        }
        if (pushed) scatter(c, data.bodies, p);
        if (s.soft || c.impacts == 0) return;
        if (c.keeps == 0)
            forget_all_impacts(c, data);
        else
            forget_impacts<N>(c, data.warm);
    }

  public:
    static void warm_start(void* packs, std::uint32_t first, std::uint32_t last, const PassData& data) {
        for (std::uint32_t i = first; i < last; ++i) {
            if (data.asks_ahead) Ahead<L>::ask_for(packs, i, data);
            warm_start_pack(static_cast<Pack*>(packs)[i], data);
        }
    }
    static void solve(void* packs, std::uint32_t first, std::uint32_t last, const PassData& data,
                      const PassSettings& settings) {
        for (std::uint32_t i = first; i < last; ++i) {
            if (data.asks_ahead) Ahead<L>::ask_for(packs, i, data);
            solve_pack(static_cast<Pack*>(packs)[i], data, settings);
        }
    }
    static bool find_hits(void* packs, std::uint32_t count, const PassData& data,
                          const PassSettings& settings) {
        Pack* const all = static_cast<Pack*>(packs);
        std::uint32_t any = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            if (all[i].bounce_count == 0) continue;
            Bounces::find(all[i], data, settings);
            any |= all[i].struck;
        }
        return any != 0;
    }
    static constexpr ContactKernel table() {
        return {N, PrepareKernel<L>::prepare, warm_start, find_hits, solve};
    }
};

} // namespace lockstone::solve
