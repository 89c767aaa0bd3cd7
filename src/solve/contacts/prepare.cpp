#include "solve/contacts/prepare.h"

#include "lockstone/math.h"

#include <algorithm>
#include <bit>

namespace lockstone::solve {

namespace {

using dynamics::BodyMass;
using dynamics::BodyStep;
using dynamics::Contact;
using dynamics::ContactMemory;
using dynamics::ContactPoint;
using dynamics::SolverBody;

constexpr std::int64_t unit = std::int64_t{1} << unit_bits;
constexpr std::int64_t row_limit = std::int64_t{4} << row_bits; ///< of a component of an angular row
/// Points at most this much farther apart than the nearest, and those that carry, are members [m].
constexpr std::int32_t member_gap = decimal<Separation>("0.001").raw;
/// A point that parts faster has bounced: the impulse that sent it off is none to start from [m/s].
constexpr std::int32_t leaving_speed = decimal<Speed>("0.25").raw;
/// What answers less than that to an impulse is left out: all of it is locked.
constexpr std::int64_t least_response = std::int64_t{1} << (response_bits - 2);

std::int64_t rounded(std::int64_t x, int shift) { return shift_right_rounded(x, shift); }
/// To nearest; d is positive. Towards zero, friction would give way a little in every tick.
std::int64_t divide_rounded(std::int64_t n, std::int64_t d) { return (n + (n < 0 ? -d : d) / 2) / d; }
std::int32_t low(std::int64_t x) { return static_cast<std::int32_t>(x); }

/// The share of each body in the pair's inverse mass, alpha + beta = 1; 0 for what impulses do not move.
struct Shares {
    std::int64_t a, b;
};

Shares shares_of(const PrepareInput& in, const Contact& c) {
    const bool a = in.bodies.step[c.body_a].movable, b = in.bodies.step[c.body_b].movable;
    if (!a || !b) return {a ? unit : 0, b ? unit : 0};
    const std::int64_t ma = in.mass[c.body_a].mass.raw, mb = in.mass[c.body_b].mass.raw;
    // A hair above one half: half of an odd impulse would be rounded upwards whatever its sign, and resting boxes creep.
    if (ma == mb) return {unit / 2 + 1, unit / 2 + 1};
    // alpha = mA^-1 / (mA^-1 + mB^-1) = mB / (mA + mB); both below 2^62.
    const int drop = std::max(static_cast<int>(std::bit_width(static_cast<std::uint64_t>(ma + mb))) - 33, 0);
    const std::int64_t alpha = ((mb >> drop) << unit_bits) / ((ma + mb) >> drop);
    return {alpha, unit - alpha};
}

Raw3 raw(LengthVec3 v) { return {v.x.raw, v.y.raw, v.z.raw}; }
Raw3 raw(UnitVec3 v) { return {v.x.raw, v.y.raw, v.z.raw}; }

/// x . y, unit_bits taken off.
std::int64_t dot(const Raw3& x, const Raw3& y) {
    return rounded(x[0] * y[0] + x[1] * y[1] + x[2] * y[2], unit_bits);
}

/// K^-1 times vectors of Length format, to row_bits.
class Turner {
  public:
    explicit Turner(const BodyStep& body)
        : m(body.inv_mantissa), moves(body.moves), masked(body.angular_mask != 7u),
          shift(std::clamp(body.inv_exponent + Length::fraction_bits - row_bits, 1, 62)),
          half(std::int64_t{1} << (shift - 1)) {
        for (int i = 0; i < 3; ++i) mask[i] = (body.angular_mask >> i) & 1u ? -1 : 0;
    }
    /// Mantissas are below 2^30, so sums stay below 2^63.
    void row(const Raw3& c, std::int64_t sign, std::int32_t (&out)[3]) const {
        out[0] = out[1] = out[2] = 0;
        if (!moves) return;
        Raw3 r = c;
        if (masked || !fits(c, 0x7fffffff))
            for (std::size_t i = 0; i < 3; ++i) r[i] = saturate_to_int32(c[i]) & mask[i];
        Raw3 v = {(m.xx * r[0] + m.xy * r[1] + m.xz * r[2] + half) >> shift,
                  (m.xy * r[0] + m.yy * r[1] + m.yz * r[2] + half) >> shift,
                  (m.xz * r[0] + m.yz * r[1] + m.zz * r[2] + half) >> shift};
        if (!fits(v, row_limit))
            for (std::int64_t& x : v) x = std::clamp(x, -row_limit, row_limit);
        for (std::size_t i = 0; i < 3; ++i) out[i] = low(sign * v[i]);
    }

