// Preparing the block of a contact. See contact.h for the symbols.
#include "dynamics/block_matrix.h"
#include "dynamics/contact_rows.h"

#include <bit>
#include <limits>

namespace lockstone::dynamics {

namespace {

/// Points at most this much farther apart than the nearest, and those that carry, are members [m].
constexpr std::int32_t member_separation = decimal<Separation>("0.001").raw;
/// Points narrower than 1 / 16 of their length count as a line.
constexpr int thin_bits = 8;

using Raw3 = std::array<std::int64_t, 3>;

Raw3 raw(LengthVec3 v) { return {v.x.raw, v.y.raw, v.z.raw}; }
LengthVec3 length_vec(const Raw3& v) {
    return {Length::from_raw(saturate_to_int32(v[0])), Length::from_raw(saturate_to_int32(v[1])),
            Length::from_raw(saturate_to_int32(v[2]))};
}

/// Where the points of a contact lie in its plane.
struct Layout {
    LengthVec3 centre_a, centre_b; ///< levers of the members' centre
    LengthVec3 along[2];           ///< tangents as long as the arm [m]
    std::int64_t arm[2][4];        ///< a, b, 30 fraction bits, at most 1
    std::uint32_t members, count;
};

Raw3 member_mean(const Contact& contact, std::uint32_t members, std::uint32_t count, bool of_b) {
    Raw3 sum{};
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        const Raw3 lever = raw(of_b ? contact.points[k].lever_b : contact.points[k].lever_a);
        if ((members >> k) & 1u)
            for (std::size_t i = 0; i < 3; ++i) sum[i] += lever[i];
    }
    for (std::int64_t& x : sum) x /= static_cast<std::int64_t>(count);
    return sum;
}

/// Measured from the body that moves. False when the members do not span a line.
bool lay_out(const Contact& contact, std::uint32_t members, bool of_b, const UnitVec3 (&directions)[3],
             Layout& out) {
    out.members = members;
    out.count = static_cast<std::uint32_t>(std::popcount(members));
    if (out.count < 2) return false;
    out.centre_a = length_vec(member_mean(contact, members, out.count, false));
    out.centre_b = length_vec(member_mean(contact, members, out.count, true));
    std::int64_t most = 0;
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        const ContactPoint& point = contact.points[k];
        const LengthVec3 from = of_b ? point.lever_b - out.centre_b : point.lever_a - out.centre_a;
        for (int i = 0; i < 2; ++i) {
            out.arm[i][k] = dot<Length>(from, directions[i + 1]).raw;
            most = std::max(most, static_cast<std::int64_t>(magnitude(out.arm[i][k])));
        }
    }
    if (most == 0) return false;
    for (auto& arms : out.arm)
        for (std::uint32_t k = 0; k < contact.count; ++k) arms[k] = divide_shifted(arms[k], most, 30);
    for (int i = 0; i < 2; ++i) {
        const UnitVec3& t = directions[i + 1];
        const auto scaled_by = [&](Unit x) {
            return Length::from_raw(
                saturate_to_int32(shift_right_rounded(x.raw * most, Unit::fraction_bits)));
        };
        out.along[i] = {scaled_by(t.x), scaled_by(t.y), scaled_by(t.z)};
    }
    return true;
}

/// The linear fit over the members, and the directions (rows over D_0, D_1, D_2) that it sees: three, or two on a line.
struct Fit {
    std::int64_t h[3][4];    ///< 30 fraction bits
    std::int64_t axis[3][3]; ///< orthogonal, 30 fraction bits
    std::int64_t weight[3];  ///< sum over the members of (axis . (1, a, b))^2, 30 fraction bits
    int rank;
};

