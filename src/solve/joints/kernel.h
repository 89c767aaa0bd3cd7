// The passes over packs of joints, written once over the lanes L. See dynamics/joint.h for the symbols, joint_pack.h for the formats.
//
// Only files that are compiled for one instruction set include this; it must not use inline functions that other files use
// too, since the linker keeps one of their copies.
#pragma once

#include "dynamics/joint_pack.h"
#include "solve/lanes/lane_fixed.h"

namespace lockstone::solve {

template <class L> class PackedJoints {
    static constexpr unsigned N = L::lanes, all_lanes = dynamics::pack_lanes;
    static constexpr int accumulator_bits = 47, row_bits = 28, speed_bits = 19, unit_bits = 30, gap_bits = 27;
    using Pack = dynamics::JointPack;
    using Side = dynamics::PackSide;
    using Turn = dynamics::TurnPack;
    using Data = dynamics::JointPassData;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Row = LaneFixed<L, row_bits>;
    using Speed = LaneFixed<L, speed_bits>;
    using Unit = LaneFixed<L, unit_bits>;
    using Gap = LaneFixed<L, gap_bits>;
    using Velocity = LaneSum<L, accumulator_bits>;
    using Moved = LaneSum<L, gap_bits + row_bits>;
    template <class T> using Lanes = T[all_lanes];

    static constexpr std::int32_t impulse_max = dynamics::joint_impulse_max;
    static constexpr int lower[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};

    /// Velocities of the two bodies of each lane: v, u.
    struct Motion {
        Velocity a[6], b[6];
    };

    static V between(V x, V least, V most) {
        x = L::select(L::greater64(x, most), most, x);
        return L::select(L::greater64(least, x), least, x);
    }
    static V shift_arithmetic(V x, int by) { return L::shift_right_by(x, L::splat(by)); }

    // ---- bodies --------------------------------------------------------------------------------------------------

    static void gather(const Side& side, unsigned lane, const Data& data, Velocity (&out)[6]) {
        const dynamics::SolverBody* body[N];
        for (unsigned i = 0; i < N; ++i) body[i] = &data.bodies[side.body[lane + i]];
        V raw[6];
        L::gather6(body, raw);
        for (int i = 0; i < 6; ++i) out[i] = {raw[i]};
    }
    static void gather_moved(const Side& side, unsigned lane, const Data& data, Gap (&out)[6]) {
        const dynamics::SolverBody* body[N];
        for (unsigned i = 0; i < N; ++i) body[i] = &data.bodies[side.body[lane + i]];
        V raw[6];
        L::gather_motion(body, raw);
        for (int i = 0; i < 6; ++i) out[i] = {raw[i]};
    }
    /// Bodies that nothing moves are shared by packs, so they are not written.
    static void scatter(const Side& side, unsigned lane, const Data& data, const Velocity (&x)[6]) {
        V raw[6];
        for (int i = 0; i < 6; ++i) raw[i] = x[i].raw;
        dynamics::SolverBody* to[N];
        dynamics::SolverBody spare;
        for (unsigned i = 0; i < N; ++i)
            to[i] = (side.movable >> (lane + i)) & 1u ? &data.bodies[side.body[lane + i]] : &spare;
        L::scatter6(to, raw);
    }
    static void gather(const Pack& c, unsigned lane, const Data& data, Motion& m) {
        gather(c.a, lane, data, m.a), gather(c.b, lane, data, m.b);
        keep_readable(m);
    }
    static void scatter(const Pack& c, unsigned lane, const Data& data, const Motion& m) {
        scatter(c.a, lane, data, m.a), scatter(c.b, lane, data, m.b);
    }

    /// Within what rows read, in the lanes of the mask.
    static void clamp_motion(Motion& m, V mask) {
        const V most = L::splat(dynamics::motion_max), least = L::splat(-dynamics::motion_max);
        for (int i = 0; i < 6; ++i) {
            m.a[i] = {L::select(mask, between(m.a[i].raw, least, most), m.a[i].raw)};
            m.b[i] = {L::select(mask, between(m.b[i].raw, least, most), m.b[i].raw)};
        }
    }
    static void keep_readable(Motion& m) {
        const V most = L::splat(dynamics::motion_max);
        V any = L::splat(0); // from -motion_max on no bit of the sum is above that of 2 motion_max
        for (int i = 0; i < 6; ++i)
            any = L::either(any, L::either(L::add(m.a[i].raw, most), L::add(m.b[i].raw, most)));
        const V beyond = L::greater64(L::template shift_right<dynamics::motion_bits + 1>(any), L::splat(0));
        if (L::lanes_of(beyond) != 0) clamp_motion(m, beyond);
    }
    /// After changes of impulses of these sizes, or-ed.
    static void keep_small(Motion& m, Speed sizes) {
        const Mask large = sizes > Speed::splat(dynamics::small_impulse - 1);
        if (large.any()) clamp_motion(m, large.raw);
    }
    static Speed or_size(Speed sizes, Speed p) { return {L::either(sizes.raw, max(p, -p).raw)}; }

    // ---- what parts have in common -------------------------------------------------------------------------------

    template <class X> static auto dot(const Lanes<std::int32_t> (&x)[3], unsigned lane, const X& y) {
        return Row::load(&x[0][lane]) * y[0] + Row::load(&x[1][lane]) * y[1] + Row::load(&x[2][lane]) * y[2];
    }
    static void add_rounded(Velocity& v, Velocity sum, const Side& side, unsigned lane) {
        if (side.shifts)
            sum.raw =
                L::shift_right_by(L::add(sum.raw, L::load64(&side.half[lane])), L::load64(&side.shift[lane]));
        v = v + sum;
    }

    /// x / 2^shift of inverses that are out of the ordinary.
    static V shift_oddly(V x, const dynamics::PackInverse& inverse, unsigned lane) {
        std::int64_t v[N];
        L::store64(v, x);
        for (unsigned i = 0; i < N; ++i) {
            const std::int64_t shift = inverse.shift[lane + i], far = std::int64_t{1} << 31;
            if (shift > 62)
                v[i] = 0;
            else if (shift > 0)
                v[i] = (v[i] + (std::int64_t{1} << (shift - 1))) >> shift;
            else // the result is clamped to less
                v[i] = (v[i] < -far  ? -far
                        : v[i] > far ? far
                                     : v[i]) *
                       (std::int64_t{1} << (-shift < 31 ? -shift : 31));
        }
        return L::load64(v);
    }

    /// Impulses from speeds by the inverse of a part, from those that it has; what comes out is how they change.
    struct Change {
        Speed p[3];
        Speed sizes;
    };
    static Change answer(const dynamics::PackInverse& inverse, Lanes<std::int32_t> (&impulse)[3],
                         unsigned lane, const Speed (&speed)[3], int rows, const Data& data, bool bias,
                         std::uint64_t& clamped) {
        const bool odd = (inverse.odd[0] | inverse.odd[1] | inverse.odd[2] | inverse.odd[3]) != 0;
        const V most = L::splat(dynamics::impulse_change_max),
                least = L::splat(-dynamics::impulse_change_max);
        const Speed bound = Speed::splat(impulse_max);
        Change change;
        change.sizes = Speed::splat(0);
        for (int r = 0; r < rows; ++r) {
            V sum = L::splat(0); // 30 bits times 31, three times
            for (int s = 0; s < rows; ++s)
                sum = L::add(sum, L::mul(L::load32(&inverse.m[lower[r][s]][lane]), speed[s].raw));
            if (odd)
                sum = shift_oddly(sum, inverse, lane);
            else
                sum = L::shift_right_by(L::add(sum, L::load64(&inverse.half[lane])),
                                        L::load64(&inverse.shift[lane]));
            Speed wanted{between(sum, least, most)};
            const Speed old = Speed::load(&impulse[r][lane]);
            if (bias)
                wanted = rounded<speed_bits>(wanted * Unit::splat(data.mass_scale)) +
                         rounded<speed_bits>(old * Unit::splat(data.impulse_scale));
            const Speed next = old - wanted, now = clamp(next, bound);
            const unsigned met = ((next > now) | (now > next)).lanes();
            for (unsigned i = 0; i < N; ++i) clamped += (met >> i) & 1u;
            now.store(&impulse[r][lane]);
            change.p[r] = now - old;
            change.sizes = or_size(change.sizes, change.p[r]);
        }
        return change;
    }

    // ---- rows that only turn -------------------------------------------------------------------------------------

    static void push_turn(const Lanes<std::int32_t> (&response)[3][3], const Side& side, unsigned lane,
                          const Speed (&p)[3], int rows, Velocity (&v)[6]) {
        for (int i = 0; i < 3; ++i) {
            Velocity sum = Row::load(&response[0][i][lane]) * p[0];
            for (int r = 1; r < rows; ++r) sum = sum + Row::load(&response[r][i][lane]) * p[r];
            add_rounded(v[3 + i], sum, side, lane);
        }
    }
    static void solve_turn(Turn& t, const Pack& c, unsigned lane, const Data& data, bool bias, Motion& m,
                           std::uint64_t& clamped) {
        const int rows = static_cast<int>(c.turn_rows);
        Speed a[3], b[3], speed[3];
        for (int i = 0; i < 3; ++i)
            a[i] = rounded<speed_bits>(m.a[3 + i]), b[i] = rounded<speed_bits>(m.b[3 + i]);
        for (int r = 0; r < rows; ++r) {
            speed[r] = rounded_within<speed_bits>(dot(t.ja[r], lane, a) + dot(t.jb[r], lane, b), impulse_max);
            if (bias) speed[r] = speed[r] + Speed::load(&t.bias[r][lane]);
        }
        const Change change = answer(t.inverse, t.impulse, lane, speed, rows, data, bias, clamped);
        push_turn(t.ra, c.a, lane, change.p, rows, m.a);
        push_turn(t.rb, c.b, lane, change.p, rows, m.b);
        keep_small(m, change.sizes);
    }

    // ---- points --------------------------------------------------------------------------------------------------

    template <int Sign>
    static void push_point(const Side& side, unsigned lane, const Speed (&p)[3], Velocity (&v)[6]) {
        const Row pull = Row::load(&side.pull[lane]);
        const Unit share = Unit::load(&side.share[lane]);
        Speed part[3];
        for (int r = 0; r < 3; ++r) {
            add_rounded(v[r], pull * (Sign < 0 ? -p[r] : p[r]), side, lane);
            part[r] = rounded<speed_bits>(share * p[r]);
        }
        for (int i = 0; i < 3; ++i)
            add_rounded(v[3 + i],
                        Row::load(&side.x[0][i][lane]) * part[0] + Row::load(&side.x[1][i][lane]) * part[1] +
                            Row::load(&side.x[2][i][lane]) * part[2],
                        side, lane);
    }

    /// C rate, within push_max, and what lies ahead: the speed that the error asks for.
    static void add_bias(const Pack& c, unsigned lane, const Data& data, Speed (&speed)[3]) {
        Gap a[6], b[6];
        gather_moved(c.a, lane, data, a), gather_moved(c.b, lane, data, b);
        const Row one = Row::load(&c.one[lane]);
        constexpr int split = 20, shift = gap_bits - speed_bits + dynamics::joint_rate_bits;
        const V rate = L::splat(data.rate), far = L::splat(std::int64_t{1} << 35),
                back = L::splat(-(std::int64_t{1} << 35));
        const V push = L::template shift_left<shift>(L::load32(&c.push_max[lane]));
        const V half = L::splat(std::int64_t{1} << (shift - 1)),
                below = L::splat((std::int64_t{1} << (shift - 1)) - 1);
        for (int r = 0; r < 3; ++r) {
            // 28 and 32 bits twice, and six products of 29 and 32: below 2^63
            const Moved moved =
                (one * b[r] - one * a[r]) + dot(c.a.x[r], lane, tail(a)) + dot(c.b.x[r], lane, tail(b));
            const V step =
                shift_arithmetic(L::add(moved.raw, L::splat(std::int64_t{1} << (row_bits - 1))), row_bits);
            const V near = between(L::add(L::load64(&c.error[r][lane]), step), back, far);
            // 2^35 times 2^27, in two halves
            const V wanted =
                L::add(L::template shift_left<split>(L::mul(L::template shift_right<split>(near), rate)),
                       L::mul(L::both(near, L::splat((1 << split) - 1)), rate));
            const V within = between(wanted, L::sub(L::splat(0), push), L::add(push, below));
            speed[r] = speed[r] + Speed{L::template shift_right<shift>(L::add(within, half))} +
                       Speed::load(&c.ahead[r][lane]);
        }
    }
    static const Gap* tail(const Gap (&x)[6]) { return x + 3; }

    static void solve_point(Pack& c, unsigned lane, const Data& data, bool bias, Motion& m,
                            std::uint64_t& clamped) {
        Speed a[6], b[6], speed[3];
        for (int i = 0; i < 6; ++i) a[i] = rounded<speed_bits>(m.a[i]), b[i] = rounded<speed_bits>(m.b[i]);
        const Row one = Row::load(&c.one[lane]);
        for (int r = 0; r < 3; ++r)
            speed[r] = rounded_within<speed_bits>(
                one * (b[r] - a[r]) + dot(c.a.x[r], lane, a + 3) + dot(c.b.x[r], lane, b + 3), impulse_max);
        if (bias) add_bias(c, lane, data, speed);
        const Change change = answer(c.inverse, c.impulse, lane, speed, 3, data, bias, clamped);
        push_point<-1>(c.a, lane, change.p, m.a);
        push_point<1>(c.b, lane, change.p, m.b);
        keep_small(m, change.sizes);
    }

    // ---- passes --------------------------------------------------------------------------------------------------

    static void add_to_sums(Lanes<std::int64_t> (&sum)[3], unsigned lane, const Speed (&p)[3], int rows) {
        for (int r = 0; r < rows; ++r) L::store64(&sum[r][lane], L::add(L::load64(&sum[r][lane]), p[r].raw));
    }
    static void warm_lanes(const Data& data, Pack& c, unsigned lane, bool sums) {
        Motion m;
        gather(c, lane, data, m);
        Speed p[3];
        if (c.turn_rows != 0) {
            Turn& t = data.turns[c.turn];
            const int rows = static_cast<int>(c.turn_rows);
            Speed sizes = Speed::splat(0);
            for (int r = 0; r < rows; ++r)
                p[r] = Speed::load(&t.impulse[r][lane]), sizes = or_size(sizes, p[r]);
            if (sums) add_to_sums(t.sum, lane, p, rows);
            push_turn(t.ra, c.a, lane, p, rows, m.a);
            push_turn(t.rb, c.b, lane, p, rows, m.b);
            keep_small(m, sizes);
        }
        for (int r = 0; r < 3; ++r) p[r] = Speed::load(&c.impulse[r][lane]);
        if (sums) add_to_sums(c.sum, lane, p, 3);
        push_point<-1>(c.a, lane, p, m.a);
        push_point<1>(c.b, lane, p, m.b);
        keep_readable(m);
        scatter(c, lane, data, m);
    }

  public:
    static void warm_start(const Data& data, std::uint32_t first, std::uint32_t last, bool sums) {
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < data.packs[i].count; lane += N)
                warm_lanes(data, data.packs[i], lane, sums);
    }
    static std::uint64_t solve(const Data& data, std::uint32_t first, std::uint32_t last, bool bias) {
        std::uint64_t clamped = 0;
        for (std::uint32_t i = first; i < last; ++i) {
            Pack& c = data.packs[i];
            for (unsigned lane = 0; lane < c.count; lane += N) {
                Motion m;
                gather(c, lane, data, m);
                if (c.turn_rows != 0) solve_turn(data.turns[c.turn], c, lane, data, bias, m, clamped);
                solve_point(c, lane, data, bias, m, clamped);
                scatter(c, lane, data, m);
            }
        }
        return clamped;
    }
    static constexpr dynamics::JointKernel table() { return {warm_start, solve}; }
};

} // namespace lockstone::solve