  private:
    static bool fits(const Raw3& x, std::int64_t limit) {
        const auto over = [&](std::int64_t v) { return static_cast<std::uint64_t>(v + limit); };
        const std::uint64_t range = static_cast<std::uint64_t>(2 * limit);
        return over(x[0]) <= range && over(x[1]) <= range && over(x[2]) <= range;
    }

    const dynamics::Symmetric<std::int32_t>& m;
    std::int64_t mask[3];
    bool moves, masked;
    int shift;
    std::int64_t half;
};

/// Three angular rows of a pair of bodies.
struct Rows {
    std::int32_t xa[3][3], xb[3][3];
};

std::int64_t product(const std::int32_t (&x)[3], const std::int32_t (&y)[3]) {
    return std::int64_t{x[0]} * y[0] + std::int64_t{x[1]} * y[1] + std::int64_t{x[2]} * y[2];
}
/// What three rows answer to their own impulses: response_bits, below 52.
void respond(const Rows& rows, Shares shares, std::int64_t (&out)[3]) {
    constexpr int drop = 2 * row_bits - response_bits;
    for (int r = 0; r < 3; ++r)
        out[r] = rounded((product(rows.xa[r], rows.xa[r]) >> drop) * shares.a +
                             (product(rows.xb[r], rows.xb[r]) >> drop) * shares.b,
                         unit_bits);
}

std::uint32_t members_of(const Contact& c, const ContactMemory& memory) {
    std::int64_t nearest = 0x7fffffff;
    for (std::uint32_t k = 0; k < c.count; ++k) nearest = std::min<std::int64_t>(nearest, c.points[k].separation.raw);
    const std::int64_t most = std::max<std::int64_t>(nearest, 0) + member_gap;
    std::uint32_t members = 0;
    for (std::uint32_t k = 0; k < c.count; ++k)
        if (c.points[k].separation.raw < most || memory.points[k].normal > Speed{}) members |= 1u << k;
    return members;
}

Raw3 mean(const Contact& c, std::uint32_t members, std::uint32_t count, bool of_b) {
    constexpr std::int64_t inverse[5] = {unit, unit, unit / 2, unit / 3, unit / 4};
    Raw3 sum{};
    for (std::uint32_t k = 0; k < c.count; ++k) {
        if (!((members >> k) & 1u)) continue;
        const Raw3 lever = raw(of_b ? c.points[k].lever_b : c.points[k].lever_a);
        for (std::size_t i = 0; i < 3; ++i) sum[i] += lever[i];
    }
    if (count > 1) // below 2^34 times 2^30 / count
        for (std::int64_t& x : sum) x = (x >> 2) * inverse[count] >> (unit_bits - 2);
    return sum;
}

/// (fx, fy): as long as the farthest point is away, towards the farthest member. Arms of members on a line so lie on the
/// first axis.
void find_axis(const std::int64_t (&x)[4], const std::int64_t (&y)[4], std::uint32_t count, std::uint32_t members,
               std::int64_t& farthest, std::int64_t& fx, std::int64_t& fy) {
    std::int64_t member = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
        const std::int64_t square = x[k] * x[k] + y[k] * y[k];
        if (((members >> k) & 1u) && square > member) member = square, fx = x[k], fy = y[k];
    }
    std::int64_t ox = fx, oy = fy;
    farthest = member;
    for (std::uint32_t k = 0; k < count; ++k) {
        const std::int64_t square = x[k] * x[k] + y[k] * y[k];
        if (square > farthest) farthest = square, ox = x[k], oy = y[k];
    }
    if (farthest == member) return;
    if (member < farthest >> 8) { // the members are at one spot
        fx = ox, fy = oy;
        return;
    }
    const std::int64_t longer = (std::int64_t{isqrt(static_cast<std::uint64_t>(farthest))} << 26) /
                                std::int64_t{isqrt(static_cast<std::uint64_t>(member))}; // at most 16
    fx = rounded(fx * longer, 26), fy = rounded(fy * longer, 26);
}

/// Arms are measured from the body that moves.
void lay_out(const Contact& c, const ContactMemory& memory, bool of_b, const Raw3 (&d)[3], Layout& out) {
    out = {};
    out.members = members_of(c, memory);
    out.count = static_cast<std::uint32_t>(std::popcount(out.members));
    out.centre_a = mean(c, out.members, out.count, false);
    out.centre_b = mean(c, out.members, out.count, true);
    if (c.count < 2) return;
    std::int64_t x[4], y[4], most = 0;
    for (std::uint32_t k = 0; k < c.count; ++k) {
        Raw3 from = raw(of_b ? c.points[k].lever_b : c.points[k].lever_a);
        for (std::size_t i = 0; i < 3; ++i) from[i] -= of_b ? out.centre_b[i] : out.centre_a[i];
        x[k] = dot(from, d[1]), y[k] = dot(from, d[2]); // below 2^33
        most = std::max({most, std::abs(x[k]), std::abs(y[k])});
    }
    if (most == 0) return;
    // To 29 bits: squares then have no more than 59.
    const int up = 29 - static_cast<int>(std::bit_width(static_cast<std::uint64_t>(most)));
    for (std::uint32_t k = 0; k < c.count; ++k) {
        x[k] = up >= 0 ? x[k] << up : x[k] >> -up;
        y[k] = up >= 0 ? y[k] << up : y[k] >> -up;
    }
    std::int64_t farthest = 0, fx = 0, fy = 0;
    find_axis(x, y, c.count, out.members, farthest, fx, fy);
    // 1 / |f|^2: farthest lies in [2^56, 2^59).
    const std::int64_t inverse = (std::int64_t{1} << 58) / (farthest >> 29); // 2^29 / (farthest / 2^58)
    for (std::uint32_t k = 0; k < c.count; ++k) {
        const auto arm = [&](std::int64_t product) { // below 2^59, times up to 2^31
            return std::clamp(((product >> 28) * inverse) >> 29, -unit, unit);
        };
        out.arm[0][k] = arm(x[k] * fx + y[k] * fy);
        out.arm[1][k] = arm(y[k] * fx - x[k] * fy);
    }
    out.size = std::int64_t{isqrt(static_cast<std::uint64_t>(farthest))};
    const auto back = [&](std::int64_t v) { return up >= 0 ? v >> up : v << -up; };
    fx = back(fx), fy = back(fy), out.size = back(out.size);
    for (std::size_t i = 0; i < 3; ++i) {
        out.along[0][i] = rounded(d[1][i] * fx + d[2][i] * fy, unit_bits);
        out.along[1][i] = rounded(d[2][i] * fx - d[1][i] * fy, unit_bits);
    }
}

constexpr int moment_bits = 28;
/// A moment times the inverse determinant, 2^36 at most.
std::int64_t narrow_gram(std::int64_t moment, std::int64_t inverse) { return (moment >> 3) * (inverse >> 5) >> (moment_bits - 8); }

/// H: the linear fit over the members. On a line it sees one direction of tilts; false then.
template <unsigned N>
bool fit_members(ContactPack<N>& pack, unsigned lane, const Layout& l, std::uint32_t points, Gram& gram) {
    std::int64_t aa = 0, ab = 0, bb = 0;
    for (std::uint32_t k = 0; k < points; ++k) {
        if (!((l.members >> k) & 1u)) continue;
        pack.points[k].fit[0][lane] = low((std::int64_t{1} << fit_bits) / l.count);
        const std::int64_t a = l.arm[0][k] >> 1, b = l.arm[1][k] >> 1; // 29 bits
        aa += (a * a) >> (2 * (unit_bits - 1) - moment_bits);
        ab += (a * b) >> (2 * (unit_bits - 1) - moment_bits);
        bb += (b * b) >> (2 * (unit_bits - 1) - moment_bits);
    }
    gram = {(std::int64_t{1} << fit_bits) / std::max(l.count, 1u), 0, 0, 0};
    // Members within a sixteenth of the arm count as one spot, those within a sixteenth of a line as on that line.
    if (l.count < 2 || aa < (std::int64_t{1} << moment_bits) / 128) return false;
    const std::int64_t det = (aa * bb - ab * ab) >> moment_bits; // of 4 * 4 at most
    const bool line = det < aa >> 8;
    const std::int64_t top = std::int64_t{1} << (moment_bits + fit_bits);
    const std::int64_t ia = line ? top / aa : 0, inverse = line ? 0 : top / det; // fit_bits; below 2^33
    if (line)
        gram[1] = ia;
    else
        gram = {gram[0], narrow_gram(bb, inverse), narrow_gram(-ab, inverse), narrow_gram(aa, inverse)};
    for (std::uint32_t k = 0; k < points; ++k) {
        if (!((l.members >> k) & 1u)) continue;
        constexpr std::int64_t most = std::int64_t{1} << 30;
        const std::int64_t a = l.arm[0][k], b = l.arm[1][k];
        if (line) {
            pack.points[k].fit[1][lane] = low(std::clamp((a >> 2) * ia >> (unit_bits - 2), -most, most));
            continue;
        }
        const std::int64_t along = ((bb >> 2) * (a >> 2) - (ab >> 2) * (b >> 2)) >> (moment_bits - 4);
        const std::int64_t across = ((aa >> 2) * (b >> 2) - (ab >> 2) * (a >> 2)) >> (moment_bits - 4);
        const auto entry = [&](std::int64_t x) { // x has unit_bits and is below 4
            return low(std::clamp((x >> 3) * (inverse >> 3) >> (unit_bits - 6), -most, most));
        };
        pack.points[k].fit[1][lane] = entry(along);
        pack.points[k].fit[2][lane] = entry(across);
    }
    return !line;
}

/// D v of the normal rows for the bodies as they are, speed_bits.
template <unsigned N>
std::int64_t speed_of(const ContactPack<N>& pack, unsigned lane, int r, const SolverBody& a, const SolverBody& b) {
    std::int64_t sum = 0;
    for (int i = 0; i < 3; ++i) {
        const auto part = [](std::int64_t v) { return std::int64_t{low(v >> row_bits)}; };
        if (r == 0) sum += pack.d[0][i][lane] * (part(b.v[i]) - part(a.v[i]));
        sum += pack.normal_a[r][i][lane] * part(a.u[i]) + pack.normal_b[r][i][lane] * part(b.u[i]);
    }
    return rounded(sum, row_bits);
}

template <unsigned N>
void fill_impulses(ContactPack<N>& pack, unsigned lane, const Contact& contact, const ContactMemory& memory,
                   const Layout& l, const SolverBody& a, const SolverBody& b) {
    bool carries = false, rests = false;
    for (std::uint32_t k = 0; k < contact.count; ++k) carries |= memory.points[k].normal > Speed{};
    if (!carries) return;
    std::int64_t speed[3] = {};
    for (int r = 0; r < (contact.count > 1 ? 3 : 1); ++r) speed[r] = speed_of(pack, lane, r, a, b);
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        const std::int64_t leaves = speed[0] + rounded(l.arm[0][k] * speed[1], unit_bits) +
                                    rounded(l.arm[1][k] * speed[2], unit_bits);
        if (leaves > leaving_speed) continue;
        const std::int32_t p = std::clamp(memory.points[k].normal.raw, 0, impulse_limit);
        pack.points[k].impulse[lane] = p;
        rests |= p > 0;
    }
    if (!rests) return;
    const auto within = [](std::int64_t x) { return low(std::clamp<std::int64_t>(x, -impulse_limit, impulse_limit)); };
    pack.slide[0][lane] = within(memory.tangent_1.raw);
    pack.slide[1][lane] = within(memory.tangent_2.raw);
    if (l.size > 0)
        pack.slide[2][lane] = within(divide_rounded(std::int64_t{memory.twist.raw} << speed_bits, l.size));
}