/// The axes of the members' second moments, the longer first: with them the fit is one division an entry.
void find_axes(const Layout& l, std::uint32_t points, Fit& out) {
    constexpr std::int64_t one = std::int64_t{1} << 30;
    std::int64_t saa = 0, sab = 0, sbb = 0; // up to 4
    for (std::uint32_t k = 0; k < points; ++k) {
        if (!((l.members >> k) & 1u)) continue;
        saa += shift_right_rounded(l.arm[0][k] * l.arm[0][k], 30);
        sab += shift_right_rounded(l.arm[0][k] * l.arm[1][k], 30);
        sbb += shift_right_rounded(l.arm[1][k] * l.arm[1][k], 30);
    }
    // tan of the doubled angle is 2 sab / (saa - sbb): half of it by the bisector of (r, 0) and (saa - sbb, 2 sab).
    std::int64_t x = (saa - sbb) >> 3, y = sab >> 2, u = one, v = 0; // below 2^30
    const std::int64_t r = std::int64_t{isqrt(static_cast<std::uint64_t>(x * x + y * y))};
    if (r > (one >> 12)) { // else round: any axes do
        if (x >= 0)
            x += r;
        else {
            const std::int64_t turned = r - x;
            x = y, y = turned; // across: (y, r - x) is along (r + x, y), and does not cancel
        }
        const std::int64_t size =
            std::int64_t{isqrt(static_cast<std::uint64_t>(x * x + y * y))}; // not 0: above r
        u = divide_shifted(x, size, 30);
        v = divide_shifted(y, size, 30);
    }
    const std::int64_t axes[3][3] = {{one, 0, 0}, {0, u, v}, {0, -v, u}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out.axis[i][j] = axes[i][j];
}

bool fit_members(const Layout& l, std::uint32_t points, Fit& out) {
    out = {};
    find_axes(l, points, out);
    std::int64_t along[3][4]{};
    for (int i = 0; i < 3; ++i)
        for (std::uint32_t k = 0; k < points; ++k) {
            if (!((l.members >> k) & 1u)) continue;
            along[i][k] =
                out.axis[i][0] + ((out.axis[i][1] * l.arm[0][k] + out.axis[i][2] * l.arm[1][k]) >> 30);
            out.weight[i] += (along[i][k] * along[i][k]) >> 30;
        }
    out.rank = out.weight[2] < (out.weight[1] >> thin_bits) ? 2 : 3;
    if (out.weight[1] < (std::int64_t{1} << 24)) return false;
    for (int i = 0; i < out.rank; ++i)
        for (std::uint32_t k = 0; k < points; ++k) {
            const std::int64_t part = divide_shifted(along[i][k], out.weight[i], 30); // up to 2^15
            for (int j = 0; j < 3; ++j)
                out.h[j][k] += narrow_rounded(Wide::product(out.axis[i][j], part), 30);
        }
    return true;
}

/// Three rows of a pair of bodies: linear parts, which may be nothing, and angular ones.
struct PairRows {
    std::int32_t d[3][3];
    Row xa[3], xb[3];
};

/// Clamped entries would not be linear any more.
bool is_clamped(const Row& row) {
    for (const std::int32_t x : row.x)
        if (magnitude(x) >= static_cast<std::uint64_t>(jacobian_limit)) return true;
    return false;
}

/// rows times the pair's inverse mass times rows: 30 fraction bits, below 2^36.
void couple(const PairRows& rows, const SolverBody& a, const SolverBody& b, Shares shares,
            std::int64_t (&out)[3][3]) {
    for (int r = 0; r < 3; ++r)
        for (int s = 0; s < 3; ++s) {
            std::int64_t qa = 0, qb = 0; // below 52 2^56
            for (int i = 0; i < 3; ++i) {
                const std::int64_t dd = std::int64_t{rows.d[r][i]} * rows.d[s][i];
                qa += (dd & a.keep[i]) + std::int64_t{rows.xa[r].x[i]} * rows.xa[s].x[i];
                qb += (dd & b.keep[i]) + std::int64_t{rows.xb[r].x[i]} * rows.xb[s].x[i];
            }
            out[r][s] = shift_right_rounded((qa >> 30) * shares.a + (qb >> 30) * shares.b, 26);
        }
}

/// axis_i . m axis_j
std::int64_t along_axes(const std::int64_t (&m)[3][3], const std::int64_t (&u)[3],
                        const std::int64_t (&v)[3]) {
    std::int64_t sum = 0;
    for (int i = 0; i < 3; ++i) {
        std::int64_t row = 0; // 37 bits times 31, thrice: each narrowed before
        for (int j = 0; j < 3; ++j) row += narrow_rounded(Wide::product(m[i][j], v[j]), 30);
        sum += narrow_rounded(Wide::product(u[i], row), 30);
    }
    return sum;
}

/// m^-1 scale over the first `rank` axes, back in the rows' own coordinates; false when it is singular or too large.
bool invert(const std::int64_t (&m)[3][3], const std::int64_t (&axis)[3][3], int rank,
            const std::int64_t (&extra)[3], std::int64_t scale, std::int32_t (&out)[6]) {
    std::int64_t s[3][3]{}, most = 0;
    for (int i = 0; i < rank; ++i) {
        for (int j = 0; j <= i; ++j) s[i][j] = along_axes(m, axis[i], axis[j]);
        s[i][i] += extra[i];
        most = std::max(most, s[i][i]);
    }
    const Scaled top = scaled(most, 30);
    if (top.m == 0 || top.exponent > 29) return false;
    SymmetricBlock block{};
    block.exponent = top.exponent;
    for (int i = 0; i < rank; ++i)
        for (int j = 0; j <= i; ++j) {
            if (magnitude(s[i][j]) > static_cast<std::uint64_t>(most)) return false;
            block.m[block_index(i, j)] = s[i][j] * (std::int64_t{1} << (30 - top.exponent));
        }
    BlockFactor factor{};
    if (!factorise(block, rank, factor)) return false;
    std::int64_t inverse[3][3]{};
    for (int i = 0; i < rank; ++i) {
        std::int64_t x[6]{};
        x[i] = std::int64_t{1} << block_speed_bits;
        solve(factor, rank, x);
        const int shift = block_speed_bits + 30 - block_inverse_entry_bits + top.exponent;
        if (shift < 1 || shift > 126) return false;
        for (int j = 0; j < rank; ++j) inverse[i][j] = narrow_rounded(Wide::product(x[j], scale), shift);
    }
    constexpr std::int64_t limit = std::int64_t{1} << 31;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) {
            std::int64_t sum = 0;
            for (int r = 0; r < rank; ++r)
                for (int c = 0; c < rank; ++c) {
                    const std::int64_t entry = c <= r ? inverse[r][c] : inverse[c][r];
                    if (magnitude(entry) >= static_cast<std::uint64_t>(limit)) return false;
                    sum += narrow_rounded(Wide::product(axis[r][i], (entry * axis[c][j]) >> 20), 40);
                }
            if (magnitude(sum) >= static_cast<std::uint64_t>(limit)) return false;
            out[block_index(i, j)] = static_cast<std::int32_t>(sum);
        }
    return true;
}

} // namespace

