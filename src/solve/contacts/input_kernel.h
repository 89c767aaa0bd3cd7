// Reads contacts and the inertia of their bodies side by side, in rows of four numbers. Written once over the lanes L;
// see kernel.h for the files that may include it, and pack.h for the formats.
#pragma once

#include "solve/contacts/pack.h"
#include "solve/lanes/lane_fixed.h"

#include <cstddef>
#include <cstdint>

namespace lockstone::solve {

template <class L> struct ContactInput {
    static constexpr unsigned N = L::lanes;
    static constexpr int length_bits = 24;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Count = LaneFixed<L, 0>;
    using Speed = LaneFixed<L, speed_bits>;
    using Unit = LaneFixed<L, unit_bits>;
    using Gap = LaneFixed<L, gap_bits>;
    using Length = LaneFixed<L, length_bits>;

    /// The inertia and the locks of the bodies of one side.
    struct Side {
        typename L::Low inverse[6]; ///< mantissas of K^-1: xx, yy, zz, xy, xz, yz
        V shift;                    ///< 1..62: from the products of mantissas to rows
        typename L::Low turns[3];   ///< all ones for axes about which the body may turn
        V keep[3];                  ///< all ones for axes along which the body may move
    };

    Count count;            ///< number of points
    std::int32_t counts[N]; ///< `count` in memory
    Unit d[3][3];           ///< the normal; room for the tangents
    Speed surface_velocity[3];
    Length lever_a[4][3], lever_b[4][3]; ///< zero where the point is missing
    Gap separation[4];                   ///< the largest value where the point is missing
    Speed impulse[4], slide[2];          ///< of the last tick
    Length twist;
    Mask arms_of_b;
    LaneSum<L, unit_bits> ease;
    Side a, b;

    /// `points`: the largest number of points of any of the contacts.
    static void read(const PackSource& from, int points, ContactInput& in) {
        V x[4];
        read_row(from.contacts, 0, x);
        in.count = Count::of(x[3]);
        in.count.store(in.counts);
        read_row(from.contacts, 1, x);
        for (int i = 0; i < 3; ++i) in.d[0][i] = Unit::of(x[i]);
        read_row(from.contacts, 2, x);
        for (int i = 0; i < 2; ++i) in.slide[i] = Speed::of(x[2 + i]);
        read_row(from.contacts, 3, x);
        in.twist = Length::of(x[0]);
        for (int i = 0; i < 3; ++i) in.surface_velocity[i] = Speed::of(x[1 + i]);
        for (int k = 0; k < points; ++k) {
            const Mask exists = in.count > Count::splat(k);
            read_row(from.contacts, 4 + 2 * k, x);
            for (int i = 0; i < 3; ++i) in.lever_a[k][i] = Length::of(x[i]) & exists;
            in.separation[k] = select(exists, Gap::of(x[3]), Gap::splat(0x7fffffff));
            read_row(from.contacts, 5 + 2 * k, x);
            for (int i = 0; i < 3; ++i) in.lever_b[k][i] = Length::of(x[i]) & exists;
            in.impulse[k] = Speed::of(x[3]) & exists;
        }
        in.arms_of_b = Mask::load(from.arms_of_b);
        in.ease = LaneSum<L, unit_bits>::load(from.ease);
        read_side(from.a, from.has_locks, in.a), read_side(from.b, from.has_locks, in.b);
    }

  private:
    /// Row `at` of the numbers that each lane points to.
    template <class T> static void read_row(const T* const (&of)[PackSource::lanes_max], int at, V (&x)[4]) {
        const std::int32_t* row[N];
        for (unsigned lane = 0; lane < N; ++lane)
            row[lane] = reinterpret_cast<const std::int32_t*>(of[lane]) + 4 * at;
        L::quads(row, x);
    }
    static void read_side(const BodyInertia* const (&of)[PackSource::lanes_max], bool has_locks, Side& side) {
        V x[4];
        read_row(of, 0, x);
        for (int i = 0; i < 4; ++i) side.inverse[i] = packed<L>(x[i]);
        read_row(of, 1, x);
        for (int i = 0; i < 2; ++i) side.inverse[4 + i] = packed<L>(x[i]);
        const Count shift = Count::of(x[2]) + Count::splat(length_bits - row_bits);
        side.shift = wide(min(max(shift, Count::splat(1)), Count::splat(62))).raw;
        for (int i = 0; i < 3; ++i) side.turns[i] = Mask::all().raw, side.keep[i] = L::splat(-1);
        if (has_locks) read_locks(of, side);
    }
    [[gnu::noinline]] static void read_locks(const BodyInertia* const (&of)[PackSource::lanes_max],
                                             Side& side) {
        std::int32_t turns[3][N];
        std::int64_t keep[3][N];
        for (unsigned lane = 0; lane < N; ++lane)
            for (int i = 0; i < 3; ++i) {
                turns[i][lane] = (of[lane]->angular_mask >> i) & 1u ? -1 : 0;
                keep[i][lane] = (of[lane]->linear_mask >> i) & 1u ? -1 : 0;
            }
        for (int i = 0; i < 3; ++i) side.turns[i] = load_low<L>(turns[i]), side.keep[i] = L::load64(keep[i]);
    }
    // read_row() relies on these positions of members.
    static_assert(offsetof(BodyInertia, inv_exponent) == 6 * sizeof(std::int32_t));
    static_assert(offsetof(Contact, count) == 3 * sizeof(std::int32_t));
    static_assert(offsetof(Contact, normal) == 4 * sizeof(std::int32_t));
    static_assert(offsetof(Contact, tangent_1) == 10 * sizeof(std::int32_t));
    static_assert(offsetof(Contact, twist) == 12 * sizeof(std::int32_t));
    static_assert(offsetof(Contact, points) == 16 * sizeof(std::int32_t));
};

} // namespace lockstone::solve
