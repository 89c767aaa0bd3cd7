// Computes the positions of the points of contacts, and the linear fit over them. Written once over the lanes L; see
// kernel.h for the files that may include it, contact_solver.h for the symbols, and pack.h for the formats.
//
// Values of more than 32 bits are LaneSum. Divisions and roots are computed lane by lane.
#pragma once

#include "math/roots.h"
#include "solve/contacts/input_kernel.h"
#include "solve/contacts/pack.h"
#include "solve/lanes/lane_fixed.h"

#include <bit>
#include <cstdint>

namespace lockstone::solve {

template <class L> class LayoutKernel {
    static constexpr unsigned N = L::lanes;
    static constexpr int length_bits = 24, flat_bits = 28, moment_bits = 28, gram_bits = fit_bits;
    using Pack = ContactPack<N>;
    using Input = ContactInput<L>;
    using V = typename L::V;
    using Mask = LaneMask<L>;
    using Speed = LaneFixed<L, speed_bits>;
    using Unit = LaneFixed<L, unit_bits>;
    using Gap = LaneFixed<L, gap_bits>;
    using Fit = LaneFixed<L, fit_bits>;
    using Length = LaneFixed<L, length_bits>;
    using Flat = LaneFixed<L, flat_bits>;
    using Count = LaneFixed<L, 0>;
    template <int F> using Sum = LaneSum<L, F>;
    using Lanes64 = std::int64_t[N];

    static constexpr std::int32_t unit = 1 << unit_bits;
    static constexpr std::int64_t entry_limit = std::int64_t{1} << 30; ///< limit of an entry of H

    static bool has(unsigned lanes, unsigned lane) { return ((lanes >> lane) & 1u) != 0; }
    static Unit by_count(const std::int32_t (&table)[5], const std::int32_t (&count)[N]) {
        Lanes64 x;
        for (unsigned lane = 0; lane < N; ++lane) x[lane] = table[count[lane]];
        return Unit::of(L::from_lanes(x));
    }

  public:
    /// The points of a contact in its plane. Members are the points within 1 mm of the nearest, and those that carry.
    struct Layout {
        Mask exists[4], member[4], several; ///< several: more than one point
        std::int32_t members[N];            ///< number of members
        Length centre_a[3], centre_b[3];    ///< levers of the members' centre
        /// [0]: from the centre to the farthest point, in the plane; [1]: [0] turned by a right angle
        Length along[2][3];
        Length size; ///< |along|
        /// in units of `along`, within 1; unset where no contact of the pack has several points
        Sum<unit_bits> arm[2][4];
    };
    /// H H^T: the entry of the level, then the entries of the tilts by rows of the lower triangle.
    struct Gram {
        Sum<gram_bits> of[4];
        Mask plane; ///< the members lie neither at one spot nor on a line
        Mask tilts; ///< the fit has a first tilt: some member is away from the centre
    };

    static void lay_out(const Input& in, int points, Layout& l) {
        find_members(in, points, l);
        find_centre(in.lever_a, points, l, l.centre_a);
        find_centre(in.lever_b, points, l, l.centre_b);
        l.size = Length::splat(0);
        if (points > 1) find_arms(in, points, l);
    }
    /// Writes H into the pack.
    static void fit_members(Pack& pack, int points, const Layout& l, Gram& g) {
        constexpr std::int32_t one = 1 << fit_bits, shares[5] = {one, one, one / 2, one / 3, one / 4};
        const Fit level{by_count(shares, l.members).raw};
        for (int k = 0; k < points; ++k) (level & l.member[k]).store(pack.points[k].fit[0]);
        g.of[0] = wide(level);
        g.of[1] = g.of[2] = g.of[3] = Sum<gram_bits>::splat(0);
        g.plane = g.tilts = Mask::none();
        if (points < 2) return;

        Sum<moment_bits> aa = Sum<moment_bits>::splat(0), ab = aa, bb = aa; // sums of at most 4
        for (int k = 0; k < points; ++k) {
            const auto a = low(floor_to<unit_bits - 1>(l.arm[0][k] & l.member[k])),
                       b = low(floor_to<unit_bits - 1>(l.arm[1][k] & l.member[k]));
            aa = aa + floor_to<moment_bits>(a * a);
            ab = ab + floor_to<moment_bits>(a * b);
            bb = bb + floor_to<moment_bits>(b * b);
        }
        // Members within a sixteenth of the arm count as one spot, members within a sixteenth of a line as on that
        // line.
        constexpr std::int64_t least = (std::int64_t{1} << moment_bits) / 128;
        const Mask counted =
            (Count::load(l.members) > Count::splat(1)) & (aa > Sum<moment_bits>::splat(least - 1));
        if (!counted.any()) return;
        const auto det = floor_to<moment_bits>(low(aa) * low(bb) - low(ab) * low(ab));
        const Mask line = counted & (Sum<moment_bits>{L::template shift_right_signed<8>(aa.raw)} > det);
        g.plane = counted & ~line;
        Lanes64 by, inverse_of;
        select(line, aa, det).store64(by);
        for (unsigned lane = 0; lane < N; ++lane)
            inverse_of[lane] =
                has(counted.lanes(), lane) ? (std::int64_t{1} << (moment_bits + fit_bits)) / by[lane] : 0;
        const Sum<fit_bits> inverse = Sum<fit_bits>::from_lanes(inverse_of); // below 2^41
        fit_plane(pack, points, l, aa, ab, bb, inverse, g);
        if (line.any()) fit_line(pack, points, l, line, inverse, g);
        Fit any = Fit::load(pack.points[0].fit[1]);
        for (int k = 1; k < points; ++k) any = {L::either(any.raw, Fit::load(pack.points[k].fit[1]).raw)};
        g.tilts = (any > Fit::splat(0)) | (Fit::splat(0) > any);
    }

  private:
    // ---- positions of the points ---

    static void find_members(const Input& in, int points, Layout& l) {
        const Count count = in.count;
        Gap nearest = in.separation[0];
        for (int k = 1; k < points; ++k) nearest = min(nearest, in.separation[k]);
        nearest = min(nearest, Gap::splat(0x7fffffff - member_gap));
        const Gap most = max(nearest, Gap::splat(0)) + Gap::splat(member_gap);
        V members = L::splat(0);
        for (int k = 0; k < points; ++k) {
            l.exists[k] = count > Count::splat(k);
            l.member[k] = (most > in.separation[k]) | (in.impulse[k] > Speed::splat(0));
            members = L::sub(members, l.member[k].whole());
        }
        l.several = count > Count::splat(1);
        L::store32(l.members, members);
    }

    /// The mean of the members' levers.
    static void find_centre(const Length (&lever)[4][3], int points, const Layout& l, Length (&centre)[3]) {
        constexpr std::int32_t inverse[5] = {unit, unit, unit / 2, unit / 3, unit / 4};
        const Unit by = by_count(inverse, l.members);
        const Mask many = Count::load(l.members) > Count::splat(1);
        for (int i = 0; i < 3; ++i) {
            Sum<length_bits> sum = Sum<length_bits>::splat(0); // below 2^33, so a quarter of it fits
            for (int k = 0; k < points; ++k) sum = sum + (wide(lever[k][i]) & l.member[k]);
            const auto quarter = low(floor_to<length_bits - 2>(sum));
            const auto mean = floor_to<length_bits>(quarter * by);
            centre[i] = low(select(many, mean, sum));
        }
    }

    /// Coordinates of the points along the tangents, relative to the members' centre, with levers from a body that
    /// moves; zero for single points.
    static void flatten(const Input& in, int points, const Layout& l, Sum<length_bits> (&x)[2][4]) {
        const Mask of_b = in.arms_of_b;
        for (int r = 0; r < 2; ++r) {
            // Both sums and their difference are below 2^62.
            Sum<length_bits + unit_bits> centre = Sum<length_bits + unit_bits>::splat(0);
            for (int i = 0; i < 3; ++i)
                centre = centre + select(of_b, l.centre_b[i], l.centre_a[i]) * in.d[r + 1][i];
            for (int k = 0; k < points; ++k) {
                auto sum = -centre;
                for (int i = 0; i < 3; ++i)
                    sum = sum + select(of_b, in.lever_b[k][i], in.lever_a[k][i]) * in.d[r + 1][i];
                x[r][k] = round_to<length_bits>(sum) & l.exists[k] & l.several;
            }
        }
    }

    /// The shift that moves the widest coordinate to 29 bits, plus 4: 0..33.
    static void find_scale(const Sum<length_bits> (&x)[2][4], int points, Lanes64& up) {
        V bits = L::splat(0);
        for (int r = 0; r < 2; ++r)
            for (int k = 0; k < points; ++k) {
                const V negative = L::greater64(L::splat(0), x[r][k].raw);
                bits = L::either(bits, L::sub(L::either(L::without(x[r][k].raw, negative),
                                                        L::without(negative, x[r][k].raw)),
                                              negative));
            }
        Lanes64 widest;
        L::store64(widest, bits);
        for (unsigned lane = 0; lane < N; ++lane)
            up[lane] =
                widest[lane] == 0 ? 4 : std::countl_zero(static_cast<std::uint64_t>(widest[lane])) - 31;
    }

    /// (fx, fy): the length is the distance of the farthest point, the direction leads to the farthest member. So the
    /// arms of members on a line lie on the first axis. `farthest`: the square of the length, in [1, 8) where there are
    /// several points.
    static void find_axis(const Flat (&x)[4], const Flat (&y)[4], int points, const Layout& l,
                          Sum<2 * flat_bits>& farthest, Flat& fx, Flat& fy, bool& stretched) {
        Sum<2 * flat_bits> square[4], member = Sum<2 * flat_bits>::splat(0);
        fx = fy = Flat::splat(0);
        for (int k = 0; k < points; ++k) {
            square[k] = x[k] * x[k] + y[k] * y[k];
            const Mask better = l.member[k] & (square[k] > member);
            member = select(better, square[k], member);
            fx = select(better, x[k], fx), fy = select(better, y[k], fy);
        }
        farthest = member;
        Flat ox = fx, oy = fy;
        for (int k = 0; k < points; ++k) {
            const Mask better = square[k] > farthest;
            farthest = select(better, square[k], farthest);
            ox = select(better, x[k], ox), oy = select(better, y[k], oy);
        }
        const unsigned uneven = (farthest > member).lanes();
        stretched = uneven != 0;
        if (!stretched) return;
        Lanes64 longest, longest_member;
        std::int32_t far_x[N], far_y[N], to_x[N], to_y[N];
        farthest.store64(longest), member.store64(longest_member);
        ox.store(far_x), oy.store(far_y), fx.store(to_x), fy.store(to_y);
        for (unsigned lane = 0; lane < N; ++lane)
            if (has(uneven, lane))
                stretch_axis(longest_member[lane], longest[lane], far_x[lane], far_y[lane], to_x[lane],
                             to_y[lane]);
        fx = Flat::load(to_x), fy = Flat::load(to_y);
    }

    static void find_arms(const Input& in, int points, Layout& l) {
        Sum<length_bits> wide_x[2][4];
        flatten(in, points, l, wide_x);
        Lanes64 up_by;
        find_scale(wide_x, points, up_by);
        const V up = L::from_lanes(up_by);
        Flat x[4], y[4];
        for (int k = 0; k < points; ++k) {
            x[k] = Flat::of(L::template shift_right<4>(L::shift_left_by(wide_x[0][k].raw, up)));
            y[k] = Flat::of(L::template shift_right<4>(L::shift_left_by(wide_x[1][k].raw, up)));
        }
        Sum<2 * flat_bits> farthest;
        Flat fx, fy;
        bool stretched = false;
        find_axis(x, y, points, l, farthest, fx, fy, stretched);

        Lanes64 square, inverse, root;
        farthest.store64(square);
        for (unsigned lane = 0; lane < N; ++lane) {
            const std::int64_t denominator = square[lane] >> 29;
            inverse[lane] = denominator == 0
                                ? 0
                                : (std::int64_t{1} << 58) / denominator; // 31 fraction bits, in [2^28, 2^31]
            root[lane] = square[lane];
        }
        const auto per_square = LaneFixed<L, 31>::of(L::from_lanes(inverse));
        const Mask is_one = LaneFixed<L, 31>::splat(0) > per_square; // 2^31 read as 32 bits
        for (int k = 0; k < points; ++k) {
            const auto arm = [&](Sum<2 * flat_bits> product) {
                if (stretched) product = clamp(product, (std::int64_t{1} << 59) - (1 << 28));
                const auto p = low(floor_to<flat_bits>(product)) * per_square;
                return floor_to<unit_bits>(clamp(select(is_one, -p, p), std::int64_t{1} << 59));
            };
            l.arm[0][k] = arm(x[k] * fx + y[k] * fy);
            l.arm[1][k] = arm(y[k] * fx - x[k] * fy);
        }
        detail::take_roots(root, N);
        const auto back = [&](V v) { // sizes beyond 128 m are clamped
            return low(clamp(Sum<length_bits>{L::shift_right_by(L::mul(v, L::splat(16)), up)}, 0x7fffffff));
        };
        const Length along_x = back(fx.lanes()), along_y = back(fy.lanes());
        l.size = back(L::load64(root));
        for (int i = 0; i < 3; ++i) {
            const Unit first = in.d[1][i], second = in.d[2][i];
            l.along[0][i] = rounded_within<length_bits>(first * along_x + second * along_y, 0x7fffffff);
            l.along[1][i] = rounded_within<length_bits>(second * along_x - first * along_y, 0x7fffffff);
        }
    }

    // ---- the linear fit over the members ---

    static void fit_plane(Pack& pack, int points, const Layout& l, Sum<moment_bits> aa, Sum<moment_bits> ab,
                          Sum<moment_bits> bb, Sum<fit_bits> inverse, Gram& g) {
        // A moment times the inverse determinant is 2^36 at most, so the products are below 2^63.
        const auto narrow = [&](Sum<moment_bits> moment) {
            return floor_to<gram_bits>(floor_to<moment_bits - 3>(moment) * floor_to<fit_bits - 5>(inverse)) &
                   g.plane;
        };
        g.of[1] = narrow(bb), g.of[2] = narrow(-ab), g.of[3] = narrow(aa);
        const auto quarter = [](auto x) { return low(floor_to<moment_bits - 2>(x)); };
        const auto qaa = quarter(aa), qab = quarter(ab), qbb = quarter(bb);
        for (int k = 0; k < points; ++k) {
            const auto a = low(floor_to<unit_bits - 2>(l.arm[0][k])),
                       b = low(floor_to<unit_bits - 2>(l.arm[1][k]));
            const auto entry = [&](auto x, std::int32_t(&out)[N]) { // x is below 4
                const auto value =
                    floor_to<fit_bits>(floor_to<unit_bits - 3>(x) * floor_to<fit_bits - 3>(inverse));
                low(clamp(value, entry_limit) & (l.member[k] & g.plane)).store(out);
            };
            entry(qbb * a - qab * b, pack.points[k].fit[1]);
            entry(qaa * b - qab * a, pack.points[k].fit[2]);
        }
    }
    static void fit_line(Pack& pack, int points, const Layout& l, Mask line, Sum<fit_bits> inverse, Gram& g) {
        g.of[1] = select(line, inverse, g.of[1]);
        for (int k = 0; k < points; ++k) {
            const auto value =
                clamp(floor_to<fit_bits>(floor_to<unit_bits - 2>(l.arm[0][k]) * inverse), entry_limit);
            Fit(select(line & l.member[k], low(value), Fit::load(pack.points[k].fit[1])))
                .store(pack.points[k].fit[1]);
        }
    }
};

} // namespace lockstone::solve
