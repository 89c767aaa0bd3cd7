// Single axes of packed joints, written once for all lane widths L: springs, motors, friction and limits, including
// the point of the joint as in axis_with_point.h. See solve/joints/joint_pack.h for the formats.
//
// Only kernel.h includes this file. Joints: its PackedJoints, which defines the velocities.
#pragma once

#include "solve/joints/pack/joint_pack.h"
#include "solve/lanes/lane_fixed.h"

#include <bit>
#include <cstdint>

namespace lockstone::solve {

template <class L, class Joints> class JointAxes {
    static constexpr unsigned N = L::lanes, all_lanes = solve::pack_lanes;
    static constexpr int row_bits = 28, speed_bits = 19, unit_bits = 30;
    using Pack = solve::JointPack;
    using Side = solve::PackSide;
    using Axis = solve::AxisPack;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Row = LaneFixed<L, row_bits>;
    using Speed = LaneFixed<L, speed_bits>;
    using Velocity = typename Joints::Velocity;
    using Motion = typename Joints::Motion;
    template <class T> using Lanes = T[all_lanes];
    using Rows = Lanes<std::int32_t>;

    static constexpr std::int32_t impulse_max = solve::joint_impulse_max;

    static V whole(const std::int32_t* p) { return load_extended<L>(p); }
    static V whole(Speed x) { return extended<L>(x.lanes()); }
    template <int Bits> static V rounded_off(V x) {
        return L::template shift_right_signed<Bits>(L::add(x, L::splat(std::int64_t{1} << (Bits - 1))));
    }
    /// x / 2^shift, rounded; shift at least 1
    static V rounded_by(V x, V shift) {
        return L::shift_right_by(L::add(x, L::shift_left_by(L::splat(1), L::sub(shift, L::splat(1)))), shift);
    }
    static V between(V x, V least, V most) { return Joints::between(x, least, most); }
    /// Lanes where x is outside -2^Bits .. 2^Bits.
    template <int Bits> static V beyond(V x) {
        return L::greater64(L::template shift_right<Bits + 1>(L::add(x, L::splat(std::int64_t{1} << Bits))),
                            L::splat(0));
    }
    static bool acts(const Axis& x, unsigned lane) { return Mask::load(&x.acts[lane]).any(); }

    // ---- the direction d that includes the point -----------------------------------------------------------------

    /// Converts a sum of products of rows and responses of one side, 56 fraction bits, to its part of a mobility.
    static V mobility(V sum, const Side& side, unsigned lane) {
        constexpr int drop = 2 * row_bits - solve::mobility_bits, most = 60;
        if (!side.shifts) return rounded_off<drop>(sum);
        const V shift = L::add(L::load64(&side.shift[lane]), L::splat(drop)), end = L::splat(most);
        return rounded_by(sum, L::select(L::greater64(shift, end), end, shift)); // of sums below 2^62.6
    }
    static V dot(const Rows (&x)[3], const Rows (&y)[3], unsigned lane) {
        V sum = L::mul(L::load32(&x[0][lane]), L::load32(&y[0][lane]));
        for (int i = 1; i < 3; ++i) sum = L::add(sum, L::mul(L::load32(&x[i][lane]), L::load32(&y[i][lane])));
        return sum;
    }
    /// Computes A^-1 C, row_bits. Returns the lanes where it does not fit.
    static V find_answer(const Pack& c, const Axis& x, unsigned lane, V (&answer)[3]) {
        V coupling[3], fails = L::splat(0);
        for (int r = 0; r < 3; ++r) {
            const V both = L::add(mobility(dot(c.a.x[r], x.ra, lane), c.a, lane),
                                  mobility(dot(c.b.x[r], x.rb, lane), c.b, lane));
            coupling[r] = rounded_off<solve::mobility_bits - row_bits>(both);
            fails = L::either(fails, beyond<30>(coupling[r]));
        }
        for (int r = 0; r < 3; ++r) {
            V sum = L::splat(0); // 30 bits times 31, three times
            for (int s = 0; s < 3; ++s)
                sum = L::add(sum, L::mul(L::load32(&c.inverse.m[Joints::lower[r][s]][lane]), coupling[s]));
            if (c.inverse.odd != 0)
                answer[r] = Joints::shift_oddly(sum, c.inverse, lane);
            else
                answer[r] = L::shift_right_by(L::add(sum, L::load64(&c.inverse.half[lane])),
                                              L::load64(&c.inverse.shift[lane]));
            fails = L::either(fails, beyond<31>(answer[r]));
        }
        return fails;
    }
    /// Computes d of one side: linear, then angular. Returns the lanes where it does not fit.
    template <int Sign>
    static V lead_row(const Side& side, const Rows (&axis)[3], V one, const V (&answer)[3], unsigned lane,
                      V (&row)[6]) {
        V fails = L::splat(0);
        for (int i = 0; i < 3; ++i) {
            const V along = rounded_off<row_bits>(L::mul(answer[i], one));
            row[i] = Sign < 0 ? along : L::sub(L::splat(0), along);
            V sum = L::mul(answer[0], L::load32(&side.x[0][i][lane]));
            for (int r = 1; r < 3; ++r) sum = L::add(sum, L::mul(answer[r], L::load32(&side.x[r][i][lane])));
            row[3 + i] = L::sub(whole(&axis[i][lane]), rounded_off<row_bits>(sum));
        }
        for (const V& entry : row) fails = L::either(fails, beyond<30>(entry));
        return fails;
    }
    /// Writes d of one side and its responses; lanes in `fails` get the axis alone. Returns the side's part of the
    /// mobility.
    static V write_side(const Side& side, unsigned lane, V fails, const Rows (&axis_j)[3],
                        const Rows (&axis_r)[3], const V (&row)[6], Rows (&j)[6], Rows (&r)[6]) {
        const V share = L::load32(&side.share[lane]), half = L::splat(std::int64_t{1} << (unit_bits - 1));
        V sum = L::splat(0);
        for (int i = 0; i < 6; ++i) {
            const V response = L::template shift_right<unit_bits>(L::add(L::mul(row[i], share), half));
            sum = L::add(sum, L::mul(row[i], response));
            const V own_j = i < 3 ? L::splat(0) : L::load32(&axis_j[i - 3][lane]),
                    own_r = i < 3 ? L::splat(0) : L::load32(&axis_r[i - 3][lane]);
            L::store32(&j[i][lane], L::select(fails, own_j, row[i]));
            L::store32(&r[i][lane], L::select(fails, own_r, response));
        }
        return mobility(sum, side, lane);
    }
    /// 1 / k as mantissas and shifts, like invert_mobility(). k counts as at least 2^-29, and the result is zero for
    /// k <= 0.
    static void invert(V k, V& mantissa, V& shift) {
        std::int64_t m[N], by[N];
        L::store64(m, k);
        for (unsigned i = 0; i < N; ++i) {
            by[i] = 1;
            if (m[i] <= 0) {
                m[i] = 0;
                continue;
            }
            constexpr std::int64_t least = std::int64_t{1} << (solve::mobility_bits - 29);
            const auto some = static_cast<std::uint64_t>(m[i] < least ? least : m[i]);
            const int up = std::countl_zero(some) - 2;
            m[i] = static_cast<std::int64_t>((std::uint64_t{1} << 62) / (some << up >> 30) >> 1);
            by[i] = 92 - solve::mobility_bits - up - 1;
        }
        mantissa = L::from_lanes(m), shift = L::from_lanes(by);
    }

  public:
    /// Computes d of the axes of a pack, its responses and its inverse, from the present rows of the point.
    static void join(const Pack& c, Axis* axes, unsigned lane) {
        for (std::uint32_t k = 0; k < c.axis_count; ++k) {
            Axis& x = axes[c.first_axis + k];
            if (!acts(x, lane)) continue;
            V answer[3], a[6], b[6];
            const V one = L::load32(&c.one[lane]);
            V fails = find_answer(c, x, lane, answer);
            fails = L::either(fails, lead_row<-1>(c.a, x.ja, one, answer, lane, a));
            fails = L::either(fails, lead_row<1>(c.b, x.jb, one, answer, lane, b));
            const V along = L::add(write_side(c.a, lane, fails, x.ja, x.ra, a, x.lead_ja, x.lead_ra),
                                   write_side(c.b, lane, fails, x.jb, x.rb, b, x.lead_jb, x.lead_rb));
            const V alone = L::add(mobility(dot(x.ja, x.ra, lane), c.a, lane),
                                   mobility(dot(x.jb, x.rb, lane), c.b, lane));
            const V least = L::template shift_right<solve::least_part_bits>(alone);
            V mantissa, shift;
            invert(L::select(L::greater64(least, along), least, along), mantissa, shift);
            L::store32(&x.lead[lane], L::select(fails, L::load32(&x.inverse[lane]), mantissa));
            L::store64(&x.lead_shift[lane], L::select(fails, L::load64(&x.shift[lane]), shift));
            for (int r = 0; r < 3; ++r)
                L::store32(&x.answer[r][lane], L::select(fails, L::splat(0), answer[r]));
        }
    }

  private:
    // ---- passes --------------------------------------------------------------------------------------------------

    /// J . (v, u) of all six entries of both sides (First = 0), or of the angular ones (First = 3).
    template <int First>
    [[gnu::always_inline]] static Speed speed_along(const Rows* ja, const Rows* jb, unsigned lane,
                                                    const Motion& m) {
        auto sum = Row::load(&ja[0][lane]) * rounded<speed_bits>(m.a[First]) +
                   Row::load(&jb[0][lane]) * rounded<speed_bits>(m.b[First]);
        for (int i = 1; i < 6 - First; ++i)
            sum = sum + Row::load(&ja[i][lane]) * rounded<speed_bits>(m.a[First + i]) +
                  Row::load(&jb[i][lane]) * rounded<speed_bits>(m.b[First + i]);
        return rounded_within<speed_bits>(sum, impulse_max);
    }
    template <int First>
    [[gnu::always_inline]] static void push(const Side& side, const Rows* r, unsigned lane, Speed change,
                                            Velocity (&v)[6]) {
        for (int i = 0; i < 6 - First; ++i)
            Joints::add_rounded(v[First + i], Row::load(&r[i][lane]) * change, side, lane);
    }
    /// k^-1 speed
    static V impulse_for(Speed speed, const Rows& inverse, const Lanes<std::int64_t>& shift, unsigned lane) {
        constexpr std::int64_t most = solve::impulse_change_max;
        const V x = rounded_by(L::mul(L::load32(&inverse[lane]), speed.lanes()), L::load64(&shift[lane]));
        return between(x, L::splat(-most), L::splat(most));
    }
    static V times_unit(V x, const Rows& scale, unsigned lane) {
        return rounded_off<unit_bits>(L::mul(x, L::load32(&scale[lane])));
    }
    static unsigned count(Mask mask) {
        unsigned sum = 0;
        for (unsigned i = 0, set = mask.lanes(); i < N; ++i) sum += (set >> i) & 1u;
        return sum;
    }

    [[gnu::always_inline]] static void spring(Axis& x, const Pack& c, unsigned lane, Motion& m) {
        const Mask has = Mask::load(&x.has_spring[lane]);
        if (!has.any()) return;
        const Speed speed = speed_along<3>(x.ja, x.jb, lane, m), old = Speed::load(&x.spring[lane]);
        const V p = whole(old), bound = whole(&x.spring_bound[lane]);
        const V by = impulse_for(speed + Speed::load(&x.spring_bias[lane]), x.inverse, x.shift, lane);
        const V wanted =
            L::sub(L::sub(p, times_unit(by, x.mass_scale, lane)), times_unit(p, x.impulse_scale, lane));
        const Speed next = Speed::of(between(wanted, L::sub(L::splat(0), bound), bound)),
                    change = (next - old) & has;
        (old + change).store(&x.spring[lane]);
        push<3>(c.a, x.ra, lane, change, m.a), push<3>(c.b, x.rb, lane, change, m.b);
        Joints::keep_small(m, Joints::or_size(Speed::splat(0), change));
    }

    /// Drives the speed towards -bias, with impulses from `low` to `high`. Skips lanes whose impulse is at a bound
    /// and would be pushed beyond it. `pushes`: lanes with an exceeded limit. Their push back uses the axis without
    /// the point: arms on arms gain energy if they are pushed as hard as they are stopped.
    [[gnu::always_inline]] static void lead(Axis& x, Pack& c, Rows& impulse, Mask has, Speed bias, Speed low,
                                            Speed high, Mask pushes, unsigned lane, Motion& m,
                                            std::uint64_t& clamped) {
        const Speed nothing = Speed::splat(0), p = Speed::load(&impulse[lane]);
        const Speed asks = speed_along<3>(x.ja, x.jb, lane, m) + bias;
        const Mask at_bound = ~((p > low) | (nothing > asks)) | ~((high > p) | (asks > nothing));
        const Mask active = has & ~at_bound;
        if (!active.any()) return;
        const Speed speed = speed_along<0>(x.lead_ja, x.lead_jb, lane, m);
        const V stop = impulse_for(speed + (bias & ~pushes), x.lead, x.lead_shift, lane);
        const V back = L::both(impulse_for(bias, x.inverse, x.shift, lane), pushes.whole());
        const V wanted = L::sub(whole(p), L::add(stop, back));
        const V next = between(wanted, whole(low), whole(high));
        const Speed change = (Speed::of(next) - p) & active;
        (p + change).store(&impulse[lane]);
        const V most = L::splat(impulse_max), least = L::splat(-std::int64_t{impulse_max});
        const V over = L::without(L::greater64(wanted, next), L::greater64(most, next)),
                under = L::without(L::greater64(next, wanted), L::greater64(next, least));
        clamped += count(Mask::of(L::either(over, under)) & ((change > nothing) | (nothing > change)));
        push<0>(c.a, x.lead_ra, lane, change, m.a), push<0>(c.b, x.lead_rb, lane, change, m.b);
        Speed sizes = Joints::or_size(nothing, change);
        for (int r = 0; r < 3; ++r) {
            const Speed old = Speed::load(&c.impulse[r][lane]);
            const V point = L::sub(
                whole(old), rounded_off<row_bits>(L::mul(L::load32(&x.answer[r][lane]), change.lanes())));
            const V kept = between(point, least, most);
            const Speed now = Speed::of(kept);
            clamped += count(Mask::of(L::either(L::greater64(point, kept), L::greater64(kept, point))));
            now.store(&c.impulse[r][lane]);
            sizes = Joints::or_size(sizes, now - old);
        }
        Joints::keep_small(m, sizes);
    }

  public:
    /// One pass over the axes of a pack, in order.
    static void solve(Pack& c, Axis* axes, unsigned lane, bool bias, Motion& m, std::uint64_t& clamped) {
        const Speed nothing = Speed::splat(0), most = Speed::splat(impulse_max);
        for (std::uint32_t k = 0; k < c.axis_count; ++k) {
            Axis& x = axes[c.first_axis + k];
            if (!acts(x, lane)) continue;
            // A spring applies its impulse once per substep; the relaxation does not change it.
            if (bias) spring(x, c, lane, m);
            if (const Mask has = Mask::load(&x.has_motor[lane]); has.any()) {
                const Speed bound = Speed::load(&x.motor_bound[lane]), of = Speed::load(&x.motor_bias[lane]);
                lead(x, c, x.motor, has, of, -bound, bound, Mask::none(), lane, m, clamped);
            }
            if (const Mask has = Mask::load(&x.has_lower[lane]); has.any()) {
                const Speed of = Speed::load(bias ? &x.lower_bias[lane] : &x.lower_relax[lane]);
                lead(x, c, x.lower, has, of, nothing, most, nothing > of, lane, m, clamped);
            }
            if (const Mask has = Mask::load(&x.has_upper[lane]); has.any()) {
                const Speed of = Speed::load(bias ? &x.upper_bias[lane] : &x.upper_relax[lane]);
                lead(x, c, x.upper, has, of, -most, nothing, of > nothing, lane, m, clamped);
            }
        }
    }
    /// Applies the impulses of the axes of a pack to one of its sides.
    template <int Sign>
    static void warm_side(const Pack& c, Axis* axes, unsigned lane, bool sums, Velocity (&v)[6]) {
        for (std::uint32_t k = 0; k < c.axis_count; ++k) {
            Axis& x = axes[c.first_axis + k];
            if (!acts(x, lane)) continue;
            const V sum = L::add(L::add(whole(&x.spring[lane]), whole(&x.motor[lane])),
                                 L::add(whole(&x.lower[lane]), whole(&x.upper[lane])));
            const V p = between(sum, L::splat(-std::int64_t{impulse_max}), L::splat(impulse_max));
            if (sums) L::store64(&x.sum[lane], L::add(L::load64(&x.sum[lane]), p));
            const Speed warm = Speed::of(p);
            push<3>(Sign < 0 ? c.a : c.b, Sign < 0 ? x.ra : x.rb, lane, warm, v);
            Joints::keep_small(v, Joints::or_size(Speed::splat(0), warm));
        }
    }
};

} // namespace lockstone::solve
