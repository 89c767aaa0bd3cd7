// The passes over packs of joints, for all lane widths L. Symbols: solve/joints/joint.h; formats: joint_pack.h.
//
// Only files that are compiled for one instruction set include this file. It must not use inline functions that other
// files use too, since the linker keeps only one of their copies.
#pragma once

#include "solve/joints/pack/axis_kernel.h"
#include "solve/joints/pack/held_kernel.h"
#include "solve/joints/pack/inverse_kernel.h"
#include "solve/joints/pack/joint_pack.h"
#include "solve/joints/pack/start_kernel.h"
#include "solve/lanes/lane_fixed.h"

#include <cstddef>
#include <type_traits>

namespace lockstone::solve {

template <class L> class PackedJoints {
    static constexpr unsigned N = L::lanes, all_lanes = solve::pack_lanes;
    static constexpr int accumulator_bits = 47, row_bits = 28, speed_bits = 19, unit_bits = 30, gap_bits = 27;
    using Pack = solve::JointPack;
    using Side = solve::PackSide;
    using Turn = solve::TurnPack;
    using Data = solve::JointPassData;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Row = LaneFixed<L, row_bits>;
    using Speed = LaneFixed<L, speed_bits>;
    using Unit = LaneFixed<L, unit_bits>;
    using Gap = LaneFixed<L, gap_bits>;
    using Velocity = LaneSum<L, accumulator_bits>;
    template <class T> using Lanes = T[all_lanes];
    using Axes = JointAxes<L, PackedJoints>;
    friend Axes;

    static constexpr std::int32_t impulse_max = solve::joint_impulse_max;
    static constexpr int lower[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};

    /// Velocities of the two bodies of each lane: v, u
    struct Motion {
        Velocity a[6], b[6];
    };

    static V between(V x, V least, V most) {
        x = L::select(L::greater64(x, most), most, x);
        return L::select(L::greater64(least, x), least, x);
    }
    static V shift_arithmetic(V x, int by) { return L::shift_right_by(x, L::splat(by)); }
    static void add_to(std::int64_t* sum, V x) { L::store64(sum, L::add(L::load64(sum), x)); }

    // ---- bodies --------------------------------------------------------------------------------------------------

    static solve::SolverBody* body_at(const Data& data, std::uint32_t place) {
        return reinterpret_cast<solve::SolverBody*>(reinterpret_cast<std::byte*>(data.bodies) + place);
    }
    [[gnu::always_inline]] static void gather(const Side& side, unsigned lane, const Data& data,
                                              Velocity (&out)[6]) {
        const solve::SolverBody* body[N];
        for (unsigned i = 0; i < N; ++i) body[i] = body_at(data, side.place[lane + i]);
        V raw[6];
        L::gather6(body, raw);
        for (int i = 0; i < 6; ++i) out[i] = {raw[i]};
    }
    /// Packs share bodies that impulses do not move: these are not written.
    [[gnu::always_inline]] static void scatter(const Side& side, unsigned lane, const Data& data,
                                               const Velocity (&x)[6]) {
        V raw[6];
        for (int i = 0; i < 6; ++i) raw[i] = x[i].raw;
        solve::SolverBody *to[N], spare;
        for (unsigned i = 0; i < N; ++i) to[i] = body_at(data, side.place[lane + i]);
        constexpr unsigned all = (1u << N) - 1;
        const unsigned moved = (side.moved >> lane) & all;
        for (unsigned i = 0; i < N && moved != all; ++i)
            if (((moved >> i) & 1u) == 0) to[i] = &spare;
        L::scatter6(to, raw);
    }
    [[gnu::always_inline]] static void gather(const Pack& c, unsigned lane, const Data& data, Motion& m) {
        gather(c.a, lane, data, m.a), gather(c.b, lane, data, m.b);
        keep_readable(m.a), keep_readable(m.b);
    }
    [[gnu::always_inline]] static void scatter(const Pack& c, unsigned lane, const Data& data,
                                               const Motion& m) {
        scatter(c.a, lane, data, m.a), scatter(c.b, lane, data, m.b);
    }

    /// Clamps velocities to the range that rows can read, in the lanes of the mask.
    static void clamp_motion(Velocity (&v)[6], V mask) {
        const V most = L::splat(solve::motion_max), least = L::splat(-solve::motion_max);
        const auto clamped = [&](Velocity& x) { x = {L::select(mask, between(x.raw, least, most), x.raw)}; };
        // Not a loop: compilers do not unroll it where it rarely runs, and then keep all velocities in memory.
        clamped(v[0]), clamped(v[1]), clamped(v[2]), clamped(v[3]), clamped(v[4]), clamped(v[5]);
    }
    static void clamp_motion(Motion& m, V mask) { clamp_motion(m.a, mask), clamp_motion(m.b, mask); }
    [[gnu::always_inline]] static void keep_readable(Velocity (&v)[6]) {
        const V most = L::splat(solve::motion_max);
        V any = L::splat(0); // the sum is in 0 .. 2 motion_max unless the velocity exceeds the bound
        for (int i = 0; i < 6; ++i) any = L::either(any, L::add(v[i].raw, most));
        const V beyond = L::greater64(L::template shift_right<solve::motion_bits + 1>(any), L::splat(0));
        if (L::lanes_of(beyond) != 0) clamp_motion(v, beyond);
    }
    /// Clamps velocities after a large change of impulse. `sizes`: the changes, combined by bitwise or.
    static void keep_small(Motion& m, Speed sizes) {
        const Mask large = sizes > Speed::splat(solve::small_impulse - 1);
        if (large.any()) clamp_motion(m, large.whole());
    }
    /// As above, for one side.
    static void keep_small(Velocity (&v)[6], Speed sizes) {
        const Mask large = sizes > Speed::splat(solve::small_impulse - 1);
        if (large.any()) clamp_motion(v, large.whole());
    }
    static Speed or_size(Speed sizes, Speed p) { return {L::either(sizes.raw, max(p, -p).raw)}; }

    // ---- common parts of the passes ------------------------------------------------------------------------------

    template <class X> static auto dot(const Lanes<std::int32_t> (&x)[3], unsigned lane, const X& y) {
        return Row::load(&x[0][lane]) * y[0] + Row::load(&x[1][lane]) * y[1] + Row::load(&x[2][lane]) * y[2];
    }
    static void add_rounded(Velocity& v, Velocity sum, const Side& side, unsigned lane) {
        if (side.shifts)
            sum.raw =
                L::shift_right_by(L::add(sum.raw, L::load64(&side.half[lane])), L::load64(&side.shift[lane]));
        v = v + sum;
    }

    /// x / 2^shift if the shift of an inverse is outside its usual range.
    static V shift_oddly(V x, const solve::PackInverse& inverse, unsigned lane) {
        std::int64_t v[N];
        L::store64(v, x);
        for (unsigned i = 0; i < N; ++i) {
            const std::int64_t shift = inverse.shift[lane + i], far = std::int64_t{1} << 31;
            if (shift > 62)
                v[i] = 0;
            else if (shift > 0)
                v[i] = (v[i] + (std::int64_t{1} << (shift - 1))) >> shift;
            else // the caller clamps the result to less
                v[i] = (v[i] < -far  ? -far
                        : v[i] > far ? far
                                     : v[i]) *
                       (std::int64_t{1} << (-shift < 31 ? -shift : 31));
        }
        return L::from_lanes(v);
    }

    /// Computes new impulses from speeds and old impulses with the inverse of a part. Returns the changes.
    struct Change {
        Speed p[3];
        Speed sizes;
    };
    template <int Rows>
    [[gnu::always_inline]] static Change
    answer(const solve::PackInverse& inverse, Lanes<std::int32_t> (&impulse)[3], unsigned lane,
           const Speed (&speed)[3], const Data& data, bool bias, std::uint64_t& clamped) {
        const bool odd = inverse.odd != 0;
        const V most = L::splat(solve::impulse_change_max), least = L::splat(-solve::impulse_change_max);
        const Speed bound = Speed::splat(impulse_max);
        Change change;
        change.sizes = Speed::splat(0);
        Mask met[3] = {Mask::none(), Mask::none(), Mask::none()}, any_met = Mask::none();
        for (int r = 0; r < Rows; ++r) {
            V sum = L::splat(0); // 30 bits times 31, three times
            for (int s = 0; s < Rows; ++s)
                sum = L::add(sum, L::mul(load_low<L>(&inverse.m[lower[r][s]][lane]), speed[s].raw));
            if (odd)
                sum = shift_oddly(sum, inverse, lane);
            else
                sum = L::shift_right_by(L::add(sum, L::load64(&inverse.half[lane])),
                                        L::load64(&inverse.shift[lane]));
            Speed wanted = Speed::of(between(sum, least, most));
            const Speed old = Speed::load(&impulse[r][lane]);
            if (bias)
                wanted = rounded<speed_bits>(wanted * Unit::splat(data.mass_scale)) +
                         rounded<speed_bits>(old * Unit::splat(data.impulse_scale));
            const Speed next = old - wanted, now = clamp(next, bound);
            met[r] = (next > now) | (now > next);
            now.store(&impulse[r][lane]);
            change.p[r] = now - old;
            change.sizes = or_size(change.sizes, change.p[r]);
            any_met = any_met | met[r];
        }
        if (any_met.any()) [[unlikely]]
            for (const Mask& mask : met)
                for (unsigned i = 0; i < N; ++i) clamped += (mask.lanes() >> i) & 1u;
        return change;
    }

    // ---- rows without linear part --------------------------------------------------------------------------------

    template <int Rows>
    [[gnu::always_inline]] static void push_turn(const Lanes<std::int32_t> (*j)[3], const Side& side,
                                                 unsigned lane, const Speed (&p)[3], Velocity (&v)[6]) {
        const Unit share = Unit::load(&side.share[lane]);
        Speed part[3];
        for (int r = 0; r < Rows; ++r) part[r] = rounded<speed_bits>(share * p[r]);
        for (int i = 0; i < 3; ++i) {
            Velocity sum = Row::load(&j[0][i][lane]) * part[0];
            for (int r = 1; r < Rows; ++r) sum = sum + Row::load(&j[r][i][lane]) * part[r];
            add_rounded(v[3 + i], sum, side, lane);
        }
    }
    template <int Rows>
    [[gnu::always_inline]] static void solve_turn(Turn& t, const Pack& c, unsigned lane, const Data& data,
                                                  bool bias, Motion& m, std::uint64_t& clamped) {
        Speed a[3], b[3], speed[3];
        for (int i = 0; i < 3; ++i)
            a[i] = rounded<speed_bits>(m.a[3 + i]), b[i] = rounded<speed_bits>(m.b[3 + i]);
        for (int r = 0; r < Rows; ++r) {
            speed[r] = rounded_within<speed_bits>(dot(t.ja[r], lane, a) + dot(t.jb[r], lane, b), impulse_max);
            if (bias) speed[r] = speed[r] + Speed::load(&t.bias[r][lane]);
        }
        const Change change = answer<Rows>(t.inverse, t.impulse, lane, speed, data, bias, clamped);
        push_turn<Rows>(t.ja, c.a, lane, change.p, m.a);
        push_turn<Rows>(t.jb, c.b, lane, change.p, m.b);
        keep_small(m, change.sizes);
    }

    // ---- points --------------------------------------------------------------------------------------------------

    template <int Sign>
    [[gnu::always_inline]] static void push_point(const Side& side, unsigned lane, const Speed (&p)[3],
                                                  Velocity (&v)[6]) {
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

    [[gnu::always_inline]] static void solve_point(Pack& c, unsigned lane, const Data& data, bool bias,
                                                   Motion& m, std::uint64_t& clamped) {
        Speed a[6], b[6], speed[3];
        for (int i = 0; i < 6; ++i) a[i] = rounded<speed_bits>(m.a[i]), b[i] = rounded<speed_bits>(m.b[i]);
        const Row one = Row::load(&c.one[lane]);
        for (int r = 0; r < 3; ++r)
            speed[r] = rounded_within<speed_bits>(
                one * (b[r] - a[r]) + dot(c.a.x[r], lane, a + 3) + dot(c.b.x[r], lane, b + 3), impulse_max);
        for (int r = 0; r < 3 && bias; ++r) speed[r] = speed[r] + Speed::load(&c.bias[r][lane]);
        const Change change = answer<3>(c.inverse, c.impulse, lane, speed, data, bias, clamped);
        push_point<-1>(c.a, lane, change.p, m.a);
        push_point<1>(c.b, lane, change.p, m.b);
        keep_small(m, change.sizes);
    }

    // ---- rows of points ------------------------------------------------------------------------------------------

    using Lever = LaneFixed<L, 0>; ///< scaled differently in each lane
    static constexpr int inverse_at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

    /// A rotation matrix by rows, 30 fraction bits in the low halves of lanes.
    struct Turned {
        V m[3][3];
        void times(const V (&v)[3], V (&out)[3]) const {
            const V half = L::splat(std::int64_t{1} << (unit_bits - 1));
            for (int i = 0; i < 3; ++i) {
                const V sum =
                    L::add(L::add(L::mul(m[i][0], v[0]), L::mul(m[i][1], v[1])), L::mul(m[i][2], v[2]));
                out[i] = L::template shift_right<unit_bits>(L::add(sum, half));
            }
        }
    };
    /// The matrix of a body that has not turned.
    struct Unturned {
        void times(const V (&v)[3], V (&out)[3]) const { out[0] = v[0], out[1] = v[1], out[2] = v[2]; }
    };
    /// Present placement of the bodies of one side.
    struct Placed {
        Turned turned;
        Speed spin[3];
        Gap shift[3];
    };
    [[gnu::always_inline]] static void look(const Side& side, unsigned lane, const Data& data, int first_row,
                                            V (&out)[4][4]) {
        const std::int32_t* row[N];
        for (unsigned i = 0; i < N; ++i)
            row[i] = reinterpret_cast<const std::int32_t*>(reinterpret_cast<const std::byte*>(data.turned) +
                                                           side.turned[lane + i]) +
                     4 * first_row;
        for (int r = first_row; r < 4; ++r) {
            L::quads(row, out[r]);
            for (auto& at : row) at += 4;
        }
    }
    [[gnu::always_inline]] static Placed placed(const Side& side, unsigned lane, const Data& data) {
        V x[4][4];
        look(side, lane, data, 0, x);
        return {{{{x[0][0], x[0][1], x[0][2]}, {x[0][3], x[1][0], x[1][1]}, {x[1][2], x[1][3], x[2][0]}}},
                {Speed::of(x[2][1]), Speed::of(x[2][2]), Speed::of(x[2][3])},
                {Gap::of(x[3][0]), Gap::of(x[3][1]), Gap::of(x[3][2])}};
    }
    /// Turns a vector from the start of the tick to the present rotation of the body.
    static void turn(const auto& by, const Lanes<std::int32_t> (&from)[3], unsigned lane, V (&out)[3]) {
        const V v[3] = {L::load32(&from[0][lane]), L::load32(&from[1][lane]), L::load32(&from[2][lane])};
        by.times(v, out);
    }
    static void place(const Side& side, unsigned lane, const auto& by, Lever (&r)[3]) {
        V now[3];
        turn(by, side.lever, lane, now);
        for (int i = 0; i < 3; ++i) r[i] = Lever::of(now[i]);
    }
    /// w x (w x r) as Speed. The inner product is clamped to 2048 m/s, beyond which the arc is of no use.
    [[gnu::always_inline]] static void curve(const Side& side, unsigned lane, const Speed (&w)[3],
                                             const Lever (&r)[3], V (&out)[3]) {
        const V most = L::splat(std::int64_t{1} << 30), least = L::splat(-(std::int64_t{1} << 30));
        Speed v[3];
        const V bits = L::load64(&side.lever_bits[lane]);
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            v[i] = Speed::of(between(L::shift_right_by((w[j] * r[k] - w[k] * r[j]).raw, bits), least, most));
        }
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            out[i] = shift_arithmetic((w[j] * v[k] - w[k] * v[j]).raw, speed_bits);
        }
    }
    /// Writes K^-1 (r x e) for the three world axes e, as rows. Returns the entries plus 2, combined by bitwise or:
    /// bits above those of 4 are set if an entry is outside -2 .. 2.
    [[gnu::always_inline]] static V write_arms(Side& side, unsigned lane, const Lever (&r)[3],
                                               bool negative) {
        V m[6], at[3];
        for (int i = 0; i < 6; ++i) m[i] = L::load32(&side.inverse[i][lane]);
        for (int i = 0; i < 3; ++i) at[i] = (negative ? -r[i] : r[i]).lanes();
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
    /// Writes the bias: C rate, clamped to push_max, plus the look-ahead along the arc.
    [[gnu::always_inline]] static void set_bias(Pack& c, unsigned lane, const Data& data, int r, V error,
                                                V arc) {
        constexpr int split = 20, shift = gap_bits - speed_bits + solve::joint_rate_bits;
        const V rate = L::splat(data.rate), far = L::splat(std::int64_t{1} << 35),
                most = L::splat(0x7fffffff);
        const V nothing = L::splat(0), half = L::splat(std::int64_t{1} << (shift - 1));
        const V push = load_extended<L>(&c.push_max[lane]), wide_push = L::template shift_left<shift>(push);
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
    [[gnu::always_inline]] static void refresh_lanes(const Data& data, Pack& c, unsigned lane) {
        const Placed a = placed(c.a, lane, data), b = placed(c.b, lane, data);
        make_rows(data, c, lane, a, b, a.turned, b.turned);
    }
    /// refresh_lanes() before any body has moved. A turn by zero would give the same bits.
    [[gnu::always_inline]] static void begin_lanes(const Data& data, Pack& c, unsigned lane) {
        const auto spinning = [&](const Side& side) {
            V x[4][4];
            look(side, lane, data, 2, x);
            Placed out;
            for (int i = 0; i < 3; ++i) out.spin[i] = Speed::of(x[2][1 + i]), out.shift[i] = Gap::splat(0);
            return out;
        };
        make_rows(data, c, lane, spinning(c.a), spinning(c.b), Unturned{}, Unturned{});
    }
    [[gnu::always_inline]] static void make_rows(const Data& data, Pack& c, unsigned lane,
                                                 const Placed& placed_a, const Placed& placed_b,
                                                 const auto& turned_a, const auto& turned_b) {
        Lever a[3], b[3];
        place(c.a, lane, turned_a, a), place(c.b, lane, turned_b, b);
        if (c.hinges) refresh_hinges(data.turns[c.turn], c, lane, data, turned_a, turned_b);
        const V any = L::either(write_arms(c.a, lane, a, true), write_arms(c.b, lane, b, false));
        const unsigned over =
            L::lanes_of(L::greater64(L::template shift_right<row_bits + 2>(any), L::splat(0)));
        c.over = (lane == 0 ? 0 : c.over) | over << lane;
        V arc_a[3], arc_b[3];
        curve(c.a, lane, placed_a.spin, a, arc_a), curve(c.b, lane, placed_b.spin, b, arc_b);
        // Lengths get 32 fraction bits: shift the sign up to the top, then everything down.
        const V bits_a = L::load64(&c.a.lever_bits[lane]), bits_b = L::load64(&c.b.lever_bits[lane]);
        const auto wide = [](auto x) { return L::template shift_left<32>(x.lanes()); };
        for (int r = 0; r < 3; ++r) {
            const V shift = L::sub(shift_arithmetic(wide(placed_b.shift[r]), gap_bits),
                                   shift_arithmetic(wide(placed_a.shift[r]), gap_bits));
            const V lever =
                L::sub(L::shift_right_by(wide(b[r]), bits_b), L::shift_right_by(wide(a[r]), bits_a));
            const V error = L::add(L::load64(&c.apart[r][lane]), L::add(shift, lever));
            set_bias(c, lane, data, r, error, L::sub(arc_b[r], arc_a[r]));
        }
    }

    // ---- hinges --------------------------------------------------------------------------------------------------

    static V dot30(const V (&a)[3], const V (&b)[3]) { // 60 fraction bits
        return L::add(L::add(L::mul(a[0], b[0]), L::mul(a[1], b[1])), L::mul(a[2], b[2]));
    }
    /// a x b of unit vectors, as an axis of rows.
    static void cross(const V (&a)[3], const V (&b)[3], V (&out)[3]) {
        constexpr int shift = 2 * unit_bits - row_bits;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const V sum = L::sub(L::mul(a[j], b[k]), L::mul(a[k], b[j]));
            out[i] = L::template shift_right<shift>(L::add(sum, L::splat(std::int64_t{1} << (shift - 1))));
        }
    }
    /// Stores x, except in lanes whose rows are made elsewhere.
    static void keep(std::int32_t* to, V x, V kept) { L::store32(to, L::select(kept, L::load32(to), x)); }

    /// K^-1 axis as a row of one side.
    template <int Sign>
    static void write_row(const Side& side, unsigned lane, const Lanes<std::int64_t>& shifts,
                          const V (&axis)[3], V generic, Lanes<std::int32_t> (&row)[3]) {
        const V shift = L::load64(&shifts[lane]);
        const V half = L::shift_left_by(L::splat(1), L::sub(shift, L::splat(1)));
        for (int i = 0; i < 3; ++i) {
            V sum = L::mul(L::load32(&side.inverse[inverse_at[i][0]][lane]), axis[0]);
            for (int k = 1; k < 3; ++k)
                sum = L::add(sum, L::mul(L::load32(&side.inverse[inverse_at[i][k]][lane]), axis[k]));
            const V x = L::shift_right_by(L::add(sum, half), shift);
            keep(&row[i][lane], Sign < 0 ? L::sub(L::splat(0), x) : x, generic);
        }
    }
    static void refresh_hinges(Turn& t, const Pack& c, unsigned lane, const Data& data, const auto& turned_a,
                               const auto& turned_b) {
        V y[3], z[3], xb[3], yb[3], axis[2][3];
        turn(turned_a, t.frame_a[0], lane, y), turn(turned_a, t.frame_a[1], lane, z);
        turn(turned_b, t.frame_b[0], lane, xb), turn(turned_b, t.frame_b[1], lane, yb);
        cross(z, xb, axis[0]), cross(xb, y, axis[1]);
        const V generic = L::load32(&t.generic[lane]), nothing = L::splat(0);
        const V error[2] = {L::template shift_right_signed<unit_bits>(L::sub(nothing, dot30(xb, z))),
                            L::template shift_right_signed<unit_bits>(dot30(xb, y))};
        // xA . xB = (1 - C^2)^(1/2)
        constexpr std::int64_t apart = std::int64_t{1} << (2 * unit_bits - 1);
        const V off = L::add(L::mul(error[0], error[0]), L::mul(error[1], error[1]));
        // cos(t - middle) - cos(reach)
        const V cosine = L::template shift_right_signed<unit_bits>(dot30(y, yb)),
                sine = L::template shift_right_signed<unit_bits>(dot30(z, yb));
        const V near = L::add(L::mul(cosine, L::load32(&t.middle_cos[lane])),
                              L::mul(sine, L::load32(&t.middle_sin[lane])));
        const unsigned far_apart = L::lanes_of(L::greater64(off, L::splat(apart))),
                       reaches = L::lanes_of(L::greater64(
                           L::mul(L::load32(&t.reach_cos[lane]), L::splat(std::int64_t{1} << unit_bits)),
                           near));
        for (unsigned i = 0; i < N; ++i)
            t.apart[lane + i] = (far_apart >> i) & 1u, t.reaches[lane + i] = (reaches >> i) & 1u;
        const V shift = L::load64(&t.bias_shift[lane]), push = load_extended<L>(&t.push_max[lane]);
        const V half = L::shift_left_by(L::splat(1), L::sub(shift, L::splat(1)));
        for (int r = 0; r < 2; ++r) {
            for (int i = 0; i < 3; ++i) L::store32(&t.axis[r][i][lane], axis[r][i]);
            write_row<-1>(c.a, lane, t.shift_a, axis[r], generic, t.ja[r]);
            write_row<1>(c.b, lane, t.shift_b, axis[r], generic, t.jb[r]);
            const V wanted = L::shift_right_by(L::add(L::mul(error[r], L::splat(data.rate)), half), shift);
            keep(&t.bias[r][lane], between(wanted, L::sub(nothing, push), push), generic);
        }
    }

    // ---- passes --------------------------------------------------------------------------------------------------

    template <int Rows>
    static void add_to_sums(Lanes<std::int64_t> (&sum)[3], unsigned lane, const Speed (&p)[3]) {
        for (int r = 0; r < Rows; ++r) add_to(&sum[r][lane], signed_lanes<L>(p[r].raw));
    }
    /// Applies the impulses of a pack to one of its sides.
    template <int Sign, int Rows>
    [[gnu::always_inline]] static void warm_side(const Data& data, const Pack& c,
                                                 const Lanes<std::int32_t> (*turns)[3], unsigned lane,
                                                 const Change& turn, const Speed (&point)[3], bool sums) {
        const Side& side = Sign < 0 ? c.a : c.b;
        Velocity v[6];
        gather(side, lane, data, v);
        keep_readable(v);
        if (data.axes != nullptr && c.axis_count != 0)
            Axes::template warm_side<Sign>(c, data.axes, lane, sums, v);
        if constexpr (Rows != 0) {
            push_turn<Rows>(turns, side, lane, turn.p, v);
            keep_small(v, turn.sizes);
        }
        push_point<Sign>(side, lane, point, v);
        keep_readable(v);
        scatter(side, lane, data, v);
    }
    template <int Rows>
    [[gnu::always_inline]] static void warm_lanes(const Data& data, Pack& c, unsigned lane, bool sums) {
        Change turn;
        Speed point[3];
        Turn* const t = Rows != 0 ? &data.turns[c.turn] : nullptr;
        if constexpr (Rows != 0) {
            turn.sizes = Speed::splat(0);
            for (int r = 0; r < Rows; ++r)
                turn.p[r] = Speed::load(&t->impulse[r][lane]), turn.sizes = or_size(turn.sizes, turn.p[r]);
            if (sums) add_to_sums<Rows>(t->sum, lane, turn.p);
        }
        for (int r = 0; r < 3; ++r) point[r] = Speed::load(&c.impulse[r][lane]);
        if (sums) add_to_sums<3>(c.sum, lane, point);
        warm_side<-1, Rows>(data, c, Rows != 0 ? t->ja : nullptr, lane, turn, point, sums);
        warm_side<1, Rows>(data, c, Rows != 0 ? t->jb : nullptr, lane, turn, point, /*sums=*/false);
    }
    template <int Rows>
    [[gnu::always_inline]] static void solve_lanes(const Data& data, Pack& c, unsigned lane, bool bias,
                                                   std::uint64_t& clamped) {
        Motion m;
        gather(c, lane, data, m);
        if (data.axes != nullptr && c.axis_count != 0) Axes::solve(c, data.axes, lane, bias, m, clamped);
        if constexpr (Rows != 0) solve_turn<Rows>(data.turns[c.turn], c, lane, data, bias, m, clamped);
        solve_point(c, lane, data, bias, m, clamped);
        scatter(c, lane, data, m);
    }
    /// End of the loop over the pieces of a pack: a constant if one piece is the whole pack, so that the loop
    /// disappears.
    static unsigned end_of(const Pack& c) { return N == all_lanes ? 1u : c.count; }
    /// Calls visit(turn_rows as an integral constant, first, last) for each run of packs with equal turn_rows.
    template <class Visit>
    static void by_rows(const Data& data, std::uint32_t first, std::uint32_t last, Visit&& visit) {
        for (std::uint32_t end; first < last; first = end) {
            const std::uint32_t rows = data.packs[first].turn_rows;
            for (end = first + 1; end < last && data.packs[end].turn_rows == rows;) ++end;
            switch (rows) {
            case 0:
                visit(std::integral_constant<int, 0>{}, first, end);
                break;
            case 1:
                visit(std::integral_constant<int, 1>{}, first, end);
                break;
            case 2:
                visit(std::integral_constant<int, 2>{}, first, end);
                break;
            default:
                visit(std::integral_constant<int, 3>{}, first, end);
            }
        }
    }
    template <int Rows>
    [[gnu::noinline]] static void warm_run(const Data& data, std::uint32_t first, std::uint32_t last,
                                           bool sums) {
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < end_of(data.packs[i]); lane += N)
                warm_lanes<Rows>(data, data.packs[i], lane, sums);
    }
    template <int Rows>
    [[gnu::noinline]] static std::uint64_t solve_run(const Data& data, std::uint32_t first,
                                                     std::uint32_t last, bool bias) {
        std::uint64_t clamped = 0;
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < end_of(data.packs[i]); lane += N)
                solve_lanes<Rows>(data, data.packs[i], lane, bias, clamped);
        return clamped;
    }

  public:
    static void start(const solve::JointStartData& data, std::uint32_t first, std::uint32_t last) {
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < end_of(data.packs[i]); lane += N)
                JointStarts<L>::start(data, data.packs[i], lane);
    }
    static void begin(const Data& data, std::uint32_t first, std::uint32_t last) {
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < end_of(data.packs[i]); lane += N)
                begin_lanes(data, data.packs[i], lane);
    }
    static void refresh(const Data& data, std::uint32_t first, std::uint32_t last) {
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < end_of(data.packs[i]); lane += N)
                refresh_lanes(data, data.packs[i], lane);
    }
    static void join(const Data& data, std::uint32_t first, std::uint32_t last) {
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; data.packs[i].axis_count != 0 && lane < end_of(data.packs[i]); lane += N)
                Axes::join(data.packs[i], data.axes, lane);
    }
    static void warm_start(const Data& data, std::uint32_t first, std::uint32_t last, bool sums) {
        by_rows(data, first, last, [&](auto rows, std::uint32_t from, std::uint32_t to) {
            warm_run<rows.value>(data, from, to, sums);
        });
    }
    static std::uint64_t solve(const Data& data, std::uint32_t first, std::uint32_t last, bool bias) {
        std::uint64_t clamped = 0;
        by_rows(data, first, last, [&](auto rows, std::uint32_t from, std::uint32_t to) {
            clamped += solve_run<rows.value>(data, from, to, bias);
        });
        return clamped;
    }
    static constexpr solve::JointKernel table() {
        return {start, TurnedLanes<L>::turn, begin, refresh, JointInverses<L>::invert,
                join,  warm_start,           solve};
    }
};

} // namespace lockstone::solve