/// Returns the mean of the points' answers to their own impulses, response_bits.
template <unsigned N>
std::int64_t fill_points(ContactPack<N>& pack, unsigned lane, const Contact& contact, const Layout& l,
                 const std::int64_t (&s)[6]) {
    std::int64_t sum = 0;
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        PointLanes<N>& point = pack.points[k];
        point.gap0[lane] = point.gap[lane] = contact.points[k].separation.raw;
        const std::int64_t a = l.arm[0][k], b = l.arm[1][k];
        point.arm[0][lane] = low(a), point.arm[1][lane] = low(b);
        // arm^T S arm: S below 2^31, arms at most 2^30.
        const std::int64_t by_a = rounded(s[2] * a, unit_bits) + 2 * s[1];
        const std::int64_t by_b = rounded(s[5] * b, unit_bits) + 2 * s[3] + 2 * rounded(s[4] * a, unit_bits);
        const std::int64_t answer = s[0] + rounded(by_a * a, unit_bits) + rounded(by_b * b, unit_bits);
        sum += answer;
        if (answer >= least_response)
            point.kappa[lane] = low((std::int64_t{1} << (kappa_bits + response_bits)) / answer);
        if (contact.count > 1)
            point.reach[lane] = low(isqrt(static_cast<std::uint64_t>(a * a + b * b)));
    }
    return sum / contact.count;
}

