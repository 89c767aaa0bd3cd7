#include "solve/contacts/prepare.h"

#include "solve/contacts/pressed.h"

#include "lockstone/math/math.h"

#include <algorithm>
#include <bit>

namespace lockstone::solve {

namespace {

using solve::BodyMass;
using solve::BodyStep;
using solve::Contact;
using solve::ContactMemory;
using solve::ContactPoint;

constexpr std::int64_t unit = std::int64_t{1} << unit_bits;
constexpr std::int64_t row_limit = std::int64_t{4} << row_bits; ///< limit of a component of an angular row

std::int32_t low(std::int64_t x) { return static_cast<std::int32_t>(x); }

/// The share of each body in the pair's inverse mass, alpha + beta = 1; 0 for a body that impulses do not move.
struct ContactShares {
    std::int64_t a, b;
};

ContactShares shares_of(const BodyStep& a, const BodyStep& b) {
    if (!a.movable || !b.movable) return {a.movable ? unit : 0, b.movable ? unit : 0};
    std::int64_t ma = a.mass.raw, mb = b.mass.raw;
    if (a.pressed) ma = std::max(ma, mb / pressed_ratio);
    if (b.pressed) mb = std::max(mb, ma / pressed_ratio);
    // A little above one half: half of an odd impulse would always be rounded upwards, and resting boxes would creep.
    if (ma == mb) return {unit / 2 + 1, unit / 2 + 1};
    // alpha = mA^-1 / (mA^-1 + mB^-1) = mB / (mA + mB); both below 2^62.
    const int drop = std::max(static_cast<int>(std::bit_width(static_cast<std::uint64_t>(ma + mb))) - 33, 0);
    const std::int64_t alpha = ((mb >> drop) << unit_bits) / ((ma + mb) >> drop);
    return {alpha, unit - alpha};
}

/// Multiplies vectors in Length format by K^-1, to row_bits.
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

