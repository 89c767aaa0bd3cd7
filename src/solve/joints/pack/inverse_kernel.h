// Inverses of the rows of packed joints, written once for all lane widths L: of points, and of hinges about their
// axes. Results equal those of solve/joints/joint_rows.h bit for bit: both use Cramer's rule on 31 bits. Lanes that
// need pivots, or whose numbers do not fit into the low half of a lane, are left to the caller. See
// solve/joints/pack/joint_pack.h for the formats.
//
//   k = sum over both sides of share (X X^T + one^2 1)      k^-1 = adjugate / determinant
//
// Only kernel.h includes this file.
#pragma once

#include "solve/joints/pack/joint_pack.h"

#include <bit>
#include <cstdint>

namespace lockstone::solve {

template <class L> class JointInverses {
    static constexpr unsigned N = L::lanes, all_lanes = solve::pack_lanes;
    using Pack = solve::JointPack;
    using Data = solve::JointPassData;
    using V = typename L::V;
    template <class T> using Lanes = T[all_lanes];
    using Rows = const Lanes<std::int32_t> (*)[3];
    static constexpr int k_bits = 31; ///< of k, scaled so that its largest diagonal entry is in [1/2, 1)
    static constexpr int spare = 8;   ///< zero bits of k below its 48 fraction bits before scaling
    static constexpr std::int64_t k_end = std::int64_t{1} << k_bits, determinant_min = std::int64_t{1} << 44;
    /// Lower triangle by rows, as Inverse: 11, 21, 22, 31, 32, 33.
    using Symmetric = V[6];

    /// The part of one side in k.
    struct Side {
        Rows point, hinge;
        const Lanes<std::int32_t>& share;
        const Lanes<std::int64_t>& shift;
        bool shifts;
    };
    struct Target {
        Pack* pack;
        unsigned lane;
    };
    /// Lanes that are inverted together.
    struct Lot {
        const Lanes<std::int32_t>&one, &generic, &stale;
        Side a, b;
        bool hinges;
        Target first;         ///< consecutive lanes of a pack
        const Target* others; ///< targets of the inverses instead, or nullptr
        Target target(unsigned i) const {
            return others != nullptr ? others[i] : Target{first.pack, first.lane + i};
        }
    };
    /// Stale lanes of several packs, side by side. Other lanes contain zeros or old values.
    class Gathered {
        struct Own {
            Lanes<std::int32_t> point[3][3], hinge[2][3], share;
            Lanes<std::int64_t> shift;
            bool shifts;
        };
        Lanes<std::int32_t> one{}, generic{}, stale{};
        Own a{}, b{};
        Target targets[N] = {};
        unsigned count = 0;

        static void copy(Rows from, unsigned lane, Lanes<std::int32_t> (*to)[3], unsigned at, int rows) {
            for (int r = 0; r < rows; ++r)
                for (int i = 0; i < 3; ++i) to[r][i][at] = from[r][i][lane];
        }
        static void copy(const solve::PackSide& from, unsigned lane, Own& to, unsigned at) {
            copy(from.x, lane, to.point, at, 3);
            to.share[at] = from.share[lane], to.shift[at] = from.shift[lane];
            to.shifts = to.shifts || from.shifts;
        }
        static Side side_of(const Own& own) {
            return {own.point, own.hinge, own.share, own.shift, own.shifts};
        }

      public:
        /// Adds a lane. Returns true if all lanes are used.
        bool add(const Data& data, Pack& c, unsigned lane) {
            one[count] = c.one[lane], stale[count] = -1;
            copy(c.a, lane, a, count), copy(c.b, lane, b, count);
            if (c.hinges) {
                const solve::TurnPack& t = data.turns[c.turn];
                generic[count] = t.generic[lane];
                copy(t.ja, lane, a.hinge, count, 2), copy(t.jb, lane, b.hinge, count, 2);
            }
            targets[count] = {&c, lane};
            return ++count == N;
        }
        unsigned invert(const Data& data, bool hinges) {
            if (count == 0) return 0;
            const unsigned left = JointInverses::invert(
                data, {one, generic, stale, side_of(a), side_of(b), hinges, {nullptr, 0}, targets});
            for (unsigned i = 0; i < N; ++i) stale[i] = 0;
            count = 0;
            return left;
        }
    };

    /// Index of the highest bit that is set. x must not be zero.
    static std::int64_t highest_bit(std::int64_t x) {
        return static_cast<unsigned>(63 ^ std::countl_zero(static_cast<std::uint64_t>(x) | 1u));
    }
    static V highest_bits(V x) {
        std::int64_t lanes[N];
        L::store64(lanes, x);
        for (std::int64_t& lane : lanes) lane = highest_bit(lane);
        return L::from_lanes(lanes);
    }
    /// Lanes that are negative, or at least 2^Bits.
    template <int Bits> static V beyond(V any) {
        return L::greater64(L::template shift_right<Bits>(any), L::splat(0));
    }

    /// share * dot with 48 fraction bits, rounded down, and `spare` zero bits; dot has 56 and is below 2^60
    static V shared(V dot, V share, const Side& side, unsigned lane) {
        constexpr int low_bits = 30; // both parts fit into the low half
        const V high = L::mul(L::template shift_right<low_bits>(dot), share);
        const V low = L::mul(L::both(dot, L::splat((std::int64_t{1} << low_bits) - 1)), share);
        V sum = L::add(high, L::template shift_right<low_bits>(low));
        if (side.shifts) {
            const V shift = L::load64(&side.shift[lane]), most = L::splat(52);
            const V far = L::greater64(shift, most);
            sum = L::without(L::shift_right_by(sum, L::select(far, most, shift)), far);
        }
        return L::both(sum, L::splat(-(std::int64_t{1} << spare)));
    }
    /// x x^T of the rows of a side, plus one^2 on the diagonal. Add: adds it to k instead of writing k.
    template <unsigned Size, bool Add>
    static void add_side(Rows x, V square, const Side& side, unsigned lane, Symmetric& k) {
        const V share = L::load32(&side.share[lane]);
        V row[Size][3];
        for (unsigned r = 0; r < Size; ++r)
            for (int i = 0; i < 3; ++i) row[r][i] = L::load32(&x[r][i][lane]);
        for (unsigned r = 0, at = 0; r < Size; ++r)
            for (unsigned c = 0; c <= r; ++c, ++at) {
                V dot = L::add(L::add(L::mul(row[r][0], row[c][0]), L::mul(row[r][1], row[c][1])),
                               L::mul(row[r][2], row[c][2]));
                if (r == c) dot = L::add(dot, square);
                const V part = shared(dot, share, side, lane);
                k[at] = Add ? L::add(k[at], part) : part;
            }
    }

    /// x / 2^by + 2^31, rounded: from 0 to 2^32 if the quotient has 32 bits. |x| must be below 2^(31 + by), or `by`
    /// at most 31.
    static V rounded_by(V x, V by) {
        constexpr std::int64_t half_and_end = (std::int64_t{1} << 32) + 1;
        const V plus = L::shift_left_by(L::splat(half_and_end), L::sub(by, L::splat(1)));
        return L::shift_right_logical_by(L::add(x, plus), by);
    }
    /// Scales k to k 2^-shift, with the largest diagonal entry from 2^30 to 2^31. Returns the lanes for which that is
    /// not possible with a shift down.
    template <int Count> static V normalize(Symmetric& k, V& shift) {
        V largest = k[0];
        for (const int i : {2, 5})
            if (i < Count) largest = L::select(L::greater64(k[i], largest), k[i], largest);
        const V end = L::splat(k_end << spare);
        // Shifts by more than the spare bits, even in lanes whose numbers are too small for that.
        shift = L::sub(highest_bits(L::either(largest, end)), L::splat(k_bits - 1));
        V any = L::splat(0);
        for (int i = 0; i < Count; ++i) {
            const V x = rounded_by(k[i], shift);
            any = L::either(any, x), k[i] = L::sub(x, L::splat(k_end));
        }
        return L::either(beyond<k_bits + 1>(any), L::greater64(end, largest));
    }
    /// x y - z w of low halves
    static V minor(V x, V y, V z, V w) { return L::sub(L::mul(x, y), L::mul(z, w)); }
    static V magnitude(V x) {
        const V nothing = L::splat(0);
        return L::select(L::greater64(nothing, x), L::sub(nothing, x), x);
    }

    /// Sum of a m over the first row a of k and its minors m, shifted down by 31 bits and rounded.
    static V determinant(const V (&a)[3], const V (&m)[3]) {
        const V low = L::splat((std::int64_t{1} << 31) - 1);
        V sum[3], part[3];
        for (int i = 0; i < 3; ++i)
            sum[i] = L::mul(a[i], L::template shift_right<31>(m[i])),
            part[i] = L::mul(a[i], L::both(m[i], low));
        // The sum of all three parts does not fit into 64 bits. The first one, of the diagonal, is not negative.
        const V rest = L::add(L::add(part[1], part[2]), L::splat(std::int64_t{1} << 30));
        const V carried = L::template shift_right<31>(L::add(L::both(part[0], low), L::both(rest, low)));
        const V high = L::add(L::template shift_right<31>(part[0]), L::template shift_right_signed<31>(rest));
        return L::add(L::add(L::add(sum[0], sum[1]), sum[2]), L::add(high, carried));
    }

    /// Inverses in lanes, in the format of solve::PackInverse.
    struct Inverses {
        V m[6], shift, half, odd;
        V left; ///< lanes without a valid inverse
    };
    /// numerator / determinant; the numerator has 31 bits. The shift of the result is `more` plus the index of the
    /// highest bit of the determinant, which is at least determinant_min except in `left` lanes.
    template <int Count> static Inverses quotient(const Symmetric& numerator, V det, V more, V left) {
        std::int64_t top[N], q[N];
        L::store64(top, L::select(left, L::splat(determinant_min), det));
        for (unsigned i = 0; i < N; ++i) {
            const std::uint64_t d = static_cast<std::uint64_t>(top[i]);
            top[i] = highest_bit(top[i]);
            // in (2^30, 2^31]
            q[i] = static_cast<std::int64_t>((std::uint64_t{1} << 62) / (d >> (top[i] - 31)));
        }
        Inverses out;
        const V by = L::from_lanes(q), half = L::splat(std::int64_t{1} << 31), one = L::splat(1);
        for (int i = 0; i < Count; ++i)
            out.m[i] = L::template shift_right<32>(L::add(L::mul(numerator[i], by), half));
        out.left = L::either(left, L::greater64(by, L::splat(k_end - 1)));
        out.shift = L::add(L::from_lanes(top), more);
        out.odd = L::either(L::greater64(one, out.shift), L::greater64(out.shift, L::splat(62)));
        out.half = L::without(L::shift_left_by(one, L::without(L::sub(out.shift, one), out.odd)), out.odd);
        return out;
    }

    static Inverses invert_points(const Lot& lot) {
        const unsigned lane = lot.first.lane;
        const V one = L::load32(&lot.one[lane]), square = L::mul(one, one);
        Symmetric k;
        add_side<3, false>(lot.a.point, square, lot.a, lane, k);
        add_side<3, true>(lot.b.point, square, lot.b, lane, k);
        V drop;
        V left = normalize<6>(k, drop);
        Symmetric adjugate = {minor(k[2], k[5], k[4], k[4]), minor(k[3], k[4], k[1], k[5]),
                              minor(k[0], k[5], k[3], k[3]), minor(k[1], k[4], k[2], k[3]),
                              minor(k[1], k[3], k[0], k[4]), minor(k[0], k[2], k[1], k[1])};
        // Diagonal entries are negative only because of rounding; such lanes are left.
        V any = L::either(L::either(adjugate[0], adjugate[2]), adjugate[5]);
        for (const int i : {1, 3, 4}) any = L::either(any, magnitude(adjugate[i]));
        const V first[3] = {k[0], k[1], k[3]}, minors[3] = {adjugate[0], adjugate[1], adjugate[3]};
        const V det = determinant(first, minors);
        left = L::either(left, L::either(beyond<62>(any), L::greater64(L::splat(determinant_min), det)));

        // At least 1, as it is in lanes that are not left.
        const V cut = L::sub(highest_bits(L::either(any, L::splat(k_end))), L::splat(k_bits - 1));
        V over = L::splat(0);
        for (V& entry : adjugate) {
            const V x = rounded_by(entry, cut);
            over = L::either(over, x), entry = L::sub(x, L::splat(k_end));
        }
        left = L::either(left, beyond<k_bits + 1>(over));
        const V more = L::add(L::sub(drop, cut), L::splat(13 - spare - k_bits));
        return quotient<6>(adjugate, det, more, left);
    }
    /// With two rows the adjugate consists of entries of k, so it already has 31 bits.
    static Inverses invert_hinges(const Lot& lot) {
        const unsigned lane = lot.first.lane;
        Symmetric k;
        add_side<2, false>(lot.a.hinge, L::splat(0), lot.a, lane, k);
        add_side<2, true>(lot.b.hinge, L::splat(0), lot.b, lane, k);
        V drop;
        V left = normalize<3>(k, drop);
        const V det = minor(k[0], k[2], k[1], k[1]);
        left = L::either(left, L::greater64(L::splat(determinant_min), det));
        const Symmetric adjugate = {k[2], L::sub(L::splat(0), k[1]), k[0]};
        return quotient<3>(adjugate, det, L::add(drop, L::splat(13 - spare - 2 * k_bits)), left);
    }

    template <int Count> static void store(const Inverses& x, solve::PackInverse& to, unsigned lane) {
        for (int i = 0; i < Count; ++i) L::store32(&to.m[i][lane], x.m[i]);
        L::store64(&to.shift[lane], x.shift), L::store64(&to.half[lane], x.half);
    }
    /// Writes the lanes of a mask to inverse_of(pack), except lanes that are left. Returns the latter as bits.
    template <int Count, class InverseOf>
    static unsigned write(const Lot& lot, V mask, const Inverses& x, InverseOf&& inverse_of) {
        constexpr unsigned all = (1u << N) - 1;
        const unsigned ready = L::lanes_of(L::without(mask, x.left)), odd = L::lanes_of(x.odd);
        if (lot.others == nullptr && ready == all) {
            const auto [pack, lane] = lot.first;
            solve::PackInverse& to = inverse_of(*pack);
            store<Count>(x, to, lane);
            to.odd = (to.odd & ~(all << lane)) | odd << lane;
            return 0;
        }
        solve::PackInverse made;
        store<Count>(x, made, 0);
        for (unsigned i = 0; i < N; ++i) {
            if (((ready >> i) & 1u) == 0) continue;
            const auto [pack, lane] = lot.target(i);
            solve::PackInverse& to = inverse_of(*pack);
            for (int k = 0; k < Count; ++k) to.m[k][lane] = made.m[k][i];
            to.shift[lane] = made.shift[i], to.half[lane] = made.half[i];
            to.odd = (to.odd & ~(1u << lane)) | ((odd >> i) & 1u) << lane;
        }
        return L::lanes_of(mask) & ~ready;
    }
    /// Marks the lanes of packs that are left.
    static void leave(const Lot& lot, unsigned left, std::uint32_t Pack::*lanes) {
        for (unsigned i = 0; left != 0; ++i, left >>= 1)
            if ((left & 1u) != 0) lot.target(i).pack->*lanes |= 1u << lot.target(i).lane;
    }
    /// Returns nonzero if some lanes are left.
    [[gnu::noinline]] static unsigned invert(const Data& data, const Lot& lot) {
        const V stale = L::load32(&lot.stale[lot.first.lane]);
        const auto of_points = [](Pack& c) -> solve::PackInverse& { return c.inverse; };
        const auto of_hinges = [&](Pack& c) -> solve::PackInverse& { return data.turns[c.turn].inverse; };
        const unsigned points = write<6>(lot, stale, invert_points(lot), of_points);
        leave(lot, points, &Pack::points_left);
        if (!lot.hinges) return points;
        const V own = L::without(stale, L::load32(&lot.generic[lot.first.lane]));
        const unsigned hinges = write<3>(lot, own, invert_hinges(lot), of_hinges);
        leave(lot, hinges, &Pack::hinges_left);
        return points | hinges;
    }
    /// Inverts the lanes of a pack from `lane` on.
    static unsigned invert(const Data& data, Pack& c, unsigned lane) {
        const auto side = [](const solve::PackSide& s, Rows hinge) {
            return Side{s.x, hinge, s.share, s.shift, s.shifts};
        };
        if (!c.hinges)
            return invert(
                data,
                {c.one, c.one, c.stale, side(c.a, nullptr), side(c.b, nullptr), false, {&c, lane}, nullptr});
        const solve::TurnPack& t = data.turns[c.turn];
        return invert(
            data, {c.one, t.generic, c.stale, side(c.a, t.ja), side(c.b, t.jb), true, {&c, lane}, nullptr});
    }

    static unsigned but_lowest(unsigned bits) { return bits & (bits - 1); }

  public:
    /// Computes the inverses of the stale lanes of packs [first, last). Stale lanes of packs that have only one or
    /// two are gathered and inverted together. Returns true if some are left to the caller: JointPack::points_left,
    /// hinges_left.
    static bool invert(const Data& data, std::uint32_t first, std::uint32_t last) {
        unsigned left = 0;
        Gathered gathered[2];
        for (std::uint32_t p = first; p < last; ++p) {
            Pack& c = data.packs[p];
            c.points_left = c.hinges_left = 0;
            for (unsigned lane = 0; lane < all_lanes; lane += N) {
                const unsigned stale = L::lanes_of(L::load32(&c.stale[lane]));
                if (stale == 0) continue;
                if (N < all_lanes || but_lowest(but_lowest(stale)) != 0) {
                    left |= invert(data, c, lane);
                    continue;
                }
                Gathered& with = gathered[c.hinges];
                for (unsigned rest = stale; rest != 0; rest = but_lowest(rest))
                    if (with.add(data, c, static_cast<unsigned>(std::countr_zero(rest))))
                        left |= with.invert(data, c.hinges);
            }
        }
        for (const bool hinges : {false, true}) left |= gathered[hinges].invert(data, hinges);
        return left != 0;
    }
};

} // namespace lockstone::solve