/// X and (S + X)^-1. The softness of a pair that yields by `ease` of its impulse in a substep.
template <unsigned N>
void fill_softness(ContactPack<N>& pack, unsigned lane, const std::int64_t (&s)[6], const Gram& gram, std::int64_t mean,
                   const dynamics::Softness& soft) {
    constexpr std::int64_t most = std::int64_t{1} << 30;
    const std::int64_t ease = (std::int64_t{soft.impulse_scale.raw} << unit_bits) / std::max(soft.mass_scale.raw, 1);
    const std::int64_t gamma = rounded(mean * std::min(ease, unit), unit_bits); // response_bits, below 2^31
    std::int64_t sum[6] = {s[0], s[1], s[2], s[3], s[4], s[5]};
    constexpr int place[4] = {0, 2, 4, 5};
    for (std::size_t i = 0; i < 4; ++i) {
        const std::int64_t x = std::clamp((gamma * (gram[i] >> 4)) >> (fit_bits - 4), -most, most);
        pack.softness[i][lane] = low(x);
        if (s[place[i]] != 0 || i == 0) sum[place[i]] += x;
    }
    std::int32_t inverse[6];
    invert3(sum, inverse);
    for (int i = 0; i < 6; ++i) pack.soft_inverse[i][lane] = inverse[i];
}

} // namespace