/// Angular rows of the block's six: D_0 and the tilts, and the slides with the twist. False when one is clamped.
static bool make_rows(const SolverBodies& bodies, const Contact& contact, const Layout& l,
                      const UnitVec3 (&directions)[3], PairRows& normal, PairRows& slide) {
    const BodyStep& sa = bodies.step[contact.body_a];
    const BodyStep& sb = bodies.step[contact.body_b];
    const auto set = [&](PairRows& rows, int r, LengthVec3 at_a, LengthVec3 at_b, UnitVec3 d) {
        if (sa.moves) rows.xa[r] = angular_row(sa, at_a, d, -1);
        if (sb.moves) rows.xb[r] = angular_row(sb, at_b, d, 1);
        return !is_clamped(rows.xa[r]) && !is_clamped(rows.xb[r]);
    };
    const auto line = [](PairRows& rows, int r, UnitVec3 d) {
        for (int i = 0; i < 3; ++i) rows.d[r][i] = to<Jacobian>(d[i]).raw;
    };
    line(normal, 0, directions[0]);
    line(slide, 0, directions[1]);
    line(slide, 1, directions[2]);
    return set(normal, 0, l.centre_a, l.centre_b, directions[0]) &&
           set(normal, 1, l.along[0], l.along[0], directions[0]) &&
           set(normal, 2, l.along[1], l.along[1], directions[0]) &&
           set(slide, 0, l.centre_a, l.centre_b, directions[1]) &&
           set(slide, 1, l.centre_a, l.centre_b, directions[2]) &&
           set(slide, 2, l.along[0], l.along[0], directions[2]);
}

/// What invert and couple found, as it is stored.
struct Entries {
    std::int32_t soft[6], rigid[6], slide[6], response[6], gamma;
};

