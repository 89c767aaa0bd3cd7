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

/// Symmetric, by rows of the lower triangle.
using Lower3 = std::int64_t[6];

/// The linear fit over the members. On a line it sees one direction of tilts, and `u`, `v` are that direction.
struct Fit {
    std::int64_t h[3][4]; ///< 30 fraction bits, below 2^39
    Lower3 gram;          ///< H H^T, 30 fraction bits, below 2^39; on a line level and tilt are its first two
    bool line;
    std::int64_t u, v; ///< 30 fraction bits
};

/// Second moments of the members.
struct Moments {
    std::int64_t aa, ab, bb; ///< 29 fraction bits, up to 2^31
};

Moments moments_of(const Layout& l, std::uint32_t points) {
    Moments m{};
    for (std::uint32_t k = 0; k < points; ++k) {
        if (!((l.members >> k) & 1u)) continue;
        const std::int64_t a = l.arm[0][k], b = l.arm[1][k];
        m.aa += (a * a) >> 31;
        m.ab += (a * b) >> 31;
        m.bb += (b * b) >> 31;
    }
    return m;
}

/// Of members that lie along (u, v), the longer axis of the moments.
void fit_line(const Layout& l, std::uint32_t points, const Moments& m, Fit& out) {
    // tan of the doubled angle is 2 ab / (aa - bb): half of it by the bisector of (r, 0) and (aa - bb, 2 ab).
    std::int64_t x = (m.aa - m.bb) >> 2, y = m.ab >> 1; // below 2^30
    const std::int64_t r = std::int64_t{isqrt(static_cast<std::uint64_t>(x * x + y * y))};
    if (x >= 0)
        x += r;
    else {
        const std::int64_t turned = r - x;
        x = y, y = turned; // across: (y, r - x) is along (r + x, y), and does not cancel
    }
    // Not 0: r is at least a quarter of the moments' difference, which is nearly all of them on a line.
    const std::int64_t size = std::int64_t{isqrt(static_cast<std::uint64_t>(x * x + y * y))};
    out.u = divide_shifted(x, size, 30);
    out.v = divide_shifted(y, size, 30);
    std::int64_t along[4]{}, weight = 0; // at least 1/2: the farthest arm is 1
    for (std::uint32_t k = 0; k < points; ++k) {
        if (!((l.members >> k) & 1u)) continue;
        along[k] = (out.u * l.arm[0][k] + out.v * l.arm[1][k]) >> 30;
        weight += (along[k] * along[k]) >> 30;
    }
    const std::int64_t inverse = divide_shifted(std::int64_t{1} << 30, weight, 30);
    for (std::uint32_t k = 0; k < points; ++k) {
        const std::int64_t part = (along[k] * inverse) >> 30;
        out.h[1][k] = (out.u * part) >> 30;
        out.h[2][k] = (out.v * part) >> 30;
    }
    out.gram[2] = inverse;
}