void invert3(const std::int64_t (&m)[6], std::int32_t (&out)[6]) {
    // L D L^T; levels and lines first. Bits: factors 27 and 20, pivots response_bits.
    constexpr std::int64_t top = std::int64_t{1} << (response_bits + inverse_bits), least = (1 << 12) + 1, range = 0x7fffffff;
    for (std::int32_t& x : out) x = 0;
    std::int64_t d0 = 0, d1 = 0, d2 = 0, l10 = 0, l20 = 0, l21 = 0;
    if (m[0] >= least_response) {
        const std::int64_t inverse = (std::int64_t{1} << (response_bits + 28)) / m[0]; // 28 bits, at most 4
        d0 = inverse >> (28 - inverse_bits);
        l10 = rounded(m[1] * inverse, 26), l20 = rounded(m[3] * inverse, 26);
    }
    const std::int64_t p1 = m[2] - rounded(l10 * m[1], 27), e21 = m[4] - rounded(l20 * m[1], 27);
    std::int64_t p2 = m[5] - rounded(l20 * m[3], 27);
    if (p1 >= std::max(least, m[2] >> 10)) {
        d1 = top / p1;
        l21 = std::clamp(e21 * (1 << 20) / p1, -range, range);
        p2 -= rounded(l21 * e21, 20);
    }
    const std::int64_t l = rounded(l10 * l21, 27) - rounded(l20, 7); // of L^-1, 20 bits
    if (p2 >= std::max(least, m[5] >> 10) && std::abs(l) < range && std::abs(l21) < range) d2 = top / p2;
    for (;; d2 = 0) { // without the last row when its inverse leaves the format
        const std::int64_t i20 = rounded(l * d2, 20), i21 = -rounded(l21 * d2, 20);
        const bool fits = std::abs(i20) <= range && std::abs(i21) <= range;
        const std::int64_t i11 = fits ? d1 - rounded(l21 * i21, 20) : range + 1;
        const std::int64_t i10 = fits ? -rounded(l10 * d1, 27) - rounded(l21 * i20, 20) : 0;
        const std::int64_t i00 = fits ? d0 + rounded(l10 * rounded(l10 * d1, 27), 27) + rounded(l * i20, 20) : 0;
        const std::int64_t all[6] = {i00, i10, i11, i20, i21, d2};
        if (d2 == 0 || std::ranges::all_of(all, [](std::int64_t x) { return std::abs(x) <= range; })) {
            for (int i = 0; i < 6; ++i) out[i] = low(std::clamp(all[i], -range, range));
            return;
        }
    }
}

