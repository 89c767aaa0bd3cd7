// Start values of the rows of points when a tick begins, written once for all lane widths L: levers, K^-1, the scale
// 2^-e of each joint and dependent data. See solve/joints/pack/joint_pack.h for the formats.
//
//   e: the least exponent, at least 0, with which the entries of K^-1 [r], times 1.25, stay below 2
//
// Only kernel.h includes this file.
#pragma once

#include "solve/joints/pack/joint_pack.h"
#include "solve/lanes/lane_fixed.h"
#include "solve/lanes/lane_rotation.h"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace lockstone::solve {

template <class L> class JointStarts {
    static constexpr unsigned N = L::lanes;
    static constexpr int row_bits = 28, speed_bits = 19, unit_bits = 30, gap_bits = 27, real_bits = 32,
                         length_bits = 24;
    static constexpr int inverse_at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    using Pack = solve::JointPack;
    using Side = solve::PackSide;
    using Data = solve::JointStartData;
    using V = typename L::V;

    static int bit_length(std::int64_t x) {
        return x == 0 ? 0 : 64 - std::countl_zero(static_cast<std::uint64_t>(x));
    }
    static V size_of(V x) { return L::select(L::greater64(L::splat(0), x), L::sub(L::splat(0), x), x); }
    static V between(V x, V least, V most) {
        x = L::select(L::greater64(x, most), most, x);
        return L::select(L::greater64(least, x), least, x);
    }
    /// x / 2^shift, rounded. A negative shift multiplies. Clamped to -most .. most.
    static std::int32_t shifted_within(std::int64_t x, int shift, std::int64_t most) {
        if (shift > 0) {
            x = shift > 62 ? 0 : (x >> shift) + ((x >> (shift - 1)) & 1);
        } else {
            x = x < -most ? -most : x > most ? most : x; // shifting up makes it no smaller
            x *= std::int64_t{1} << (shift < -31 ? 31 : -shift);
        }
        return static_cast<std::int32_t>(x < -most ? -most : x > most ? most : x);
    }

    using Axes = V[3][3]; ///< of bodies, by columns
    [[gnu::always_inline]] static void find_axes(const Data& data, const Side& side, unsigned lane,
                                                 Axes& axes) {
        const std::int32_t* rotations[N];
        for (unsigned i = 0; i < N; ++i)
            rotations[i] = reinterpret_cast<const std::int32_t*>(data.rotations + side.held[lane + i]);
        V q[4];
        L::quads(rotations, q), rotation_of<L>(q, axes); // rotations are unit quaternions
    }
    /// Component i of a vector in world axes, with extra fraction bits: 30 bits times 32, three times.
    static V turned(const Axes& axes, const V (&local)[3], int i) {
        return L::add(L::add(L::mul(axes[0][i], local[0]), L::mul(axes[1][i], local[1])),
                      L::mul(axes[2][i], local[2]));
    }
    /// A lever in world axes. Its components are within 2^28 if the lever is within 128 m. In body axes it has
    /// length_bits.
    [[gnu::always_inline]] static void turn_lever(const Axes& axes, Side& side, unsigned lane,
                                                  V (&lever)[3]) {
        constexpr int extra = unit_bits + length_bits - real_bits, room = 28, least_bits = 22;
        V local[3], any = L::splat(0);
        for (int i = 0; i < 3; ++i) local[i] = L::load32(&side.own_lever[i][lane]);
        const V half = L::splat(std::int64_t{1} << (extra - 1));
        for (int i = 0; i < 3; ++i) {
            lever[i] = L::template shift_right_signed<extra>(L::add(turned(axes, local, i), half));
            any = L::either(any, size_of(lever[i]));
        }
        std::int64_t drop[N];
        L::store64(drop, any);
        for (unsigned i = 0; i < N; ++i) {
            const int beyond = bit_length(drop[i]) - room;
            drop[i] = beyond < 0 ? 0 : beyond > real_bits - least_bits ? real_bits - least_bits : beyond;
            side.lever_bits[lane + i] = real_bits - drop[i];
        }
        const V by = L::from_lanes(drop), up = L::template shift_right<1>(L::shift_left_by(L::splat(1), by));
        const V most = L::splat((std::int64_t{1} << (room + 1)) - 1), least = L::sub(L::splat(0), most);
        for (int i = 0; i < 3; ++i) {
            lever[i] = between(L::shift_right_by(L::add(lever[i], up), by), least, most);
            L::store32(&side.lever[i][lane], lever[i]);
        }
    }
    /// Computes lever, K^-1 and their shifts. Raises `exponent` where this side needs a larger one.
    [[gnu::always_inline]] static void start_side(const Data& data, Side& side, unsigned lane,
                                                  const Axes& axes, std::int64_t (&exponent)[N]) {
        V lever[3], k[8];
        turn_lever(axes, side, lane, lever);
        const std::int32_t *front[N], *back[N];
        for (unsigned i = 0; i < N; ++i) {
            front[i] = &data.steps[side.place[lane + i] / sizeof(solve::SolverBody)].inv_mantissa.xx;
            back[i] = front[i] + 4;
        }
        L::quads(front, k), L::quads(back, k + 4);
        for (int i = 0; i < 6; ++i) L::store32(&side.inverse[i][lane], k[i]);
        // A side that does not move contains only zeros.
        L::store64(&side.spin_shift[lane], extended<L>(k[6]));
        V most = L::splat(0);
        for (int row = 0; row < 3; ++row) {
            const int i = (row + 1) % 3, j = (row + 2) % 3;
            for (const auto& at : inverse_at) { // 30 bits times 29, twice
                const V x = size_of(L::sub(L::mul(k[at[i]], lever[j]), L::mul(k[at[j]], lever[i])));
                most = L::select(L::greater64(x, most), x, most);
            }
        }
        std::int64_t sizes[N];
        L::store64(sizes, L::add(most, L::template shift_right<2>(most)));
        for (unsigned i = 0; i < N; ++i) {
            const std::int64_t bits = side.spin_shift[lane + i] + side.lever_bits[lane + i];
            const std::int64_t e = bit_length(sizes[i]) - bits - 1;
            if (sizes[i] != 0 && e > exponent[i]) exponent[i] = e;
        }
    }
    /// As above, in lanes.
    static V shifted_within(V x, V shift, std::int64_t most) {
        const V one = L::splat(1),
                beyond = L::either(L::greater64(one, shift), L::greater64(shift, L::splat(62)));
        if (L::lanes_of(beyond) != 0) [[unlikely]] {
            std::int64_t v[N], by[N];
            L::store64(v, x), L::store64(by, shift);
            for (unsigned i = 0; i < N; ++i) v[i] = shifted_within(v[i], static_cast<int>(by[i]), most);
            return L::from_lanes(v);
        }
        x = L::add(L::shift_right_by(x, L::sub(shift, one)), one);
        return between(L::template shift_right_signed<1>(x), L::splat(-most), L::splat(most));
    }
    static V at_most(V x, std::int64_t most) {
        return L::select(L::greater64(x, L::splat(most)), L::splat(most), x);
    }
    static void set_arm_shift(Side& side, unsigned lane, V e) {
        const V one = L::splat(1),
                bits = L::add(L::load64(&side.spin_shift[lane]), L::load64(&side.lever_bits[lane]));
        const V shift = between(L::sub(L::add(bits, e), L::splat(row_bits)), one, L::splat(62));
        L::store64(&side.arm_shift[lane], shift);
        L::store64(&side.arm_half[lane], L::shift_left_by(one, L::sub(shift, one)));
    }
    /// Scales the impulses of the last tick, which are in the sums as Real, and clears the sums.
    static void scale_impulse(std::int32_t* impulse, std::int64_t* sum, V e) {
        const V shift = L::sub(L::splat(real_bits - speed_bits), e);
        L::store32(impulse, shifted_within(L::load64(sum), shift, solve::joint_impulse_max));
        L::store64(sum, L::splat(0));
    }
    static V scaled_push(const Data& data, V e) {
        return shifted_within(L::splat(data.push_max), L::add(e, L::splat(real_bits - speed_bits)),
                              solve::joint_speed_max);
    }
    /// Writes e, which is at least 0, and all data that depends on it.
    [[gnu::always_inline]] static void set_exponents(const Data& data, Pack& c, unsigned lane, V e) {
        const V whole = L::shift_left_by(L::splat(1), L::sub(L::splat(row_bits), at_most(e, row_bits)));
        const V one = L::select(L::greater64(e, L::splat(row_bits)), L::splat(0), whole);
        L::store32(&c.exponent[lane], e), L::store32(&c.one[lane], one);
        for (Side* side : {&c.a, &c.b}) {
            const V pull = L::mul(one, L::load32(&side->share[lane]));
            L::store32(&side->pull[lane], L::template shift_right<unit_bits>(pull));
            set_arm_shift(*side, lane, e);
        }
        L::store32(&c.push_max[lane], scaled_push(data, e));
        L::store64(&c.near_shift[lane], at_most(L::add(e, L::splat(real_bits - gap_bits)), 62));
        L::store64(&c.ahead_shift[lane], at_most(L::add(e, L::splat(unit_bits + 1)), 62));
        for (int r = 0; r < 3; ++r) scale_impulse(&c.impulse[r][lane], &c.sum[r][lane], e);
    }
    /// Scales the rows of hinges. No entry of K^-1 axis exceeds the largest inverse radius, however the body is
    /// turned.
    static void scale_hinges(const Data& data, const Pack& c, solve::TurnPack& t, unsigned lane) {
        std::int64_t exponents[N];
        const auto bits = [&](const Side& side, unsigned at) {
            return side.turned[at] == 0
                       ? 0
                       : reinterpret_cast<const std::int32_t*>(data.rotations + side.held[at])[4];
        };
        for (unsigned i = 0; i < N; ++i) {
            const std::int32_t a = bits(c.a, lane + i), b = bits(c.b, lane + i), most = a > b ? a : b;
            exponents[i] = most == 0 ? 0 : most - real_bits - 1;
        }
        const V e = L::from_lanes(exponents), one = L::splat(1), far = L::splat(62);
        L::store32(&t.exponent[lane], e), L::store32(&t.push_max[lane], scaled_push(data, e));
        L::store64(&t.shift_a[lane], between(L::add(L::load64(&c.a.spin_shift[lane]), e), one, far));
        L::store64(&t.shift_b[lane], between(L::add(L::load64(&c.b.spin_shift[lane]), e), one, far));
        L::store64(&t.bias_shift[lane], L::add(e, L::splat(unit_bits + solve::joint_rate_bits - speed_bits)));
        for (int r = 0; r < 2; ++r) scale_impulse(&t.impulse[r][lane], &t.sum[r][lane], e);
    }

    using Frame = std::int32_t[2][3][solve::pack_lanes];
    /// Turns two axes of a frame to world axes.
    static void turn_frame(const Axes& axes, const Frame& local, const std::int32_t* world, unsigned lane,
                           Frame& frame, V (&out)[2][3]) {
        const V stands = L::load32(world), half = L::splat(std::int64_t{1} << (unit_bits - 1));
        for (int k = 0; k < 2; ++k) {
            const V own[3] = {L::load32(&local[k][0][lane]), L::load32(&local[k][1][lane]),
                              L::load32(&local[k][2][lane])};
            for (int i = 0; i < 3; ++i) {
                const V sum = L::add(turned(axes, own, i), half);
                out[k][i] = L::select(stands, own[i], L::template shift_right<unit_bits>(sum));
                L::store32(&frame[k][i][lane], out[k][i]);
            }
        }
    }
    /// Turns the frames of a hinge. Sets TurnPack::apart if its axes are further apart than 41 degrees: other rows
    /// are used then (joint_parts.h).
    static void start_hinges(solve::TurnPack& t, unsigned lane, const Axes& of_a, const Axes& of_b) {
        V a[2][3], b[2][3], along = L::splat(0);
        turn_frame(of_a, t.local_a, &t.world_a[lane], lane, t.frame_a, a);
        turn_frame(of_b, t.local_b, &t.world_b[lane], lane, t.frame_b, b);
        for (int i = 0; i < 3; ++i) { // x of A is y x z
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const V x = L::sub(L::mul(a[0][j], a[1][k]), L::mul(a[0][k], a[1][j]));
            along = L::add(along, L::mul(L::template shift_right<unit_bits>(x), b[0][i]));
        }
        const unsigned near =
            L::lanes_of(L::greater64(along, L::splat(std::int64_t{3} << (2 * unit_bits - 2))));
        for (unsigned i = 0; i < N; ++i) t.apart[lane + i] = ((near >> i) & 1u) == 0;
    }

  public:
    [[gnu::always_inline]] static void start(const Data& data, Pack& c, unsigned lane) {
        std::int64_t e[N] = {};
        Axes a, b;
        find_axes(data, c.a, lane, a), find_axes(data, c.b, lane, b);
        start_side(data, c.a, lane, a, e), start_side(data, c.b, lane, b, e);
        set_exponents(data, c, lane, L::from_lanes(e));
        if (!c.hinges) return;
        scale_hinges(data, c, data.turns[c.turn], lane);
        start_hinges(data.turns[c.turn], lane, a, b);
    }
};

} // namespace lockstone::solve
