// Pairs of shapes in lanes, written once over the lanes L. See solve/pairs/pair_kernel.h for the inputs and outputs,
// and solve/contacts/contact_memory.h for the conditions of recycling a manifold.
//
// Only files that are compiled for one instruction set include this. It must not use inline functions that other files
// use too, since the linker keeps only one of their copies.
#pragma once

#include "solve/lanes/lane_fixed.h"
#include "solve/pairs/pair_kernel.h"

namespace lockstone::solve {

template <class L> class PairLanes {
    static constexpr unsigned N = L::lanes;
    static constexpr int unit_bits = 30, length_bits = 24, speed_bits = 19, gap_bits = 27;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Unit = LaneFixed<L, unit_bits>;
    using Length = LaneFixed<L, length_bits>;
    using Speed = LaneFixed<L, speed_bits>;
    template <int F> using Sum = LaneSum<L, F>;
    using Lane = solve::PairLane;
    using Pass = solve::PairPass;

    static constexpr std::int64_t far_away = std::int64_t{16384}
                                             << length_bits; ///< collide::relative_position_max
    static constexpr std::int64_t turn_max = std::int64_t{1}
                                             << 27; ///< a larger angle has a chord too far from its arc [rad]

    /// The data of N pairs on the way to their contacts.
    struct Pairs {
        const Lane* lane[N];
        const solve::ContactMemory* memory[N];
        Sum<32> way[6];
        Unit axes[3][3];        ///< [column][component] of A's axes
        Sum<length_bits> at[3]; ///< position of B's origin in A's frame
        Unit turn[4];           ///< B's axes in A's frame
        Length limit, reach, step_max;
        Mask advances, on_ground, is_given;
        Length moved[3]; ///< since the manifold was made
        Unit turned[3];  ///< turn since the manifold was made, as a rotation vector
        Mask bad;        ///< the manifold is not recycled
    };

    // ---- reading ---

    /// Reads four numbers of 32 bits for each lane, at the address that `place` returns.
    template <class Place> static void quad(const Pairs& p, Place&& place, V (&out)[4]) {
        const std::int32_t* from[N];
        for (unsigned k = 0; k < N; ++k) from[k] = reinterpret_cast<const std::int32_t*>(place(*p.lane[k]));
        L::quads(from, out);
    }
    template <class Place> static void six(const Pairs& p, Place&& place, V (&out)[6]) {
        const solve::Six* from[N];
        for (unsigned k = 0; k < N; ++k) from[k] = place(*p.lane[k]);
        L::gather6(from, out);
    }
    static Mask mask_of(V flags) { return Mask::of(extended<L>(flags)); }
    template <int F> static Sum<F> sum_of(V low) { return {extended<L>(low)}; }

    static void read(Pairs& p) {
        V v[6], q[4];
        six(
            p, [](const Lane& l) { return &l.way; }, v);
        for (int i = 0; i < 6; ++i) p.way[i] = {v[i]};
        // nine numbers: the last four overlap the four before them
        const auto axes = [&](int from, int first) {
            quad(
                p, [&](const Lane& l) { return reinterpret_cast<const std::int32_t*>(l.axes_a) + from; }, q);
            for (int i = first; i < 4; ++i) p.axes[(from + i) / 3][(from + i) % 3] = Unit::of(q[i]);
        };
        axes(0, 0), axes(4, 0), axes(5, 3);
        quad(
            p, [](const Lane& l) { return &l.limit; }, q);
        p.limit = Length::of(q[0]), p.reach = Length::of(q[1]), p.step_max = Length::of(q[2]),
        p.advances = mask_of(q[3]);
        quad(
            p, [](const Lane& l) { return &l.on_ground; }, q);
        p.on_ground = mask_of(q[0]), p.is_given = mask_of(q[1]);
        p.bad = Mask::none();
        for (int i = 0; i < 3; ++i) p.moved[i] = Length::splat(0), p.turned[i] = Unit::splat(0);
    }

    // ---- the pose of B ---

    /// True if x does not fit into `Bits` bits and a sign.
    template <int Bits> static Mask is_beyond(V x) {
        const V sign = L::template shift_right_signed<Bits>(x); // 0 or -1 when it fits
        return mask_of(L::either(L::greater32(sign, L::splat(0)), L::greater32(L::splat(-1), sign)));
    }

    /// conjugate(a) b.
    static void find_turn(Pairs& p) {
        V q[4];
        quad(
            p, [](const Lane& l) { return l.rotation_a; }, q);
        const Unit a[4] = {Unit::of(q[0]), Unit::of(q[1]), Unit::of(q[2]), Unit::of(q[3])};
        quad(
            p, [](const Lane& l) { return l.rotation_b; }, q);
        const Unit b[4] = {Unit::of(q[0]), Unit::of(q[1]), Unit::of(q[2]), Unit::of(q[3])};
        p.turn[0] = rounded<unit_bits>(a[3] * b[0] - a[0] * b[3] - a[1] * b[2] + a[2] * b[1]);
        p.turn[1] = rounded<unit_bits>(a[3] * b[1] + a[0] * b[2] - a[1] * b[3] - a[2] * b[0]);
        p.turn[2] = rounded<unit_bits>(a[3] * b[2] - a[0] * b[1] + a[1] * b[0] - a[2] * b[3]);
        p.turn[3] = rounded<unit_bits>(a[3] * b[3] + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    }

    /// The vector to B along A's axes, like collide::into_frame: d = high 2^16 + low, so that all products fit 64 bits.
    static void find_place(Pairs& p) {
        LaneFixed<L, 16> high[3];
        LaneFixed<L, 32> rest[3];
        const V part = L::splat(0xffff);
        Mask far = Mask::none();
        for (int i = 0; i < 3; ++i) {
            const V d = p.way[i].raw;
            far = far | is_beyond<47>(d);
            high[i] = LaneFixed<L, 16>::of(L::template shift_right<16>(d));
            rest[i] = LaneFixed<L, 32>::of(L::both(d, part));
        }
        p.bad = far;
        const auto most = Sum<length_bits>::splat(far_away);
        for (int i = 0; i < 3; ++i) {
            const Unit* axis = p.axes[i];
            const auto coarse = axis[0] * high[0] + axis[1] * high[1] + axis[2] * high[2];
            const auto fine = axis[0] * rest[0] + axis[1] * rest[1] + axis[2] * rest[2];
            p.at[i] = clamp(round_to<length_bits>(coarse + floor_to<unit_bits + 16>(fine)), far_away);
            p.at[i] = select(far, most, p.at[i]);
        }
        if (!p.is_given.any()) return;
        V given[6];
        six(
            p, [](const Lane& l) { return &l.given; }, given);
        for (int i = 0; i < 3; ++i) p.at[i] = select(p.is_given, Sum<length_bits>{given[i]}, p.at[i]);
        p.bad = p.bad & ~p.is_given;
    }

    // ---- the test for recycling ---

    /// Clears the upper half of numbers that are not negative.
    template <int F> static Sum<F> clean(V low) { return {L::both(low, L::splat(0xffffffff))}; }
    /// An upper bound of the length of a vector, at most 1.12 times the length: the widest component plus half of the
    /// others. Within 2^31.
    template <int F> static Sum<F> length_above(const LaneFixed<L, F> (&x)[3]) {
        LaneFixed<L, F> size[3];
        for (int i = 0; i < 3; ++i) size[i] = max(x[i], -x[i]);
        const Sum<F> widest = clean<F>(max(size[0], max(size[1], size[2])).lanes());
        const Sum<F> others =
            clean<F>(size[0].lanes()) + clean<F>(size[1].lanes()) + clean<F>(size[2].lanes()) - widest;
        return widest + Sum<F>{L::template shift_right<1>(L::add(others.raw, L::splat(1)))};
    }

    /// B's turn since the manifold was made: the vector part of rotation conjugate(made), doubled.
    static Sum<unit_bits> find_turned(Pairs& p) {
        V made[4];
        quad(
            p, [](const Lane& l) { return l.made_rotation; }, made);
        const Unit *q = p.turn,
                   m[4] = {Unit::of(made[0]), Unit::of(made[1]), Unit::of(made[2]), Unit::of(made[3])};
        const auto cosine = q[3] * m[3] + q[0] * m[0] + q[1] * m[1] + q[2] * m[2];
        const Mask is_negative = Sum<2 * unit_bits>::splat(0) > cosine;
        const auto part = [&](Sum<2 * unit_bits> sum) {
            const Unit half = rounded<unit_bits>(sum);
            return select(is_negative, -half, half);
        };
        const Unit half[3] = {part(q[0] * m[3] - q[3] * m[0] + q[2] * m[1] - q[1] * m[2]),
                              part(q[1] * m[3] - q[3] * m[1] + q[0] * m[2] - q[2] * m[0]),
                              part(q[2] * m[3] - q[3] * m[2] + q[1] * m[0] - q[0] * m[1])};
        for (int i = 0; i < 3; ++i) p.turned[i] = half[i] + half[i];
        const auto size = length_above(half);
        return size + size;
    }

    static void find_shift(Pairs& p) {
        V kept[6];
        six(
            p, [](const Lane& l) { return &l.kept; }, kept);
        const auto limit = wide(p.limit);
        for (int i = 0; i < 3; ++i) {
            const auto moved = p.at[i] - Sum<length_bits>{kept[i]};
            p.bad = p.bad | is_beyond<47>(kept[i]) | (moved > limit) | (-limit > moved);
            p.moved[i] = low(moved);
        }
        const auto turn = find_turned(p);
        p.bad = p.bad | (turn > Sum<unit_bits>::splat(solve::recycling_turn.raw)); // so the product fits
        const auto by_turn = low(turn) * p.reach;
        const auto all = length_above(p.moved) +
                         Sum<length_bits>{L::template shift_right<unit_bits>(by_turn.raw)} +
                         Sum<length_bits>::splat(1);
        p.bad = p.bad | (all > limit);
    }

    // ---- the contact ---

    template <int F> static LaneFixed<L, F> saturated(Sum<F> x) {
        const auto most = Sum<F>::splat(INT32_MAX), least = Sum<F>::splat(INT32_MIN);
        const auto high = select(x > most, most, x);
        return low(select(least > high, least, high));
    }
    /// (a x b)[i].
    template <int F, int G>
    static Sum<F + G> cross(const LaneFixed<L, F> (&a)[3], const LaneFixed<L, G> (&b)[3], int i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        return a[j] * b[k] - a[k] * b[j];
    }
    template <int F> static Sum<F> half_of(Sum<F> x) { // rounded
        return {L::template shift_right_signed<1>(L::add(x.raw, L::splat(1)))};
    }
    template <int F> static Mask is_wider(const Sum<F> (&x)[3], Sum<F> limit) {
        Mask wider = Mask::none();
        for (int i = 0; i < 3; ++i) wider = wider | (x[i] > limit) | (-limit > x[i]);
        return wider;
    }

    /// The transform from points, in A's axes and relative to B's origin, to levers:
    ///   at the start of the tick   rB = R p + b,  rA = rB + k     R: A's axes, b and k from the centres of the bodies
    /// Levers are then moved to the middle of the tick, since a point between corners and faces moves with them: with
    /// the levers of the start of the tick, a body that falls over would gain its speed half a tick late. Round shapes
    /// roll over their points, so their levers stay. On a ground (A), the corners are those of B; between two bodies,
    /// the point moves with the mean of both:
    ///   velocity c on a ground     vB + wB x rB                   rB += (c - vB) h,  rA += (c - vA) h,  h: half a tick
    ///   velocity c of two bodies   (vA + wA x rA + vB + wB x rB) / 2
    /// Both cases have the form rB += U x rB + s and rA = rB + k + (vB - vA) h, so only R, b and k change, once for all
    /// points.
    struct Frame {
        Unit axes[3][3];
        Sum<length_bits> base_b[3], to_a[3];
    };

    static void find_frame(const Pairs& p, Unit half_tick, Frame& f) {
        V kept[6];
        six(
            p, [](const Lane& l) { return &l.kept; }, kept);
        for (int i = 0; i < 3; ++i) {
            f.base_b[i] = {kept[3 + i]};
            const auto to_b =
                half_of(floor_to<length_bits + 1>(p.way[3 + i])); // rounded, without leaving 64 bits
            f.to_a[i] = wide(saturated(Sum<length_bits>{to_b.raw})) - f.base_b[i];
            for (int c = 0; c < 3; ++c) f.axes[c][i] = p.axes[c][i];
        }
        if (p.advances.any()) advance(p, half_tick, f);
    }

    struct Motion {
        Speed linear[3], angular[3];
    };
    template <class Of> static Motion motion_of(const Pairs& p, Of&& of) {
        V first[4], last[4];
        quad(p, of, first);
        quad(
            p, [&](const Lane& l) { return reinterpret_cast<const std::int32_t*>(of(l)) + 2; }, last);
        return {{Speed::of(first[0]), Speed::of(first[1]), Speed::of(first[2])},
                {Speed::of(first[3]), Speed::of(last[2]), Speed::of(last[3])}};
    }

    static void advance(const Pairs& p, Unit half_tick, Frame& f) {
        const Motion a = motion_of(p, [](const Lane&l) { return l.velocity_a; }),
                     b = motion_of(p, [](const Lane&l) { return l.velocity_b; });
        const Mask between = ~p.on_ground;
        Sum<unit_bits> turn[3], turn_a[3];
        Sum<length_bits> gone[3], of_a[3]; // of b relative to a
        for (int i = 0; i < 3; ++i) {
            turn[i] = floor_to<unit_bits>(b.angular[i] * half_tick);
            turn_a[i] = floor_to<unit_bits>(a.angular[i] * half_tick) & between;
            gone[i] = floor_to<length_bits>(b.linear[i] * half_tick - a.linear[i] * half_tick);
        }
        const auto most = Sum<unit_bits>::splat(turn_max);
        Mask goes = p.advances & ~(is_wider(turn, most) | is_wider(turn_a, most));
        Length to_a[3];
        Unit turns_a[3], turns[3];
        for (int i = 0; i < 3; ++i) {
            to_a[i] = low(f.to_a[i]), turns_a[i] = low(turn_a[i]);
            goes = goes & ~(between & is_beyond<31>(f.to_a[i].raw)); // not where bodies are 128 m apart
        }
        for (int i = 0; i < 3; ++i) of_a[i] = floor_to<length_bits>(cross(turns_a, to_a, i));
        const auto step_max = wide(p.step_max);
        goes = goes & (p.on_ground | ~(is_wider(of_a, step_max) | is_wider(gone, step_max)));
        Length base[3];
        for (int i = 0; i < 3; ++i) {
            turns[i] = low(select(p.on_ground, turn[i], half_of(turn[i] + turn_a[i]))) & goes;
            base[i] = low(f.base_b[i]);
        }
        for (int i = 0; i < 3; ++i) {
            const auto by = half_of(of_a[i] - gone[i]) & (goes & between);
            f.base_b[i] = f.base_b[i] + by + floor_to<length_bits>(cross(turns, base, i));
            f.to_a[i] = f.to_a[i] + (gone[i] & goes);
        }
        for (Unit(&column)[3] : f.axes) {
            const Unit was[3] = {column[0], column[1], column[2]};
            for (int i = 0; i < 3; ++i)
                column[i] = column[i] + low(floor_to<unit_bits>(cross(turns, was, i)));
        }
    }

    /// The change of a separation by a small move: n . (m + t x p) = n . m + (n x t) . p.
    struct Tilt {
        Sum<unit_bits + length_bits> along;
        Unit by[3];
    };
    static Tilt tilt_of(const Pairs& p, const Unit (&n)[3]) {
        Tilt tilt{n[0] * p.moved[0] + n[1] * p.moved[1] + n[2] * p.moved[2], {}};
        for (int i = 0; i < 3; ++i) tilt.by[i] = rounded<unit_bits>(cross(n, p.turned, i));
        return tilt;
    }

    /// Like quad(), from the manifolds.
    template <class Place> static void quad_of_rows(const Pairs& p, Place&& place, V (&out)[4]) {
        const std::int32_t* from[N];
        for (unsigned k = 0; k < N; ++k) from[k] = reinterpret_cast<const std::int32_t*>(place(*p.memory[k]));
        L::quads(from, out);
    }
    static const solve::ContactPointMemory* point_of(const solve::ContactMemory& m, std::uint32_t k) {
        return reinterpret_cast<const solve::ContactPointMemory*>(&m.points) + k;
    }
    static void write_quad(solve::PairContact* (&to)[N], unsigned at, const V (&x)[4]) {
        std::int32_t* out[N];
        for (unsigned k = 0; k < N; ++k) out[k] = reinterpret_cast<std::int32_t*>(to[k]) + 4 * at;
        L::store_quads(out, x);
    }

    static void make_contacts(const Pairs& p, const Frame& f, solve::PairContact* (&to)[N]) {
        V row[4];
        quad_of_rows(
            p, [](const solve::ContactMemory& m) { return &m.normal; }, row);
        const Unit n[3] = {Unit::of(row[0]), Unit::of(row[1]), Unit::of(row[2])};
        V out[4];
        for (int i = 0; i < 3; ++i)
            out[i] =
                rounded<unit_bits>(p.axes[0][i] * n[0] + p.axes[1][i] * n[1] + p.axes[2][i] * n[2]).lanes();
        out[3] = L::splat(0);
        write_quad(to, 0, out);
        const Tilt tilt = tilt_of(p, n);
        std::uint32_t count = 0;
        for (unsigned k = 0; k < N; ++k)
            if (const std::uint32_t own = p.memory[k]->count; own > count) count = own;
        for (std::uint32_t k = 0; k < count; ++k) {
            quad_of_rows(
                p, [k](const solve::ContactMemory& m) { return &point_of(m, k)->position; }, row);
            const Length at[3] = {Length::of(row[0]), Length::of(row[1]), Length::of(row[2])};
            // the last four numbers of the point: the memory after it may not belong to the manifold
            V then[4];
            quad_of_rows(
                p, [k](const solve::ContactMemory& m) { return &point_of(m, k)->position.z; }, then);
            const auto by = tilt.along + tilt.by[0] * at[0] + tilt.by[1] * at[1] + tilt.by[2] * at[2];
            V of_a[4], of_b[4];
            of_a[3] = saturated(sum_of<gap_bits>(then[2]) + round_to<gap_bits>(by)).lanes();
            of_b[3] = L::splat(0);
            for (int i = 0; i < 3; ++i) {
                const auto at_b =
                    f.base_b[i] +
                    round_to<length_bits>(f.axes[0][i] * at[0] + f.axes[1][i] * at[1] + f.axes[2][i] * at[2]);
                of_b[i] = saturated(at_b).lanes();
                of_a[i] = saturated(at_b + f.to_a[i]).lanes();
            }
            write_quad(to, 1 + 2 * k, of_a);
            write_quad(to, 2 + 2 * k, of_b);
        }
    }

    static void write_places(const Pairs& p, const Pass& pass, std::uint32_t first, unsigned count) {
        std::int64_t at[3][N];
        std::int32_t turn[4][N];
        for (int i = 0; i < 3; ++i) p.at[i].store64(at[i]);
        for (int i = 0; i < 4; ++i) p.turn[i].store(turn[i]);
        for (unsigned k = 0; k < count; ++k) {
            solve::PairPlace& place = pass.place[first + k];
            for (int i = 0; i < 3; ++i) place.position[i] = at[i][k];
            place.rotation.x.raw = turn[0][k], place.rotation.y.raw = turn[1][k];
            place.rotation.z.raw = turn[2][k], place.rotation.w.raw = turn[3][k];
        }
    }

    static void find_some(const Pass& pass, std::uint32_t first, unsigned count) {
        Pairs p;
        for (unsigned k = 0; k < N; ++k) {
            const solve::PairRow& row = pass.rows[first + (k < count ? k : 0)];
            p.lane[k] = row.pair, p.memory[k] = row.memory;
        }
        read(p);
        if (pass.work != solve::PairWork::fresh) {
            find_turn(p);
            find_place(p);
            write_places(p, pass, first, count);
        }
        if (pass.work == solve::PairWork::place) return;
        if (pass.work == solve::PairWork::recycle) find_shift(p);
        const unsigned bad = p.bad.lanes();
        solve::PairContact spare;
        solve::PairContact* to[N];
        for (unsigned k = 0; k < N; ++k) {
            const bool serves = k < count && ((bad >> k) & 1u) == 0;
            to[k] = serves ? &pass.contact[first + k] : &spare;
            if (k < count) pass.serves[first + k] = serves ? 1 : 0;
        }
        if (!(~p.bad).any()) return;
        Frame f;
        find_frame(p, Unit::splat(pass.half_tick.raw), f);
        make_contacts(p, f, to);
    }

    static void find(const Pass& pass) {
        for (std::uint32_t first = 0; first < pass.count; first += N)
            find_some(pass, first, pass.count - first < N ? pass.count - first : N);
    }

  public:
    static constexpr solve::PairKernel table() { return {find}; }
};

} // namespace lockstone::solve