template <unsigned N> void clear_pack(ContactPack<N>& pack, std::uint32_t still_body) {
    pack = {};
    pack.bounce = none;
    for (unsigned lane = 0; lane < N; ++lane) {
        pack.body_a[lane] = pack.body_b[lane] = still_body;
        for (PointLanes<N>& point : pack.points) point.gap0[lane] = point.gap[lane] = 0x7fffffff;
    }
}

namespace {

using Directions = Raw3[3]; ///< normal and tangents

/// What a contact has once: bodies, shares, surface, softness.
template <unsigned N>
void fill_head(ContactPack<N>& pack, unsigned lane, const Contact& contact, const PrepareInput& in, Shares shares,
               const dynamics::Softness& soft, const dynamics::Tangents& tangents) {
    const bool a_moves = in.bodies.step[contact.body_a].movable, b_moves = in.bodies.step[contact.body_b].movable;
    const auto is_locked = [&](std::uint32_t body) {
        const std::int64_t(&keep)[3] = in.bodies.body[body].keep;
        return (keep[0] & keep[1] & keep[2]) == 0;
    };
    pack.body_a[lane] = contact.body_a, pack.body_b[lane] = contact.body_b;
    pack.movable_a |= (a_moves ? 1u : 0u) << lane, pack.movable_b |= (b_moves ? 1u : 0u) << lane;
    if ((a_moves && is_locked(contact.body_a)) || (b_moves && is_locked(contact.body_b))) pack.locked = 1;
    pack.point_count = std::max(pack.point_count, static_cast<std::int32_t>(contact.count));
    pack.several[lane] = contact.count > 1 ? -1 : 0;
    const bool jointed = in.bodies.step[contact.body_a].jointed || in.bodies.step[contact.body_b].jointed;
    pack.keeps |= (jointed && contact.restitution == Unit{} ? 1u : 0u) << lane;
    pack.share_a[lane] = low(shares.a), pack.share_b[lane] = low(shares.b);
    pack.bias_rate[lane] = soft.bias_rate.raw;
    pack.mass_scale[lane] = soft.mass_scale.raw, pack.impulse_scale[lane] = soft.impulse_scale.raw;
    pack.friction[lane] = contact.friction.raw;
    pack.surface[0][lane] = lockstone::dot<Speed>(contact.surface_velocity, tangents.first).raw;
    pack.surface[1][lane] = lockstone::dot<Speed>(contact.surface_velocity, tangents.second).raw;
}

/// K^-1 of one body, where it may turn and move.
template <unsigned N>
void fill_side(const BodyStep& step, const SolverBody& body, unsigned lane, std::int32_t (&inverse)[6][N], std::int64_t (&shift)[N],
               std::int32_t (&turns)[3][N], std::int64_t (&keep)[3][N]) {
    const dynamics::Symmetric<std::int32_t>& m = step.inv_mantissa;
    const std::int32_t entries[6] = {m.xx, m.yy, m.zz, m.xy, m.xz, m.yz};
    for (int i = 0; i < 6; ++i) inverse[i][lane] = entries[i];
    shift[lane] = std::clamp(step.inv_exponent + Length::fraction_bits - row_bits, 1, 62);
    for (int i = 0; i < 3; ++i) {
        turns[i][lane] = step.moves && ((step.angular_mask >> i) & 1u) ? -1 : 0;
        keep[i][lane] = body.keep[i];
    }
}

template <unsigned N>
void fill_row_input(ContactPack<N>& pack, RowInput<N>& rows, unsigned lane, const Contact& contact, const PrepareInput& in,
                    const Layout& l, const Directions& d) {
    const auto length = [](std::int64_t x) { return saturate_to_int32(x); }; // beyond 128 m levers are clamped
    for (std::size_t i = 0; i < 3; ++i) {
        for (int r = 0; r < 3; ++r) {
            rows.d[r][i][lane] = low(d[r][i]);
            pack.d[r][i][lane] = low(rounded(d[r][i], unit_bits - row_bits));
        }
        rows.centre_a[i][lane] = length(l.centre_a[i]), rows.centre_b[i][lane] = length(l.centre_b[i]);
        for (int r = 0; r < 2; ++r) rows.along[r][i][lane] = length(l.along[r][i]);
    }
    rows.size[lane] = length(l.size);
    fill_side(in.bodies.step[contact.body_a], in.bodies.body[contact.body_a], lane, rows.inverse_a, rows.shift_a, rows.turns_a, rows.keep_a);
    fill_side(in.bodies.step[contact.body_b], in.bodies.body[contact.body_b], lane, rows.inverse_b, rows.shift_b, rows.turns_b, rows.keep_b);
}

/// Whether any member is away from the middle of them all.
template <unsigned N> bool tilts(const ContactPack<N>& pack, unsigned lane) {
    std::int32_t any = 0;
    for (const PointLanes<N>& point : pack.points) any |= point.fit[1][lane];
    return any != 0;
}

} // namespace

