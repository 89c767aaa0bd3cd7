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

    static void solve_point(Pack& c, unsigned lane, const Data& data, bool bias, Motion& m,
                            std::uint64_t& clamped) {
        Speed a[6], b[6], speed[3];
        for (int i = 0; i < 6; ++i) a[i] = rounded<speed_bits>(m.a[i]), b[i] = rounded<speed_bits>(m.b[i]);
        const Row one = Row::load(&c.one[lane]);
        for (int r = 0; r < 3; ++r)
            speed[r] = rounded_within<speed_bits>(
                one * (b[r] - a[r]) + dot(c.a.x[r], lane, a + 3) + dot(c.b.x[r], lane, b + 3), impulse_max);
        for (int r = 0; r < 3 && bias; ++r) speed[r] = speed[r] + Speed::load(&c.bias[r][lane]);
        const Change change = answer(c.inverse, c.impulse, lane, speed, 3, data, bias, clamped);
        push_point<-1>(c.a, lane, change.p, m.a);
        push_point<1>(c.b, lane, change.p, m.b);
        keep_small(m, change.sizes);
    }

    // ---- rows of points ------------------------------------------------------------------------------------------

    using Lever = LaneFixed<L, 0>; ///< as it is scaled by lane
    using Angle = LaneFixed<L, dynamics::pack_angle_bits>;
    static constexpr int inverse_at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

    /// K^-1 x / 2^shift: 30 bits times 32, three times.
    template <class X>
    static void over_gyration(const Side& side, unsigned lane, const X* x, const Lanes<std::int64_t>& shift,
                              V (&out)[3]) {
        const V by = L::load64(&shift[lane]);
        for (int i = 0; i < 3; ++i) {
            V sum = L::mul(L::load32(&side.inverse[inverse_at[i][0]][lane]), x[0].raw);
            for (int k = 1; k < 3; ++k)
                sum = L::add(sum, L::mul(L::load32(&side.inverse[inverse_at[i][k]][lane]), x[k].raw));
            out[i] = L::shift_right_by(sum, by);
        }
    }
    /// r = from + phi x r
    static void turn_by(const Angle (&phi)[3], Lever (&r)[3], const Lever (&from)[3]) {
        const Lever x = r[0], y = r[1], z = r[2];
        r[0] = from[0] + rounded<0>(phi[1] * z - phi[2] * y);
        r[1] = from[1] + rounded<0>(phi[2] * x - phi[0] * z);
        r[2] = from[2] + rounded<0>(phi[0] * y - phi[1] * x);
    }
    static void turn_by_part(const Angle (&phi)[3], std::int32_t part, Lever (&r)[3],
                             const Lever (&from)[3]) {
        Angle less[3];
        for (int i = 0; i < 3; ++i) less[i] = rounded<dynamics::pack_angle_bits>(phi[i] * Unit::splat(part));
        turn_by(less, r, from);
    }
    /// Where the lever is now.
    static void place(const Side& side, unsigned lane, const Gap (&moved)[6], Lever (&r)[3]) {
        constexpr std::int32_t one = 1 << unit_bits;
        constexpr std::int64_t quarter = std::int64_t{1}
                                         << (dynamics::pack_angle_bits - 2); // fits into 32 bits
        V turned[3];
        over_gyration(side, lane, moved + 3, side.turn_shift, turned);
        const V given = L::load32(&side.given[lane]), most = L::splat(quarter), least = L::splat(-quarter);
        Angle phi[3];
        Lever start[3];
        for (int i = 0; i < 3; ++i) {
            phi[i] = {L::without(between(turned[i], least, most), given)};
            r[i] = start[i] = Lever::load(&side.lever[i][lane]);
        }
        turn_by_part(phi, one / 4, r, start);
        turn_by_part(phi, one / 3, r, start);
        turn_by_part(phi, one / 2, r, start);
        turn_by(phi, r, start);
    }
    /// w x (w x r), w within 2048 rad/s and the inner product within 2048 m/s: beyond that an arc is no guide. As Speed.
    static void curve(const Side& side, unsigned lane, const Velocity (&motion)[6], const Lever (&r)[3],
                      V (&out)[3]) {
        const V most = L::splat(std::int64_t{1} << 30), least = L::splat(-(std::int64_t{1} << 30));
        Speed u[3], w[3], v[3];
        for (int i = 0; i < 3; ++i) u[i] = rounded<speed_bits>(motion[3 + i]);
        V spin[3];
        over_gyration(side, lane, u, side.spin_shift, spin);
        for (int i = 0; i < 3; ++i) w[i] = {between(spin[i], least, most)};
        const V bits = L::load64(&side.lever_bits[lane]);
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            v[i] = {between(L::shift_right_by((w[j] * r[k] - w[k] * r[j]).raw, bits), least, most)};
        }
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            out[i] = shift_arithmetic((w[j] * v[k] - w[k] * v[j]).raw, speed_bits);
        }
    }
    /// K^-1 (r x e) for the three axes e of the world, as rows. Returns the entries, 2 added to each, or-ed: where one is out
    /// of -2 .. 2, bits above those of 4 are set.
    static V write_arms(Side& side, unsigned lane, const Lever (&r)[3], bool negative) {
        V m[6], at[3];
        for (int i = 0; i < 6; ++i) m[i] = L::load32(&side.inverse[i][lane]);
        for (int i = 0; i < 3; ++i) at[i] = negative ? (-r[i]).raw : r[i].raw;
        const V shift = L::load64(&side.arm_shift[lane]), half = L::load64(&side.arm_half[lane]);
        const V two = L::splat(std::int64_t{2} << row_bits);
        V any = L::splat(0);
        for (int row = 0; row < 3; ++row) {
            const int j = (row + 1) % 3, k = (row + 2) % 3; // r x e is r_k along j and -r_j along k
            for (int i = 0; i < 3; ++i) {
                const V sum = L::sub(L::mul(m[inverse_at[i][j]], at[k]), L::mul(m[inverse_at[i][k]], at[j]));
                const V x = L::shift_right_by(L::add(sum, half), shift);
                L::store32(&side.x[row][i][lane], x);
                any = L::either(any, L::add(x, two));
            }
        }
        return any;
    }
    /// The speed that an error asks for: C rate, within push_max, and what lies ahead along the arc.
    static void set_bias(Pack& c, unsigned lane, const Data& data, int r, V error, V arc) {
        constexpr int split = 20, shift = gap_bits - speed_bits + dynamics::joint_rate_bits;
        const V rate = L::splat(data.rate), far = L::splat(std::int64_t{1} << 35),
                most = L::splat(0x7fffffff);
        const V nothing = L::splat(0), half = L::splat(std::int64_t{1} << (shift - 1));
        const V push = L::load32(&c.push_max[lane]), wide_push = L::template shift_left<shift>(push);
        const V near =
            between(L::shift_right_by(error, L::load64(&c.near_shift[lane])), L::sub(nothing, far), far);
        // 2^35 times 2^27, in two halves
        const V wanted =
            L::add(L::template shift_left<split>(L::mul(L::template shift_right<split>(near), rate)),
                   L::mul(L::both(near, L::splat((1 << split) - 1)), rate));
        const V within =
            between(wanted, L::sub(nothing, wide_push), L::add(wide_push, L::sub(half, L::splat(1))));
        const V way = L::mul(between(arc, L::sub(nothing, most), most), L::splat(data.time));
        const V ahead =
            between(L::shift_right_by(way, L::load64(&c.ahead_shift[lane])), L::sub(nothing, push), push);
        L::store32(&c.bias[r][lane], L::add(L::template shift_right<shift>(L::add(within, half)), ahead));
    }
    static void refresh_lanes(const Data& data, Pack& c, unsigned lane) {
        Gap moved_a[6], moved_b[6];
        Velocity motion_a[6], motion_b[6];
        gather_moved(c.a, lane, data, moved_a), gather_moved(c.b, lane, data, moved_b);
        gather(c.a, lane, data, motion_a), gather(c.b, lane, data, motion_b);
        Lever a[3], b[3];
        place(c.a, lane, moved_a, a), place(c.b, lane, moved_b, b);
        const V any = L::either(write_arms(c.a, lane, a, true), write_arms(c.b, lane, b, false));
        const unsigned over =
            L::lanes_of(L::greater64(L::template shift_right<row_bits + 2>(any), L::splat(0)));
        for (unsigned i = 0; i < N; ++i) c.over[lane + i] = (over >> i) & 1u;
        V arc_a[3], arc_b[3];
        curve(c.a, lane, motion_a, a, arc_a), curve(c.b, lane, motion_b, b, arc_b);
        // Lengths with 32 fraction bits: their sign up to where it belongs, and all down.
        const V bits_a = L::load64(&c.a.lever_bits[lane]), bits_b = L::load64(&c.b.lever_bits[lane]);
        const auto wide = [](V x) { return L::template shift_left<32>(x); };
        for (int r = 0; r < 3; ++r) {
            const V shift = L::sub(shift_arithmetic(wide(moved_b[r].raw), gap_bits),
                                   shift_arithmetic(wide(moved_a[r].raw), gap_bits));
            const V lever =
                L::sub(L::shift_right_by(wide(b[r].raw), bits_b), L::shift_right_by(wide(a[r].raw), bits_a));
            const V error = L::add(L::load64(&c.apart[r][lane]), L::add(shift, lever));
            set_bias(c, lane, data, r, error, L::sub(arc_b[r], arc_a[r]));
        }
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
    static void refresh(const Data& data, std::uint32_t first, std::uint32_t last) {
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < data.packs[i].count; lane += N)
                refresh_lanes(data, data.packs[i], lane);
    }
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
    static constexpr dynamics::JointKernel table() { return {refresh, warm_start, solve}; }
};

} // namespace lockstone::solve