    const solve::Symmetric<std::int32_t>& m;
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
/// The responses of three rows to their own impulses: response_bits, below 52.
void respond(const Rows& rows, ContactShares shares, std::int64_t (&out)[3]) {
    constexpr int drop = 2 * row_bits - response_bits;
    for (int r = 0; r < 3; ++r)
        out[r] = shift_right_rounded((product(rows.xa[r], rows.xa[r]) >> drop) * shares.a +
                                         (product(rows.xb[r], rows.xb[r]) >> drop) * shares.b,
                                     unit_bits);
}

} // namespace

template <unsigned N> void clear_pack(ContactPack<N>& pack, std::uint32_t still_body, std::uint32_t points) {
    const std::span<PointLanes<N>> cleared = std::span(pack.points).first(std::max(points, 1u));
    const auto clear = [](void* from, void* to) {
        std::fill(static_cast<std::uint32_t*>(from), static_cast<std::uint32_t*>(to), 0u);
    };
    clear(&pack, cleared.data() + cleared.size());
    if (points > 1) clear(&pack.inverse, &pack + 1);
    for (unsigned lane = 0; lane < N; ++lane) pack.body_a[lane] = pack.body_b[lane] = still_body;
}

namespace {

/// The data that a pack has once, to which each lane adds.
struct PackHead {
    std::uint32_t movable_a = 0, movable_b = 0, keeps = 0, locked = 0, points = 0;
};

/// Contacts with a body that impulses do not move are stiffer.
const Softness& softness_of(const BodyStep& a, const BodyStep& b, const StepConstants& step) {
    return a.movable && b.movable ? step.soft : step.soft_static;
}

/// Fills the data that a contact has once: bodies, shares, softness, friction.
template <unsigned N>
void fill_head(ContactPack<N>& pack, PackHead& head, unsigned lane, const Contact& contact,
               const BodyStep& sa, const BodyStep& sb, const StepConstants& step) {
    const Softness& soft = softness_of(sa, sb, step);
    const ContactShares shares = shares_of(sa, sb);
    pack.body_a[lane] = contact.body_a, pack.body_b[lane] = contact.body_b;
    head.movable_a |= (sa.movable ? 1u : 0u) << lane, head.movable_b |= (sb.movable ? 1u : 0u) << lane;
    if ((sa.movable && sa.linear_mask != 7u) || (sb.movable && sb.linear_mask != 7u)) head.locked = 1;
    head.points = std::max(head.points, contact.count);
    pack.several[lane] = contact.count > 1 ? -1 : 0;
    const bool jointed = sa.jointed || sb.jointed;
    head.keeps |= (jointed && contact.restitution == Unit{} ? 1u : 0u) << lane;
    pack.share_a[lane] = low(shares.a), pack.share_b[lane] = low(shares.b);
    pack.bias_rate[lane] = soft.bias_rate.raw;
    pack.push[lane] = -(jointed ? step.push_jointed : step.push_speed_max).raw;
    pack.mass_scale[lane] = soft.mass_scale.raw, pack.impulse_scale[lane] = soft.impulse_scale.raw;
    pack.friction[lane] = contact.friction.raw;
}

/// The inertia of a body; zero for a body that does not move, whatever its entry has.
const BodyInertia& inertia_of(const BodyStep& step) {
    static constexpr BodyInertia nothing{};
    return step.moves ? step : nothing;
}

template <unsigned N>
void fill_lane(ContactPack<N>& pack, PackHead& head, PackSource& source, unsigned lane,
               const Contact& contact, const PrepareInput& in) {
    const BodyStep &sa = in.bodies.step[contact.body_a], &sb = in.bodies.step[contact.body_b];
    fill_head(pack, head, lane, contact, sa, sb, in.step);
    source.contacts[lane] = &contact;
    source.a[lane] = &inertia_of(sa), source.b[lane] = &inertia_of(sb);
    source.arms_of_b[lane] = sb.movable ? -1 : 0;
    source.ease[lane] = softness_of(sa, sb, in.step).ease.raw;
    const auto is_locked = [](const BodyStep& s) { return (s.linear_mask & s.angular_mask) != 7u; };
    source.has_locks = source.has_locks || (sa.movable && is_locked(sa)) || (sb.movable && is_locked(sb));
}

template <unsigned N> void leave_lane(PackSource& source, unsigned lane) {
    static const Contact nobody; // without points
    static constexpr BodyInertia nothing{};
    source.contacts[lane] = &nobody;
    source.a[lane] = source.b[lane] = &nothing;
    source.arms_of_b[lane] = source.ease[lane] = 0;
}

} // namespace

template <unsigned N>
void fill_pack(ContactPack<N>& pack, PackSource& source, const Contact* const (&contacts)[N],
               const PrepareInput& in) {
    source.has_locks = false;
    PackHead head;
    for (unsigned lane = 0; lane < N; ++lane)
        if (contacts[lane] != nullptr)
            fill_lane(pack, head, source, lane, *contacts[lane], in);
        else
            leave_lane<N>(source, lane);
    pack.movable_a = head.movable_a, pack.movable_b = head.movable_b, pack.keeps = head.keeps;
    pack.locked = head.locked, pack.point_count = static_cast<std::int32_t>(head.points);
}

void tangent_at_pole(const std::int32_t (&normal)[3], std::int32_t (&tangent)[3]) {
    const UnitVec3 n{Unit::from_raw(normal[0]), Unit::from_raw(normal[1]), Unit::from_raw(normal[2])};
    const UnitVec3 first = solve::tangents_of(n).first;
    for (int i = 0; i < 3; ++i) tangent[i] = first[i].raw;
}

void stretch_axis(std::int64_t member, std::int64_t farthest, std::int32_t ox, std::int32_t oy,
                  std::int32_t& fx, std::int32_t& fy) {
    if (member < farthest >> 8) { // the members are at one spot
        fx = ox, fy = oy;
        return;
    }
    const std::int64_t longer = (std::int64_t{isqrt(static_cast<std::uint64_t>(farthest))} << 26) /
                                std::int64_t{isqrt(static_cast<std::uint64_t>(member))}; // at most 16
    fx = low(shift_right_rounded(fx * longer, 26)), fy = low(shift_right_rounded(fy * longer, 26));
}

namespace {

/// The mass of a body. The still body, behind the last row, has none.
const BodyMass& mass_of(const solve::MassView& mass, std::uint32_t body) {
    static constexpr BodyMass nothing{};
    return body < mass.size() ? mass[body] : nothing;
}

/// The largest principal gyration radius, limited to four times the smallest: so rows stay within their format.
Real rolling_length(const BodyMass& mass) {
    const Vec3& k = mass.gyration;
    const Real least = min(k.x, min(k.y, k.z)), most = max(k.x, max(k.y, k.z));
    return min(most, least * 4);
}

} // namespace

void fill_rolling(Rolling& rolling, const Contact& contact, const PrepareInput& in) {
    const BodyStep &sa = in.bodies.step[contact.body_a], &sb = in.bodies.step[contact.body_b];
    const Real la = rolling_length(mass_of(in.mass, contact.body_a)),
               lb = rolling_length(mass_of(in.mass, contact.body_b));
    const Real length = !sa.movable ? lb : !sb.movable ? la : min(la, lb);
    const ContactShares shares = shares_of(sa, sb);
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
    const std::int32_t warm[3] = {in.memory[contact.memory].rolling.x.raw,
                                  in.memory[contact.memory].rolling.y.raw,
                                  in.memory[contact.memory].rolling.z.raw};
    for (int r = 0; r < 3; ++r) {
        if (s[r] < least_response) continue;
        for (int i = 0; i < 3; ++i) rolling.xa[r][i] = rows.xa[r][i], rolling.xb[r][i] = rows.xb[r][i];
        rolling.kappa[r] = low((std::int64_t{1} << (kappa_bits + response_bits)) / s[r]);
        rolling.impulse[r] = std::clamp(warm[r], -impulse_limit, impulse_limit);
    }
    rolling.bound = low(std::min(divide_shifted(contact.rolling.raw, length.raw, unit_bits), row_limit));
}

template void clear_pack(ContactPack<1>&, std::uint32_t, std::uint32_t);
template void fill_pack(ContactPack<1>&, PackSource&, const Contact* const (&)[1], const PrepareInput&);
template void clear_pack(ContactPack<2>&, std::uint32_t, std::uint32_t);
template void fill_pack(ContactPack<2>&, PackSource&, const Contact* const (&)[2], const PrepareInput&);
template void clear_pack(ContactPack<4>&, std::uint32_t, std::uint32_t);
template void fill_pack(ContactPack<4>&, PackSource&, const Contact* const (&)[4], const PrepareInput&);
template void clear_pack(ContactPack<8>&, std::uint32_t, std::uint32_t);
template void fill_pack(ContactPack<8>&, PackSource&, const Contact* const (&)[8], const PrepareInput&);

} // namespace lockstone::solve