template <unsigned N> void clear_rows(RowInput<N>& rows) {
    rows = {};
    for (unsigned lane = 0; lane < N; ++lane) rows.shift_a[lane] = rows.shift_b[lane] = 1;
}

template <unsigned N>
void begin_lane(ContactPack<N>& pack, RowInput<N>& rows, LaneWork& work, unsigned lane, const Contact& contact,
                const PrepareInput& in) {
    work.is_filled = contact.count != 0; // not filled in by tasks of the game's own that left an item out
    if (!work.is_filled) return;
    const BodyStep &sa = in.bodies.step[contact.body_a], &sb = in.bodies.step[contact.body_b];
    const dynamics::Tangents tangents = dynamics::tangents_of(contact.normal);
    const Directions d = {raw(contact.normal), raw(tangents.first), raw(tangents.second)};
    fill_head(pack, lane, contact, in, shares_of(in, contact), sa.movable && sb.movable ? in.step.soft : in.step.soft_static,
              tangents);
    lay_out(contact, in.memory[contact.memory], sb.movable, d, work.layout);
    pack.size[lane] = saturate_to_int32(work.layout.size);
    work.plane = fit_members(pack, lane, work.layout, contact.count, work.gram);
    fill_row_input(pack, rows, lane, contact, in, work.layout, d);
}

template <unsigned N>
void end_lane(ContactPack<N>& pack, const RowInput<N>& rows, const LaneWork& work, unsigned lane, const Contact& contact,
              const PrepareInput& in) {
    if (!work.is_filled) return;
    const bool both_move = in.bodies.step[contact.body_a].movable && in.bodies.step[contact.body_b].movable;
    const SolverBody &a = in.bodies.body[contact.body_a], &b = in.bodies.body[contact.body_b];
    const auto invert = [&](const std::int64_t (&s)[6], std::int32_t (&out)[6][N]) {
        std::int32_t inverse[6];
        invert3(s, inverse);
        for (int i = 0; i < 6; ++i) out[i][lane] = inverse[i];
    };
    std::int64_t s[6];
    for (int i = 0; i < 6; ++i) s[i] = pack.response[i][lane];
    const std::int64_t answer = fill_points(pack, lane, contact, work.layout, s);
    fill_impulses(pack, lane, contact, in.memory[contact.memory], work.layout, a, b);
    if (!tilts(pack, lane)) s[1] = s[2] = 0;
    if (!work.plane) s[3] = s[4] = s[5] = 0;
    invert(s, pack.inverse);
    fill_softness(pack, lane, s, work.gram, answer, both_move ? in.step.soft : in.step.soft_static);
    for (int i = 0; i < 6; ++i) s[i] = rows.slide_response[i][lane];
    invert(s, pack.slide_inverse);
}

