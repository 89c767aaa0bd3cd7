// Followed bodies, four side by side, written once over the lanes L; see solve/joints/followed_turn.h for the method
// and its reasons.
//
// Principal axes are columns a1 a2 a3, so K' = r3 + (r1 - r3) a1 a1^T + (r2 - r3) a2 a2^T; K'^-1 has the same form with
// the inverse radii. Turns of half a substep have 32 fraction bits and are within 1/4 rad, and momentum is that of |m|
// < 32 m/s. The kernel skips bodies with larger numbers.
//
// kernel.h includes this; the rules for its inclusion are there.
#pragma once

#include "solve/bodies/followed_body.h"
#include "solve/bodies/solver_body.h"
#include "solve/lanes/lane_fixed.h"

#include <cstdint>

namespace lockstone::solve {

template <class L> class FollowedBodies {
    static constexpr unsigned N = L::lanes;
    static_assert(N <= followed_lanes);
    static constexpr int unit_bits = 30, half_bits = followed_half_bits, fine_bits = followed_fine_bits,
                         change_bits = followed_change_bits;
    // index of each entry in xx, yy, zz, xy, xz, yz
    static constexpr int entry_at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    static constexpr std::int64_t half_max = std::int64_t{1} << (half_bits - 2),
                                  one = std::int64_t{1} << unit_bits;
    using V = typename L::V;
    using Pass = FollowPass;
    using Four = FollowedFour;

    // ---- numbers ----

    static V half_of(int bits) { return L::splat(std::int64_t{1} << (bits - 1)); }
    /// Correct where the result fits into 32 bits.
    template <int S> static V rounded(V sum) { return L::template shift_right<S>(L::add(sum, half_of(S))); }
    static V rounded_by(V sum, V drop) { // 1..62
        return L::shift_right_by(L::add(sum, L::template shift_right<1>(L::shift_left_by(L::splat(1), drop))),
                                 drop);
    }
    static V negated(V x) { return L::sub(L::splat(0), x); }
    static V within(V x, V most) {
        const V least = negated(most), low = L::select(L::greater64(x, most), most, x);
        return L::select(L::greater64(least, low), least, low);
    }
    static V not_within(V x, std::int64_t below) { // [-below, below)
        return L::either(L::greater64(x, L::splat(below - 1)), L::greater64(L::splat(-below), x));
    }
    static V load(const std::int32_t* p) { return L::load32(p); }
    static V load(const std::int64_t* p) { return L::load64(p); }
    template <std::size_t M, class T>
    static void load(const T (&from)[M][followed_lanes], unsigned lane, V (&out)[M]) {
        for (std::size_t i = 0; i < M; ++i) out[i] = load(&from[i][lane]);
    }
    template <std::size_t M>
    static void store(std::int32_t (&to)[M][followed_lanes], unsigned lane, const V (&x)[M]) {
        for (std::size_t i = 0; i < M; ++i) L::store32(&to[i][lane], x[i]);
    }
    template <std::size_t M>
    static void store(std::int64_t (&to)[M][followed_lanes], unsigned lane, const V (&x)[M]) {
        for (std::size_t i = 0; i < M; ++i) L::store64(&to[i][lane], x[i]);
    }
    static V sum3(V a, V b, V c) { return L::add(L::add(a, b), c); }
    static V dot(const V (&a)[3], const V (&b)[3]) {
        return sum3(L::mul(a[0], b[0]), L::mul(a[1], b[1]), L::mul(a[2], b[2]));
    }
    /// m x of a symmetric matrix m, without rounding.
    static void multiply(const V (&m)[6], const V (&x)[3], V (&out)[3]) {
        for (int i = 0; i < 3; ++i)
            out[i] = sum3(L::mul(m[entry_at[i][0]], x[0]), L::mul(m[entry_at[i][1]], x[1]),
                          L::mul(m[entry_at[i][2]], x[2]));
    }

    struct Bodies {
        SolverBody* at[N];
        V motion[6]; ///< v and u
    };
    static void gather(const Pass& pass, const Four& four, unsigned lane, Bodies& b) {
        for (unsigned i = 0; i < N; ++i) b.at[i] = &pass.bodies[four.row[lane + i]];
        L::gather6(b.at, b.motion);
    }
    template <class Visit>
    static void for_each(const Pass& pass, std::uint32_t first, std::uint32_t last, Visit&& visit) {
        for (std::uint32_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < followed_lanes; lane += N)
                visit(pass.fours[i], pass.turns + i * followed_lanes + lane, lane);
    }
    static void mark_left(Four& four, unsigned lane, V mask) {
        const unsigned all = (1u << N) - 1;
        four.left = (four.left & ~(all << lane)) | (L::lanes_of(mask) << lane);
    }
    static V left_before(const Four& four, unsigned lane) {
        std::int64_t mask[N];
        for (unsigned i = 0; i < N; ++i) mask[i] = -static_cast<std::int64_t>((four.left >> (lane + i)) & 1u);
        return L::from_lanes(mask);
    }

    // ---- rotations ----

    /// a b of unit quaternions. Brings |a b| back to one, which roundings change.
    static void multiply(const V (&a)[4], const V (&b)[4], V (&out)[4]) {
        constexpr int extra = 15;
        const auto p = [&](int i, int j) { return L::mul(a[i], b[j]); };
        const V sums[4] = {L::sub(sum3(p(3, 0), p(0, 3), p(1, 2)), p(2, 1)),
                           L::sub(sum3(p(3, 1), p(1, 3), p(2, 0)), p(0, 2)),
                           L::sub(sum3(p(3, 2), p(0, 1), p(2, 3)), p(1, 0)),
                           L::sub(p(3, 3), sum3(p(0, 0), p(1, 1), p(2, 2)))};
        V long_one[4], size = L::splat(0);
        for (int i = 0; i < 4; ++i) {
            long_one[i] = L::template shift_right_signed<extra>(sums[i]);
            const V rough = rounded<unit_bits - extra>(long_one[i]);
            size = L::add(size, L::mul(rough, rough));
        }
        // (1 - |q|^2) / 2
        const V more =
            L::template shift_right_signed<unit_bits + 1>(L::sub(L::splat(std::int64_t{1} << 60), size));
        for (int i = 0; i < 4; ++i) {
            const V by = L::template shift_right_signed<unit_bits - extra>(
                L::mul(L::template shift_right<extra>(long_one[i]), more));
            out[i] = rounded<unit_bits - extra>(L::add(long_one[i], by));
        }
    }
    /// The matrix of a unit quaternion, by rows.
    static void matrix_of(const V (&q)[4], V (&m)[9]) {
        const auto twice = [](V sum) { return rounded<unit_bits - 1>(sum); };
        const auto p = [&](int i, int j) { return L::mul(q[i], q[j]); };
        const V xx = p(0, 0), yy = p(1, 1), zz = p(2, 2), whole = L::splat(one);
        m[0] = L::sub(whole, twice(L::add(yy, zz))), m[1] = twice(L::sub(p(0, 1), p(3, 2)));
        m[2] = twice(L::add(p(0, 2), p(3, 1))), m[3] = twice(L::add(p(0, 1), p(3, 2)));
        m[4] = L::sub(whole, twice(L::add(xx, zz))), m[5] = twice(L::sub(p(1, 2), p(3, 0)));
        m[6] = twice(L::sub(p(0, 2), p(3, 1))), m[7] = twice(L::add(p(1, 2), p(3, 0)));
        m[8] = L::sub(whole, twice(L::add(xx, yy)));
    }
    /// exp(phi) by Rodrigues' formula: x + sine (phi x x) + versine (phi x (phi x x)), for |phi| components up to 1/4.
    /// The error of the series is below 2^-27 |phi|.
    struct SmallTurn {
        V phi[3];                ///< half_bits
        V square, sine, versine; ///< |phi|^2, sin |phi| / |phi| and (1 - cos |phi|) / |phi|^2, Unit

        explicit SmallTurn(const V (&half)[3]) : phi{half[0], half[1], half[2]} {
            square = L::template shift_right<2 * half_bits - unit_bits>(dot(phi, phi));
            const auto series = [this](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) {
                return less(a, less(b, less(c, L::splat(d))));
            };
            sine = series(one, one / 6, one / 120, one / 5040);
            versine = series(one / 2, one / 24, one / 720, one / 40320);
        }
        V less(std::int64_t a, V x) const {
            return L::sub(L::splat(a), L::template shift_right<unit_bits>(L::mul(x, square)));
        }
        void cross(const V (&x)[3], V (&out)[3]) const {
            for (int i = 0; i < 3; ++i) {
                const int j = (i + 1) % 3, k = (i + 2) % 3;
                out[i] = rounded<half_bits>(L::sub(L::mul(phi[j], x[k]), L::mul(phi[k], x[j])));
            }
        }
        /// x becomes exp(phi) x, or exp(-phi) x with Back; |x| is below 2^31.
        template <bool Back> void turn(V (&x)[3]) const {
            V once[3], twice[3];
            cross(x, once), cross(once, twice);
            for (int i = 0; i < 3; ++i) {
                const V along = L::mul(sine, once[i]), inwards = L::mul(versine, twice[i]);
                x[i] =
                    L::add(x[i], rounded<unit_bits>(Back ? L::sub(inwards, along) : L::add(inwards, along)));
            }
        }
    };

    // ---- turns ----

    /// The turn of half a substep by K^-1 u, half_bits. Returns the mask of the lanes that are skipped.
    static V half_turn(const Pass& pass, const Four& four, unsigned lane, const V* u, V (&half)[3]) {
        V left = L::load64(&four.alone[lane]), fine[3], inverse[6], sums[3];
        for (int i = 0; i < 3; ++i) {
            left = L::either(left, not_within(u[i], std::int64_t{32} << accumulator_bits));
            fine[i] = rounded<accumulator_bits - fine_bits>(u[i]);
        }
        load(four.inverse, lane, inverse), multiply(inverse, fine, sums);
        const V time = L::splat(pass.half_time), drop = L::load64(&four.turn_drop[lane]);
        for (int i = 0; i < 3; ++i) {
            half[i] = rounded_by(L::mul(rounded<31>(sums[i]), time), drop);
            left = L::either(left, not_within(half[i], half_max));
        }
        return left;
    }
    /// The two outer products in r3 + (r1 - r3) a1 a1^T + (r2 - r3) a2 a2^T
    struct Outer {
        V first[6], second[6];
        explicit Outer(const V (&axes)[3][3]) {
            for (int i = 0; i < 3; ++i)
                for (int j = i; j < 3; ++j) {
                    first[entry_at[i][j]] = rounded<unit_bits>(L::mul(axes[0][i], axes[0][j]));
                    second[entry_at[i][j]] = rounded<unit_bits>(L::mul(axes[1][i], axes[1][j]));
                }
        }
        void diagonal(const std::int32_t (&radii)[3][followed_lanes], unsigned lane, V (&out)[6]) const {
            V r[3];
            load(radii, lane, r);
            for (int e = 0; e < 6; ++e) {
                out[e] = rounded<unit_bits>(L::add(L::mul(r[1], first[e]), L::mul(r[2], second[e])));
                if (e < 3) out[e] = L::add(out[e], r[0]);
            }
        }
    };
    /// a b of symmetric matrices with mantissas up to 2^30. The product of a row of a with a column of b has to be at
    /// most 2^60.
    static void multiply(const V (&a)[6], const V (&b)[6], V (&out)[9]) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                V sum = L::mul(a[entry_at[i][0]], b[entry_at[0][j]]);
                for (int k = 1; k < 3; ++k) sum = L::add(sum, L::mul(a[entry_at[i][k]], b[entry_at[k][j]]));
                out[3 * i + j] = rounded<30>(sum);
            }
    }
    /// From world axes to the principal axes, and back.
    static void inwards(const V (&axes)[3][3], const V (&x)[3], V (&out)[3]) {
        for (int k = 0; k < 3; ++k) out[k] = rounded<unit_bits>(dot(axes[k], x));
    }
    static void outwards(const V (&axes)[3][3], const V (&x)[3], V (&out)[3]) {
        for (int i = 0; i < 3; ++i)
            out[i] = rounded<unit_bits>(
                sum3(L::mul(axes[0][i], x[0]), L::mul(axes[1][i], x[1]), L::mul(axes[2][i], x[2])));
    }
    /// The present principal axes.
    static void turn_axes(const Four& four, unsigned lane, const V (&m)[9], V (&axes)[3][3]) {
        for (int k = 0; k < 3; ++k) {
            V start[3];
            load(four.axes[k], lane, start);
            for (int i = 0; i < 3; ++i)
                axes[k][i] =
                    rounded<unit_bits>(sum3(L::mul(m[3 * i], start[0]), L::mul(m[3 * i + 1], start[1]),
                                            L::mul(m[3 * i + 2], start[2])));
        }
    }
    /// Angular momentum per mass along the principal axes, for m with accumulator_bits. Returns the mask of the lanes
    /// that are skipped.
    static V momentum_of(const Four& four, unsigned lane, const V (&axes)[3][3], const V (&own)[3],
                         V (&out)[3]) {
        V left = L::load64(&four.alone[lane]), fine[3], k[6], sums[3];
        for (int i = 0; i < 3; ++i) {
            left = L::either(left, not_within(own[i], std::int64_t{32} << accumulator_bits));
            fine[i] = rounded<accumulator_bits - fine_bits>(own[i]);
        }
        load(four.k, lane, k), multiply(k, fine, sums);
        for (V& sum : sums) sum = rounded<31>(sum);
        inwards(axes, sums, out);
        return left;
    }
    /// The turn of half a substep by a momentum, both along the principal axes. Adds skipped lanes to `left`.
    static void by_radii(const Four& four, unsigned lane, V (&x)[3], V& left) {
        for (int i = 0; i < 3; ++i) {
            x[i] = rounded_by(L::mul(x[i], L::load32(&four.half_way[i][lane])),
                              L::load64(&four.half_way_drop[i][lane]));
            left = L::either(left, not_within(x[i], half_max));
        }
    }
    /// Rounds of the midpoint rule for g: two more than the explicit rule has. With these, the remaining error takes
    /// energy from a body that spins fast; with one more or one less, it adds energy.
    static constexpr int precession_rounds = 3;

    /// `half`: in, the turn by u; out, the turn by the body's own momentum; in world axes.
    static V precess(const Four& four, unsigned lane, const V (&axes)[3][3], const V (&own)[3],
                     V (&half)[3]) {
        V momentum[3], x[3];
        V left = momentum_of(four, lane, axes, own, momentum);
        V square = L::splat(0);
        for (const V& along : momentum) {
            const V halved = L::template shift_right<1>(along);
            square = L::add(square, L::mul(halved, halved));
        }
        left = L::either(left, L::greater64(square, L::load64(&four.momentum_most[lane])));
        inwards(axes, half, x);
        for (int round = 0; round < precession_rounds; ++round) {
            const SmallTurn t(x);
            for (int i = 0; i < 3; ++i) x[i] = momentum[i];
            t.template turn<true>(x), by_radii(four, lane, x, left), t.template turn<false>(x);
        }
        outwards(axes, x, half);
        return left;
    }
    static V speed_of(const Pass& pass, V half) { // w in Speed format, within 2048 rad/s
        return L::template shift_right<half_bits - 19>(
            within(L::mul(half, L::splat(pass.half_rate)), L::splat(std::int64_t{2048} << half_bits)));
    }
    /// K w with accumulator_bits, from a turn of half a substep.
    static void u_of(const Pass& pass, const Four& four, unsigned lane, const V (&half)[3], V (&u)[3]) {
        V k[6];
        load(four.k, lane, k), multiply(k, half, u);
        for (V& x : u)
            x = L::shift_left_by(
                within(L::mul(rounded<31>(x), L::splat(pass.half_rate)), L::load64(&four.speed_most[lane])),
                L::load64(&four.speed_raise[lane]));
    }
    /// Stores TurnedBody, the rotation and the present K^-1 in FollowedTurn, from which other code reads them body by
    /// body.
    static void give(const Four& four, FollowedTurn* turns, unsigned lane, const V (&m)[9],
                     const V (&spin)[3], const V (&rotation)[4], const V (&inverse)[6]) {
        std::int32_t* to[N];
        const auto put = [&](auto&& place, V a, V b, V c, V d) {
            for (unsigned i = 0; i < N; ++i) to[i] = place(turns[i]);
            const V row[4] = {a, b, c, d};
            L::store_quads(to, row);
        };
        put([](FollowedTurn& t) { return &t.turned[0]; }, m[0], m[1], m[2], m[3]);
        put([](FollowedTurn& t) { return &t.turned[4]; }, m[4], m[5], m[6], m[7]);
        put([](FollowedTurn& t) { return &t.turned[8]; }, m[8], spin[0], spin[1], spin[2]);
        put([](FollowedTurn& t) { return &t.rotation.x.raw; }, rotation[0], rotation[1], rotation[2],
            rotation[3]);
        const auto k = [](FollowedTurn& t) { return &t.now.inv_mantissa.xx; };
        put(k, inverse[0], inverse[1], inverse[2], inverse[3]);
        put([&](FollowedTurn& t) { return k(t) + 4; }, inverse[4], inverse[5], load(&four.inverse_bits[lane]),
            load(&four.linear_mask[lane]));
    }

    // ---- u of rows ----

    static void shortened(const V* x, V (&out)[3]) {
        for (int i = 0; i < 3; ++i)
            out[i] = rounded_within<change_bits>(LaneSum<L, accumulator_bits>{x[i]}, INT32_MAX).lanes();
    }
    /// M x or M^T x with accumulator_bits, within 4096 m/s; x is a result of shortened().
    template <bool Transposed>
    static void times(const Four& four, const std::int32_t (&m)[9][followed_lanes], unsigned lane,
                      const V (&x)[3], V (&out)[3]) {
        const V most = L::load64(&four.change_most[lane]), raise = L::load64(&four.change_raise[lane]),
                drop = L::load64(&four.change_drop[lane]);
        const V half = L::template shift_right<1>(L::shift_left_by(L::splat(1), drop));
        for (int i = 0; i < 3; ++i) {
            const auto entry = [&](int k) { return load(&m[Transposed ? 3 * k + i : 3 * i + k][lane]); };
            const V sum = sum3(L::mul(entry(0), x[0]), L::mul(entry(1), x[1]), L::mul(entry(2), x[2]));
            out[i] = L::shift_right_by(L::add(L::shift_left_by(within(sum, most), raise), half), drop);
        }
    }
    /// Adds the part of a change of u that is no momentum to g.
    static void add_precession(Four& four, unsigned lane, const V (&u)[3], const V (&momentum)[3]) {
        const V follows = L::without(L::load64(&four.held[lane]), L::load64(&four.stiff[lane]));
        for (int i = 0; i < 3; ++i) {
            const V sum =
                L::add(L::load64(&four.precession[i][lane]), L::both(L::sub(u[i], momentum[i]), follows));
            L::store64(&four.precession[i][lane], within(sum, L::splat(precession_most)));
        }
    }

  public:
    static void start(const Pass& pass, std::uint32_t first, std::uint32_t last) {
        for_each(pass, first, last, [&](Four& four, FollowedTurn*, unsigned lane) {
            V q[4], principal[4], all[4], m[9], axes[3][3], half[3];
            load(four.start, lane, q), load(four.principal, lane, principal);
            multiply(q, principal, all), matrix_of(all, m);
            for (int k = 0; k < 3; ++k)
                for (int i = 0; i < 3; ++i)
                    axes[k][i] = m[3 * i + k], L::store32(&four.axes[k][i][lane], axes[k][i]);
            const Outer outer(axes);
            V k[6], inverse[6];
            outer.diagonal(four.radii, lane, k), outer.diagonal(four.inverses, lane, inverse);
            store(four.k, lane, k), store(four.inverse, lane, inverse);
            for (int i = 0; i < 4; ++i) L::store32(&four.turn[i][lane], L::splat(i == 3 ? one : 0));
            Bodies b;
            gather(pass, four, lane, b);
            mark_left(four, lane, half_turn(pass, four, lane, b.motion + 3, half));
            store(four.half, lane, half);
        });
    }
    static void turn(const Pass& pass, std::uint32_t first, std::uint32_t last) {
        for_each(pass, first, last, [&](Four& four, FollowedTurn*, unsigned lane) {
            Bodies b;
            gather(pass, four, lane, b);
            V half[3], q[4], next[4];
            // A body that answer() skipped is turned outside of the kernel, unless it is stiff.
            const V alone = L::without(left_before(four, lane), L::load64(&four.stiff[lane]));
            const V left = L::either(alone, half_turn(pass, four, lane, b.motion + 3, half));
            store(four.half, lane, half), load(four.turn, lane, q);
            const SmallTurn t(half);
            const V cosine = t.less(one, t.versine);
            const V by[4] = {rounded<half_bits>(L::mul(t.sine, half[0])),
                             rounded<half_bits>(L::mul(t.sine, half[1])),
                             rounded<half_bits>(L::mul(t.sine, half[2])), cosine};
            multiply(by, q, next);
            for (int i = 0; i < 4; ++i) L::store32(&four.turn[i][lane], L::select(left, q[i], next[i]));
            mark_left(four, lane, left);
        });
    }
    static void answer(const Pass& pass, std::uint32_t first, std::uint32_t last) {
        for_each(pass, first, last, [&](Four& four, FollowedTurn* turns, unsigned lane) {
            V q[4], from[4], rotation[4], m[9], axes[3][3], now[6], now_inverse[6], start[6], product[9];
            load(four.turn, lane, q), load(four.start, lane, from);
            multiply(q, from, rotation), matrix_of(q, m), turn_axes(four, lane, m, axes);
            const Outer outer(axes);
            outer.diagonal(four.radii, lane, now), outer.diagonal(four.inverses, lane, now_inverse);
            load(four.inverse, lane, start), multiply(now, start, product), store(four.to_now, lane, product);
            load(four.k, lane, start), multiply(start, now_inverse, product),
                store(four.from_now, lane, product);

            Bodies b;
            gather(pass, four, lane, b);
            V own[3], half[3], u[3], spin[3];
            load(four.half, lane, half);
            constexpr std::int64_t own_max = std::int64_t{2048} << accumulator_bits;
            for (int i = 0; i < 3; ++i)
                own[i] =
                    within(L::sub(b.motion[3 + i], L::load64(&four.precession[i][lane])), L::splat(own_max));
            const V left = L::either(left_before(four, lane), precess(four, lane, axes, own, half));
            const V stays = L::either(left, L::load64(&four.stiff[lane]));
            u_of(pass, four, lane, half, u);
            for (int i = 0; i < 3; ++i) {
                const V g = within(L::sub(u[i], own[i]), L::splat(precession_most));
                L::store64(&four.precession[i][lane],
                           L::select(stays, L::load64(&four.precession[i][lane]), g));
                b.motion[3 + i] = L::select(stays, b.motion[3 + i], u[i]), spin[i] = speed_of(pass, half[i]);
            }
            L::scatter6(b.at, b.motion);
            give(four, turns, lane, m, spin, rotation, now_inverse);
            mark_left(four, lane, left);
        });
    }
    static void turn_in(const Pass& pass, std::uint32_t first, std::uint32_t last) {
        for_each(pass, first, last, [&](Four& four, FollowedTurn*, unsigned lane) {
            if (!four.any_held) return;
            Bodies b;
            gather(pass, four, lane, b);
            V x[3], inside[3];
            shortened(b.motion + 3, x), times<false>(four, four.to_now, lane, x, inside);
            const V held = L::load64(&four.held[lane]), most = L::splat(pass.tip_most);
            for (int i = 0; i < 3; ++i) {
                V& u = b.motion[3 + i];
                L::store64(&four.u_outside[i][lane], u);
                u = L::select(held, within(inside[i], most), u);
                L::store64(&four.u_inside[i][lane], u);
            }
            L::scatter6(b.at, b.motion);
        });
    }
    static void turn_out(const Pass& pass, std::uint32_t first, std::uint32_t last) {
        for_each(pass, first, last, [&](Four& four, FollowedTurn*, unsigned lane) {
            if (!four.any_held) return;
            Bodies b;
            gather(pass, four, lane, b);
            V change[3], x[3], faster[3], momentum[3];
            for (int i = 0; i < 3; ++i)
                change[i] = L::sub(b.motion[3 + i], L::load64(&four.u_inside[i][lane]));
            shortened(change, x);
            times<false>(four, four.from_now, lane, x, faster);
            times<true>(four, four.to_now, lane, x, momentum); // K^-1 K' is the transpose of K' K^-1
            const V held = L::load64(&four.held[lane]),
                    most = L::splat(std::int64_t{2048} << accumulator_bits);
            for (int i = 0; i < 3; ++i) {
                V& u = b.motion[3 + i];
                u = L::select(held, within(L::add(L::load64(&four.u_outside[i][lane]), faster[i]), most), u);
            }
            add_precession(four, lane, faster, momentum);
            L::scatter6(b.at, b.motion);
        });
    }
    static void note_u(const Pass& pass, std::uint32_t first, std::uint32_t last) {
        for_each(pass, first, last, [&](Four& four, FollowedTurn*, unsigned lane) {
            Bodies b;
            gather(pass, four, lane, b);
            for (int i = 0; i < 3; ++i) L::store64(&four.u_outside[i][lane], b.motion[3 + i]);
        });
    }
    static void keep_velocity(const Pass& pass, std::uint32_t first, std::uint32_t last) {
        for_each(pass, first, last, [&](Four& four, FollowedTurn*, unsigned lane) {
            if (!four.any_held) return;
            Bodies b;
            gather(pass, four, lane, b);
            V change[3], x[3], y[3], momentum[3], any = L::splat(0);
            for (int i = 0; i < 3; ++i) {
                change[i] = L::sub(b.motion[3 + i], L::load64(&four.u_outside[i][lane]));
                any = L::either(any, L::either(change[i], negated(change[i])));
            }
            // Takes the sign of the nonzero values: a mask has to have all bits set, since each instruction set reads
            // another one of them.
            if (L::lanes_of(L::greater64(L::splat(0), any)) == 0) return;
            shortened(change, x), times<false>(four, four.to_now, lane, x, y);
            shortened(y, x), times<true>(four, four.to_now, lane, x, momentum);
            add_precession(four, lane, change, momentum);
        });
    }
    static void end(const Pass& pass, std::uint32_t first, std::uint32_t last) {
        for_each(pass, first, last, [&](Four& four, FollowedTurn* turns, unsigned lane) {
            Bodies b;
            gather(pass, four, lane, b);
            V q[4], m[9], axes[3][3], own[3], x[3], half[3], stiff_half[3];
            load(four.turn, lane, q), matrix_of(q, m), turn_axes(four, lane, m, axes);
            for (int i = 0; i < 3; ++i)
                own[i] = L::sub(b.motion[3 + i], L::load64(&four.precession[i][lane]));
            V left = momentum_of(four, lane, axes, own, x);
            by_radii(four, lane, x, left), outwards(axes, x, half);
            const V stiff = L::load64(&four.stiff[lane]);
            left = L::select(stiff, half_turn(pass, four, lane, b.motion + 3, stiff_half), left);
            std::int32_t spin[3][N];
            for (int i = 0; i < 3; ++i)
                L::store32(spin[i], speed_of(pass, L::select(stiff, stiff_half[i], half[i])));
            for (unsigned i = 0; i < N; ++i)
                for (int axis = 0; axis < 3; ++axis) turns[i].spin[axis].raw = spin[axis][i];
            mark_left(four, lane, left);
        });
    }
    static constexpr FollowKernel table() {
        return {start, turn, answer, turn_in, turn_out, note_u, keep_velocity, end};
    }
};

} // namespace lockstone::solve