/// False when the members are all at one place.
bool fit_members(const Layout& l, std::uint32_t points, Fit& out) {
    out = {};
    const std::int64_t share = (std::int64_t{1} << 30) / l.count;
    for (std::uint32_t k = 0; k < points; ++k)
        if ((l.members >> k) & 1u) out.h[0][k] = share;
    out.gram[0] = share;
    const Moments m = moments_of(l, points);
    // Of moments p and q along the axes the determinant is p q, and p + q is at least 1/2.
    const std::int64_t sum = m.aa + m.bb, det = m.aa * m.bb - m.ab * m.ab; // 58 fraction bits, below 2^62
    if (sum < std::int64_t{1} << 28) return false;
    out.line = det < ((sum >> (thin_bits / 2)) * (sum >> (thin_bits / 2)));
    if (out.line) {
        fit_line(l, points, m, out);
        return true;
    }
    // m^-1, at most 2^9.
    const std::int64_t inverse =
        divide_shifted(std::int64_t{1} << 28, det, 62); // 32 fraction bits, below 2^44
    const std::int64_t aa = block_narrow<31>(block_product(m.bb, inverse)),
                       ab = -block_narrow<31>(block_product(m.ab, inverse)),
                       bb = block_narrow<31>(block_product(m.aa, inverse));
    for (std::uint32_t k = 0; k < points; ++k) {
        if (!((l.members >> k) & 1u)) continue;
        const std::int64_t a = l.arm[0][k], b = l.arm[1][k];
        out.h[1][k] = block_narrow<30>(block_product(aa, a) + block_product(ab, b));
        out.h[2][k] = block_narrow<30>(block_product(ab, a) + block_product(bb, b));
    }
    out.gram[2] = aa, out.gram[4] = ab, out.gram[5] = bb;
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
void couple(const PairRows& rows, const SolverBody& a, const SolverBody& b, Shares shares, Lower3& out) {
    for (int r = 0; r < 3; ++r)
        for (int s = 0; s <= r; ++s) {
            std::int64_t qa = 0, qb = 0; // below 52 2^56
            for (int i = 0; i < 3; ++i) {
                const std::int64_t dd = std::int64_t{rows.d[r][i]} * rows.d[s][i];
                qa += (dd & a.keep[i]) + std::int64_t{rows.xa[r].x[i]} * rows.xa[s].x[i];
                qb += (dd & b.keep[i]) + std::int64_t{rows.xb[r].x[i]} * rows.xb[s].x[i];
            }
            out[block_index(r, s)] = shift_right_rounded((qa >> 30) * shares.a + (qb >> 30) * shares.b, 26);
        }
}

/// m^-1 scale with block_inverse_entry_bits by cofactors, which are exact; false when it is singular or too large. Both
/// arguments have 30 fraction bits, scale is below 2^36. What is rounded in m counts as much in any other way.
bool invert(const Lower3& m, std::int64_t scale, std::int32_t (&out)[6]) {
    const std::int64_t most = std::max({m[0], m[2], m[5]});
    if (most <= 0) return false;
    const int drop = bit_length(static_cast<std::uint64_t>(most)) - 30;
    if (drop < -4 || drop > 25) return false;
    std::int64_t e[6];
    for (int i = 0; i < 6; ++i) {
        e[i] = drop <= 0 ? m[i] * (std::int64_t{1} << -drop) : m[i] >> drop;
        if (magnitude(e[i]) > std::uint64_t{1} << 30)
            return false; // of what is symmetric and positive none is
    }
    const std::int64_t c[6] = {e[2] * e[5] - e[4] * e[4], e[3] * e[4] - e[1] * e[5],
                               e[0] * e[5] - e[3] * e[3], e[1] * e[4] - e[2] * e[3],
                               e[1] * e[3] - e[0] * e[4], e[0] * e[2] - e[1] * e[1]};
    const std::int64_t det = block_narrow<30>(block_product(e[0], c[0]) + block_product(e[1], c[1]) +
                                              block_product(e[3], c[3])); // 60 fraction bits
    if (c[0] <= 0 || c[2] <= 0 || c[5] <= 0 || det < std::int64_t{1} << 32) return false;
    const std::int64_t factor = divide_shifted(scale, det, 58); // below 2^62
    for (int i = 0; i < 6; ++i) {
        const std::int64_t entry =
            shift_right_rounded(block_narrow<63>(block_product(c[i], factor)), 5 + drop);
        if (magnitude(entry) >= std::uint64_t{1} << 31) return false;
        out[i] = static_cast<std::int32_t>(entry);
    }
    return true;
}

/// As invert, of rows that see one direction of tilts only.
bool invert_line(const Lower3& m, const Fit& fit, const Lower3& extra, std::int64_t scale,
                 std::int32_t (&out)[6]) {
    const std::int64_t u = fit.u, v = fit.v;
    const auto turned = [](std::int64_t x, std::int64_t y) { // 37 bits times 31
        return narrow_rounded(Wide::product(x, y), 30);
    };
    const std::int64_t tilt = turned(u, turned(m[2], u) + 2 * turned(m[4], v)) + turned(v, turned(m[5], v));
    const Lower3 s = {m[0] + extra[0], turned(m[1], u) + turned(m[3], v), tilt + extra[2], 0, 0,
                      m[0] + extra[0]}; // the third stands for itself
    std::int32_t inverse[6];
    if (!invert(s, scale, inverse)) return false;
    const auto back = [](std::int64_t x, std::int64_t y) {
        return static_cast<std::int32_t>(shift_right_rounded(x * y, 30)); // |y| at most 1
    };
    out[0] = inverse[0];
    out[1] = back(inverse[1], u), out[3] = back(inverse[1], v);
    const std::int32_t along = back(inverse[2], u), across = back(inverse[2], v);
    out[2] = back(along, u), out[4] = back(along, v), out[5] = back(across, v);
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

/// (m + extra)^-1 and m^-1.
static bool invert_normals(const Lower3& m, const Fit& fit, const Lower3& extra, std::int64_t scale,
                           Entries& out) {
    constexpr Lower3 none{};
    if (fit.line)
        return invert_line(m, fit, extra, scale, out.soft) && invert_line(m, fit, none, scale, out.rigid);
    Lower3 soft;
    for (int i = 0; i < 6; ++i) soft[i] = m[i] + extra[i];
    return invert(soft, scale, out.soft) && invert(m, scale, out.rigid);
}

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
    Lower3 m, slides, extra;
    couple(normal, a, b, shares, m);
    couple(slide, a, b, shares, slides);
    for (int i = 0; i < 6; ++i) extra[i] = narrow_rounded(Wide::product(gamma, fit.gram[i]), 30);
    Entries entries{};
    entries.gamma = static_cast<std::int32_t>(gamma_p);
    if (!invert_normals(m, fit, extra, inverse_min, entries) || !invert(slides, inverse_min, entries.slide))
        return;
    const std::int64_t scale = divide_shifted(std::int64_t{1} << 30, inverse_min, 30); // at most 4
    for (int i = 0; i < 6; ++i) {
        const std::int64_t entry = narrow_rounded(Wide::product(m[i], scale), 60 - response_bits);
        if (magnitude(entry) >= std::uint64_t{1} << 30) return;
        entries.response[i] = static_cast<std::int32_t>(entry);
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
