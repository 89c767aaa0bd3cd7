// Turns of bodies with joints since the tick began, written once for all lane widths L. Each body is computed once
// for all its joints. See solve/joints/pack/joint_pack.h for the formats and the series.
//
// Only kernel.h includes this file.
#pragma once

#include "solve/joints/pack/joint_pack.h"
#include "solve/lanes/lane_fixed.h"

#include <cstddef>
#include <cstdint>

namespace lockstone::solve {

template <class L> class TurnedLanes {
    static constexpr unsigned N = L::lanes;
    static constexpr int accumulator_bits = 47, speed_bits = 19, unit_bits = 30;
    static constexpr int inverse_at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    using Held = solve::HeldBodies;
    using Data = solve::JointPassData;
    using V = typename L::V;
    template <class T> using Lanes = T[solve::pack_lanes];

    static V between(V x, V least, V most) {
        x = L::select(L::greater64(x, most), most, x);
        return L::select(L::greater64(least, x), least, x);
    }
    /// K^-1 x / 2^shift: 30 bits times 32, three times, clamped to `limit`.
    static void over_gyration(const Held& held, unsigned lane, const V (&x)[3],
                              const Lanes<std::int64_t>& shift, std::int64_t limit, V (&out)[3]) {
        const V by = L::load64(&shift[lane]), most = L::splat(limit), least = L::splat(-limit);
        for (int i = 0; i < 3; ++i) {
            V sum = L::mul(L::load32(&held.inverse[inverse_at[i][0]][lane]), x[0]);
            for (int k = 1; k < 3; ++k)
                sum = L::add(sum, L::mul(L::load32(&held.inverse[inverse_at[i][k]][lane]), x[k]));
            out[i] = between(L::shift_right_by(sum, by), least, most);
        }
    }
    /// The rotation matrix of a turn by phi, by rows.
    static void matrix_of(const V (&phi)[3], V (&m)[9]) {
        constexpr std::int64_t one = std::int64_t{1} << unit_bits;
        V q[4], square = L::splat(0);
        for (const V& x : phi) square = L::add(square, L::mul(x, x));
        // h has the bits of phi and one more fraction bit.
        const V z = L::template shift_right<2 * (solve::pack_angle_bits + 1) - unit_bits>(square);
        const auto by = [](V x, std::int64_t factor) {
            return L::template shift_right<unit_bits>(L::mul(x, L::splat(factor)));
        };
        const V zz = L::template shift_right<unit_bits>(L::mul(z, z));
        const V sinc = L::add(L::sub(L::splat(one), by(z, one / 6)), by(zz, one / 120));
        const V half_phi = L::splat(std::int64_t{1} << solve::pack_angle_bits);
        for (int i = 0; i < 3; ++i)
            q[i] = L::template shift_right_signed<solve::pack_angle_bits + 1>(
                L::add(L::mul(phi[i], sinc), half_phi));
        q[3] = L::add(L::sub(L::splat(one), by(z, one / 2)), by(zz, one / 24));

        constexpr int shift = unit_bits - 1; // entries are twice a sum of products
        const V whole = L::splat(one), half = L::splat(std::int64_t{1} << (shift - 1));
        const auto twice = [&](V sum) { return L::template shift_right<shift>(L::add(sum, half)); };
        const V xx = L::mul(q[0], q[0]), yy = L::mul(q[1], q[1]), zz_ = L::mul(q[2], q[2]);
        const V xy = L::mul(q[0], q[1]), xz = L::mul(q[0], q[2]), yz = L::mul(q[1], q[2]);
        const V wx = L::mul(q[3], q[0]), wy = L::mul(q[3], q[1]), wz = L::mul(q[3], q[2]);
        m[0] = L::sub(whole, twice(L::add(yy, zz_))), m[1] = twice(L::sub(xy, wz));
        m[2] = twice(L::add(xz, wy)), m[3] = twice(L::add(xy, wz));
        m[4] = L::sub(whole, twice(L::add(xx, zz_))), m[5] = twice(L::sub(yz, wx));
        m[6] = twice(L::sub(xz, wy)), m[7] = twice(L::add(yz, wx));
        m[8] = L::sub(whole, twice(L::add(xx, yy)));
    }
    /// Lanes in which phi has changed by more than 2^-bits rad about an axis since `last`. In these lanes, sets
    /// `last` to phi.
    static V stray(const Held& held, const V (&phi)[3], Lanes<std::int32_t> (&last)[3], unsigned lane,
                   V stirred, int bits) {
        const V most = L::splat(std::int64_t{1} << (solve::pack_angle_bits - bits)),
                least = L::sub(L::splat(0), most);
        V far = load_extended<L>(&held.strays[lane]);
        for (int i = 0; i < 3; ++i) {
            const V change = L::sub(phi[i], load_extended<L>(&last[i][lane]));
            far = L::either(far, L::either(L::greater64(change, most), L::greater64(least, change)));
        }
        far = L::both(far, stirred);
        if (L::lanes_of(far) != 0)
            for (int i = 0; i < 3; ++i)
                L::store32(&last[i][lane], L::select(far, phi[i], L::load32(&last[i][lane])));
        return far;
    }
    [[gnu::always_inline]] static void turn_lanes(const Data& data, Held& held, std::size_t first,
                                                  unsigned lane) {
        const solve::SolverBody* body[N];
        std::int32_t* to[N];
        for (unsigned i = 0; i < N; ++i) {
            body[i] = reinterpret_cast<const solve::SolverBody*>(
                reinterpret_cast<const std::byte*>(data.bodies) + held.place[lane + i]);
            to[i] = &data.turned[first + lane + i].turn[0][0];
        }
        V moved[6], motion[6], phi[3], spin[3], m[9], u[3];
        L::gather_motion(body, moved), L::gather6(body, motion);
        const V theta[3] = {moved[3], moved[4], moved[5]};
        over_gyration(held, lane, theta, held.turn_shift, std::int64_t{1} << unit_bits, phi);
        for (int i = 0; i < 3; ++i)
            u[i] = rounded<speed_bits>(LaneSum<L, accumulator_bits>{motion[3 + i]}).lanes();
        over_gyration(held, lane, u, held.spin_shift, std::int64_t{1} << 30, spin);
        matrix_of(phi, m);
        const V rows[4][4] = {{m[0], m[1], m[2], m[3]},
                              {m[4], m[5], m[6], m[7]},
                              {m[8], spin[0], spin[1], spin[2]},
                              {moved[0], moved[1], moved[2], L::splat(0)}};
        for (const auto& row : rows) {
            L::store_quads(to, row);
            for (auto& at : to) at += 4;
        }

        V any = moved[0], far = L::splat(0);
        for (int i = 1; i < 6; ++i) any = L::either(any, moved[i]);
        const V moves = L::template shift_left<32>(any), zero = L::splat(0);
        const V stirred = L::either(L::greater64(moves, zero), L::greater64(zero, moves));
        const V strays = stray(held, phi, held.alone_at, lane, stirred, solve::row_turn_bits),
                strays_far = stray(held, phi, held.packed_at, lane, stirred, solve::pack_turn_bits);
        const V told = L::splat(std::int64_t{1} << (solve::pack_angle_bits - solve::given_turn_bits));
        for (const V& x : phi)
            far = L::either(far, L::either(L::greater64(x, told), L::greater64(L::sub(zero, told), x)));
        const auto bit = [](V mask, std::int64_t value) { return L::both(mask, L::splat(value)); };
        const V flags =
            L::either(L::either(bit(stirred, solve::seen_stirred), bit(strays, solve::seen_strays)),
                      L::either(bit(strays_far, solve::seen_strays_far), bit(far, solve::seen_far)));
        std::int64_t seen[N];
        L::store64(seen, flags);
        for (unsigned i = 0; i < N; ++i) data.seen[first + lane + i] = static_cast<std::uint8_t>(seen[i]);
    }

  public:
    static void turn(const Data& data, std::uint32_t first, std::uint32_t last) {
        for (std::size_t i = first; i < last; ++i)
            for (unsigned lane = 0; lane < solve::pack_lanes; lane += N)
                turn_lanes(data, data.held[i], 1 + i * solve::pack_lanes, lane);
    }
};

} // namespace lockstone::solve