template <unsigned N>
void fill_bounce(Bounce& bounce, const ContactPack<N>& pack, const Contact& contact) {
    bounce.restitution = contact.restitution.raw;
    for (int k = 0; k < 4; ++k) {
        bounce.approach[k] = bounce.impulse_max[k] = 0;
        bounce.taken[k] = 0;
        const std::int64_t kappa = pack.points[k].kappa[bounce.lane];
        bounce.inverse_mass[k] = kappa == 0 ? 0 : (std::int64_t{1} << (kappa_bits + response_bits)) / kappa;
    }
}

namespace {

/// The still body, behind the last, has none.
const BodyMass& mass_of(std::span<const BodyMass> mass, std::uint32_t body) {
    static constexpr BodyMass nothing{};
    return body < mass.size() ? mass[body] : nothing;
}

/// The largest principal gyration radius, but at most four times the smallest: rows then stay within their format.
Real rolling_length(const BodyMass& mass) {
    const Vec3& k = mass.gyration;
    const Real least = min(k.x, min(k.y, k.z)), most = max(k.x, max(k.y, k.z));
    return min(most, least * 4);
}

} // namespace

void fill_rolling(Rolling& rolling, const Contact& contact, const PrepareInput& in) {
    const BodyStep &sa = in.bodies.step[contact.body_a], &sb = in.bodies.step[contact.body_b];
    const Real la = rolling_length(mass_of(in.mass, contact.body_a)), lb = rolling_length(mass_of(in.mass, contact.body_b));
    const Real length = !sa.movable ? lb : !sb.movable ? la : min(la, lb);
    const Shares shares = shares_of(in, contact);
    if (length <= Real{} || shares.a + shares.b == 0) return;
    Rows rows{};
    const Turner ta(sa), tb(sb);
    const std::int64_t size = std::min<std::int64_t>(to<Coordinate>(length).raw, 0x7fffffff);
    for (std::size_t r = 0; r < 3; ++r) {
        Raw3 axis{};
        axis[r] = size;
        ta.row(axis, -1, rows.xa[r]), tb.row(axis, 1, rows.xb[r]);
    }
    std::int64_t s[3];
    respond(rows, shares, s);
    const std::int32_t warm[3] = {in.memory[contact.memory].rolling.x.raw, in.memory[contact.memory].rolling.y.raw,
                                  in.memory[contact.memory].rolling.z.raw};
    for (int r = 0; r < 3; ++r) {
        if (s[r] < least_response) continue;
        for (int i = 0; i < 3; ++i) rolling.xa[r][i] = rows.xa[r][i], rolling.xb[r][i] = rows.xb[r][i];
        rolling.kappa[r] = low((std::int64_t{1} << (kappa_bits + response_bits)) / s[r]);
        rolling.impulse[r] = std::clamp(warm[r], -impulse_limit, impulse_limit);
    }
    rolling.bound = low(std::min(divide_shifted(contact.rolling.raw, length.raw, unit_bits), row_limit));
}

template void clear_pack(ContactPack<1>&, std::uint32_t);
template void clear_pack(ContactPack<2>&, std::uint32_t);
template void clear_pack(ContactPack<4>&, std::uint32_t);
template void clear_rows(RowInput<1>&);
template void begin_lane(ContactPack<1>&, RowInput<1>&, LaneWork&, unsigned, const Contact&, const PrepareInput&);
template void end_lane(ContactPack<1>&, const RowInput<1>&, const LaneWork&, unsigned, const Contact&, const PrepareInput&);
template void clear_rows(RowInput<2>&);
template void begin_lane(ContactPack<2>&, RowInput<2>&, LaneWork&, unsigned, const Contact&, const PrepareInput&);
template void end_lane(ContactPack<2>&, const RowInput<2>&, const LaneWork&, unsigned, const Contact&, const PrepareInput&);
template void clear_rows(RowInput<4>&);
template void begin_lane(ContactPack<4>&, RowInput<4>&, LaneWork&, unsigned, const Contact&, const PrepareInput&);
template void end_lane(ContactPack<4>&, const RowInput<4>&, const LaneWork&, unsigned, const Contact&, const PrepareInput&);
template void fill_bounce(Bounce&, const ContactPack<1>&, const Contact&);
template void fill_bounce(Bounce&, const ContactPack<2>&, const Contact&);
template void fill_bounce(Bounce&, const ContactPack<4>&, const Contact&);

} // namespace lockstone::solve