template <unsigned N>
void store_block(BlockRows<N>& out, unsigned lane, std::uint32_t points, const Layout& layout, const Fit& fit,
                 const PairRows& normal, const PairRows& slide, const Entries& entries) {
    for (std::uint32_t k = 0; k < points; ++k)
        for (int i = 0; i < 3; ++i) {
            out.fit[i][k].lane[lane] =
                static_cast<std::int32_t>(shift_right_rounded(fit.h[i][k], 30 - fit_bits));
            if (i < 2) out.arm[i][k].lane[lane] = static_cast<std::int32_t>(layout.arm[i][k]);
        }
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < 3; ++i) {
            out.xa[r][i].lane[lane] = normal.xa[r].x[i];
            out.xb[r][i].lane[lane] = normal.xb[r].x[i];
            out.slide_a[r][i].lane[lane] = slide.xa[r].x[i];
            out.slide_b[r][i].lane[lane] = slide.xb[r].x[i];
        }
    for (int i = 0; i < 6; ++i) {
        out.response[i].lane[lane] = entries.response[i];
        out.soft[i].lane[lane] = entries.soft[i];
        out.rigid[i].lane[lane] = entries.rigid[i];
        out.slide[i].lane[lane] = entries.slide[i];
    }
    out.gamma.lane[lane] = entries.gamma;
    out.members.lane[lane] = static_cast<std::int32_t>(layout.members);
    out.count.lane[lane] = static_cast<std::int32_t>(layout.count);
}

template <unsigned N>
void fill_block(ContactPack<N>& pack, unsigned lane, const SolverBodies& bodies, const Contact& contact,
                const UnitVec3 (&directions)[3], Shares shares, const Softness& soft,
                std::int64_t inverse_min, std::int64_t inverse_mean) {
    std::uint32_t members = 0;
    std::int64_t nearest = std::numeric_limits<std::int32_t>::max();
    for (std::uint32_t k = 0; k < contact.count; ++k)
        nearest = std::min<std::int64_t>(nearest, contact.points[k].separation.raw);
    nearest = std::max<std::int64_t>(nearest, 0);
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        const PointPack<N>& point = pack.points[k];
        if (point.kappa[0].lane[lane] == 0) return;
        if (contact.points[k].separation.raw < nearest + member_separation || point.impulse[0].lane[lane] > 0)
            members |= 1u << k;
    }
    Layout layout;
    Fit fit;
    PairRows normal{}, slide{};
    if (!lay_out(contact, members, bodies.step[contact.body_b].movable, directions, layout) ||
        !fit_members(layout, contact.count, fit) ||
        !make_rows(bodies, contact, layout, directions, normal, slide))
        return;
    // gamma = k' / a2, and 1 / a2 = impulse_scale / (1 - impulse_scale)
    constexpr std::int64_t one = std::int64_t{1} << 30;
    if (soft.impulse_scale.raw >= one) return;
    const std::int64_t ease = divide_shifted(soft.impulse_scale.raw, one - soft.impulse_scale.raw, 30);
    const std::int64_t gamma = narrow_rounded(Wide::product(inverse_mean, ease), 30);
    const std::int64_t gamma_p = divide_shifted(gamma, inverse_min, block_inverse_entry_bits);
    if (magnitude(gamma_p) >= std::uint64_t{1} << 31) return;
    const SolverBody& a = bodies.body[contact.body_a];
    const SolverBody& b = bodies.body[contact.body_b];
    std::int64_t m[3][3], f[3][3], none[3]{}, extra[3]{};
    couple(normal, a, b, shares, m);
    couple(slide, a, b, shares, f);
    for (int i = 0; i < fit.rank; ++i) extra[i] = divide_shifted(gamma, fit.weight[i], 30);
    constexpr std::int64_t unit[3][3] = {{one, 0, 0}, {0, one, 0}, {0, 0, one}};
    Entries entries{};
    entries.gamma = static_cast<std::int32_t>(gamma_p);
    if (!invert(m, fit.axis, fit.rank, extra, inverse_min, entries.soft) ||
        !invert(m, fit.axis, fit.rank, none, inverse_min, entries.rigid) ||
        !invert(f, unit, 3, none, inverse_min, entries.slide))
        return;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) {
            const std::int64_t entry = divide_shifted(m[i][j], inverse_min, response_bits);
            if (magnitude(entry) >= std::uint64_t{1} << 30) return;
            entries.response[block_index(i, j)] = static_cast<std::int32_t>(entry);
        }
    for (const auto& row : fit.h) // at most 8: solve_all sums products of it
        for (const std::int64_t h : row)
            if (magnitude(h) >= std::uint64_t{1} << 33) return;
    store_block(pack.block, lane, contact.count, layout, fit, normal, slide, entries);
}

template void fill_block(ContactPack<1>&, unsigned, const SolverBodies&, const Contact&,
                         const UnitVec3 (&)[3], Shares, const Softness&, std::int64_t, std::int64_t);
template void fill_block(ContactPack<4>&, unsigned, const SolverBodies&, const Contact&,
                         const UnitVec3 (&)[3], Shares, const Softness&, std::int64_t, std::int64_t);

} // namespace lockstone::dynamics
