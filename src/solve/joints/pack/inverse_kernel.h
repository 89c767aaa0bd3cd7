// The inverses of the rows of packed joints, written once over the lanes L: of points, and of hinges about their axes. Bit for bit those
// of solve/joints/joint_rows.h, by Cramer's rule on 31 bits; what that rule leaves to pivots, or what does not fit into the
// low half of a lane, is left to the caller. See solve/joints/pack/joint_pack.h for the formats.
//
//   k = sum over both sides of share (X X^T + one^2 1)      k^-1 = adjugate / determinant
//
// Included as kernel.h, by which this is used.
#pragma once

#include "solve/joints/pack/joint_pack.h"

#include <bit>
#include <cstdint>

namespace lockstone::solve {

template <class L> class JointInverses {
    static constexpr unsigned N = L::lanes, all_lanes = solve::pack_lanes;
    using Pack = solve::JointPack;
    using Side = solve::PackSide;
    using V = typename L::V;
    using Row3 = std::int32_t[3][3][all_lanes];
    static constexpr int k_bits = 31; ///< of k once its largest diagonal entry is in [1/2, 1)
    static constexpr std::int64_t k_end = std::int64_t{1} << k_bits, adjugate_end = std::int64_t{1} << 62,
                                  determinant_min = std::int64_t{1} << 44;
    /// Lower triangle by rows, as Inverse: 11, 21, 22, 31, 32, 33.
    using Symmetric = V[6];

    static int bit_length(std::int64_t x) {
        return x == 0 ? 0 : 64 - std::countl_zero(static_cast<std::uint64_t>(x));
    }
    static V negative(V x) { return L::greater64(L::splat(0), x); }
    /// Lanes in which some x - least is below zero or not below 2^Bits; `any` has those differences or-ed.
    template <int Bits> static V beyond(V any) {
        return L::greater64(L::template shift_right<Bits>(any), L::splat(0));
    }

    /// share * dot with 48 fraction bits, rounded down twice; dot has 56 and is below 2^60.
    static V shared(V dot, const Side& side, unsigned lane) {
        constexpr int low_bits = 30; // so that both parts are within the low half
        const V share = L::load32(&side.share[lane]);
        const V high = L::mul(L::template shift_right<low_bits>(dot), share);
        const V low = L::mul(L::both(dot, L::splat((std::int64_t{1} << low_bits) - 1)), share);
        const V sum = L::add(L::template shift_left<2>(high), L::template shift_right<28>(low)); // 58 bits
        if (!side.shifts) return L::template shift_right_signed<10>(sum);
        const V shift = L::load64(&side.shift[lane]), most = L::splat(52);
        const V far = L::greater64(shift, most);
        return L::without(L::shift_right_by(sum, L::add(L::select(far, most, shift), L::splat(10))), far);
    }
    /// Adds x x^T of the rows of a side, one^2 on its diagonal.
    template <unsigned Rows>
    static void add_side(const Row3& x, V square, const Side& side, unsigned lane, Symmetric& k) {
        V row[Rows][3];
        for (unsigned r = 0; r < Rows; ++r)
            for (int i = 0; i < 3; ++i) row[r][i] = L::load32(&x[r][i][lane]);
        for (unsigned r = 0, at = 0; r < Rows; ++r)
            for (unsigned c = 0; c <= r; ++c, ++at) {
                V dot = L::add(L::add(L::mul(row[r][0], row[c][0]), L::mul(row[r][1], row[c][1])),
                               L::mul(row[r][2], row[c][2]));
                if (r == c) dot = L::add(dot, square);
                k[at] = L::add(k[at], shared(dot, side, lane));
            }
    }

    static V rounded_by(V x, const std::int64_t (&by)[N]) {
        const V shift = L::load64(by);
        return L::shift_right_by(L::add(x, L::shift_left_by(L::splat(1), L::sub(shift, L::splat(1)))), shift);
    }
    /// k 2^-drop, its largest diagonal entry from 2^30 to 2^31. Returns the lanes where that is not to be had by a shift down.
    template <int Count> static V normalize(Symmetric& k, std::int64_t (&drop)[N]) {
        V largest = k[0];
        for (const int i : {2, 5})
            if (i < Count) largest = L::select(L::greater64(k[i], largest), k[i], largest);
        L::store64(drop, largest);
        for (unsigned i = 0; i < N; ++i) { // 1: too small, as they are then
            const int length = bit_length(drop[i]);
            drop[i] = length > k_bits ? length - k_bits : 1;
        }
        V any = L::splat(0);
        for (int i = 0; i < Count; ++i) {
            k[i] = rounded_by(k[i], drop);
            any = L::either(any, L::add(k[i], L::splat(k_end)));
        }
        return L::either(beyond<k_bits + 1>(any), L::greater64(L::splat(k_end), largest));
    }
    /// x y - z w of low halves.
    static V minor(V x, V y, V z, V w) { return L::sub(L::mul(x, y), L::mul(z, w)); }

    /// Sum of a m over the first row of k and its minors, shifted down by 31 bits and rounded.
    static V determinant(const V (&a)[3], const V (&m)[3]) {
        const V low = L::splat((std::int64_t{1} << 31) - 1);
        V sum = L::splat(0), rest = L::splat(std::int64_t{1} << 30);
        for (int i = 0; i < 3; ++i) {
            const V part = L::mul(a[i], L::both(m[i], low));
            sum = L::add(sum, L::add(L::mul(a[i], L::template shift_right<31>(m[i])),
                                     L::template shift_right_signed<31>(part)));
            rest = L::add(rest, L::both(part, low));
        }
        return L::add(sum, L::template shift_right<31>(rest));
    }

    /// Where `mask` is set: the inverse, adjugate / determinant. Returns the lanes in which a factor has 32 bits.
    template <int Count>
    static V write_quotient(solve::PackInverse& to, unsigned lane, const Symmetric& adjugate, V det,
                            const std::int64_t (&drop)[N], V mask) {
        std::int64_t length[N], cut[N], q[N];
        V any = L::splat(0);
        for (int i = 0; i < Count; ++i) {
            const V below = negative(adjugate[i]);
            any = L::either(any, L::select(below, L::sub(L::splat(0), adjugate[i]), adjugate[i]));
        }
        L::store64(length, det), L::store64(cut, any);
        const unsigned asked = L::lanes_of(mask);
        for (unsigned i = 0; i < N; ++i) {
            if (((asked >> i) & 1u) == 0) {
                cut[i] = q[i] = 1;
                continue;
            }
            const std::int64_t d = length[i];
            length[i] = bit_length(d);
            cut[i] = bit_length(cut[i]) - 31;
            q[i] = static_cast<std::int64_t>( // in (2^30, 2^31]
                ((std::uint64_t{1} << 63) / (static_cast<std::uint64_t>(d) >> (length[i] - 32))) >> 1);
        }
        V m[6], out = L::splat(0);
        const V by = L::load64(q), half = L::splat(std::int64_t{1} << 31);
        for (int i = 0; i < Count; ++i) {
            const V x = rounded_by(adjugate[i], cut);
            out = L::either(out, L::add(x, L::splat(k_end)));
            m[i] = L::template shift_right<32>(L::add(L::mul(x, by), half));
        }
        const V left = L::either(beyond<k_bits + 1>(out), L::greater64(by, L::splat(k_end - 1)));
        const V ready = L::without(mask, left), one = L::splat(1);
        const auto keep = [ready](V x, V before) { return L::select(ready, x, before); };
        for (int i = 0; i < 6; ++i)
            L::store32(&to.m[i][lane], keep(i < Count ? m[i] : L::splat(0), L::load32(&to.m[i][lane])));
        // length - (cut + 31) + 12 + drop
        const V shift =
            L::add(L::sub(L::load64(length), L::load64(cut)), L::sub(L::load64(drop), L::splat(31 - 12)));
        const V odd = L::either(L::greater64(one, shift), L::greater64(shift, L::splat(62)));
        const V rounding = L::without(L::shift_left_by(one, L::without(L::sub(shift, one), odd)), odd);
        L::store64(&to.shift[lane], keep(shift, L::load64(&to.shift[lane])));
        L::store64(&to.half[lane], keep(rounding, L::load64(&to.half[lane])));
        const unsigned done = L::lanes_of(ready), odd_lanes = L::lanes_of(odd);
        for (unsigned i = 0; i < N; ++i)
            if ((done >> i) & 1u) to.odd[lane + i] = (odd_lanes >> i) & 1u;
        return left;
    }

    static V invert_point(Pack& c, unsigned lane, V mask) {
        const V one = L::load32(&c.one[lane]), square = L::mul(one, one);
        Symmetric k;
        for (V& entry : k) entry = L::splat(0);
        add_side<3>(c.a.x, square, c.a, lane, k), add_side<3>(c.b.x, square, c.b, lane, k);
        std::int64_t drop[N];
        V left = normalize<6>(k, drop);
        const Symmetric adjugate = {minor(k[2], k[5], k[4], k[4]), minor(k[3], k[4], k[1], k[5]),
                                    minor(k[0], k[5], k[3], k[3]), minor(k[1], k[4], k[2], k[3]),
                                    minor(k[1], k[3], k[0], k[4]), minor(k[0], k[2], k[1], k[1])};
        V any = L::splat(0);
        for (int i = 0; i < 6; ++i) any = L::either(any, L::add(adjugate[i], L::splat(adjugate_end)));
        const V first[3] = {k[0], k[1], k[3]}, minors[3] = {adjugate[0], adjugate[1], adjugate[3]};
        const V det = determinant(first, minors);
        left = L::either(left, L::either(beyond<63>(any), L::greater64(L::splat(determinant_min), det)));
        return L::either(left,
                         write_quotient<6>(c.inverse, lane, adjugate, det, drop, L::without(mask, left)));
    }
    static V invert_hinge(solve::TurnPack& t, const Pack& c, unsigned lane, V mask) {
        Symmetric k;
        for (V& entry : k) entry = L::splat(0);
        add_side<2>(t.ja, L::splat(0), c.a, lane, k), add_side<2>(t.jb, L::splat(0), c.b, lane, k);
        std::int64_t drop[N];
        V left = normalize<3>(k, drop);
        Symmetric adjugate = {L::template shift_left<k_bits>(k[2]),
                              L::sub(L::splat(0), L::template shift_left<k_bits>(k[1])),
                              L::template shift_left<k_bits>(k[0])};
        for (int i = 3; i < 6; ++i) adjugate[i] = L::splat(0);
        const V det = minor(k[0], k[2], k[1], k[1]);
        left = L::either(left, L::greater64(L::splat(determinant_min), det));
        return L::either(left,
                         write_quotient<3>(t.inverse, lane, adjugate, det, drop, L::without(mask, left)));
    }

  public:
    /// Of the lanes of a pack that are stale. Bits of solve::JointPack::left in those that are left to the caller.
    static void invert(const solve::JointPassData& data, Pack& c, unsigned lane) {
        std::int64_t stale[N], own[N];
        unsigned any = 0;
        for (unsigned i = 0; i < N; ++i) {
            c.left[lane + i] = 0;
            any |= c.stale[lane + i];
            stale[i] = c.stale[lane + i] != 0 ? -1 : 0;
        }
        if (any == 0) return;
        const V mask = L::load64(stale);
        const auto note = [&](V left, std::uint8_t bit) {
            const unsigned lanes = L::lanes_of(left);
            if (lanes == 0) [[likely]]
                return;
            for (unsigned i = 0; i < N; ++i)
                if ((lanes >> i) & 1u) c.left[lane + i] |= bit;
        };
        note(L::both(invert_point(c, lane, mask), mask), solve::point_left);
        if (!c.hinges) return;
        solve::TurnPack& t = data.turns[c.turn];
        for (unsigned i = 0; i < N; ++i) own[i] = t.generic[lane + i] == 0 ? stale[i] : 0;
        const V hinges = L::load64(own);
        note(L::both(invert_hinge(t, c, lane, hinges), hinges), solve::hinge_left);
    }
};

} // namespace lockstone::solve
