#include "dynamics/contact.h"

#include "base/poison.h"
#include "lockstone/math.h"

#include <algorithm>
#include <bit>

namespace lockstone::dynamics {

Tangents tangents_of(UnitVec3 normal) {
    const UnitVec3 first = any_perpendicular(normal);
    return {first, cross<Unit>(normal, first)};
}

void colour_contacts(std::span<const Contact> contacts, const SolverBodies& bodies,
                     std::vector<std::uint64_t>& body_colours, std::vector<std::uint32_t>& colour) {
    body_colours.assign(bodies.body.size(), 0);
    colour.resize(contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const std::uint32_t a = contacts[i].body_a, b = contacts[i].body_b;
        const bool a_moves = bodies.step[a].movable, b_moves = bodies.step[b].movable;
        const std::uint64_t taken = (a_moves ? body_colours[a] : 0) | (b_moves ? body_colours[b] : 0);
        const std::uint32_t c = std::min(static_cast<std::uint32_t>(std::countr_one(taken)), colour_max);
        colour[i] = c;
        if (c == colour_max) continue;
        if (a_moves) body_colours[a] |= std::uint64_t{1} << c;
        if (b_moves) body_colours[b] |= std::uint64_t{1} << c;
    }
}

// ---- preparing one point ------------------------------------------------------------------------------------------

namespace {

constexpr std::int64_t jacobian_limit = std::int64_t{4} << row_bits; ///< |x| per component

struct Row {
    std::int32_t x[3];
};

/// sign * K^-1 (r x d) with locked axes left out.
Row angular_row(const BodyStep& body, LengthVec3 lever, UnitVec3 d, std::int64_t sign) {
    const LengthVec3 c = cross<Length>(lever, d);
    const std::int64_t x = body.angular_mask & 1u ? c.x.raw : 0;
    const std::int64_t y = body.angular_mask & 2u ? c.y.raw : 0;
    const std::int64_t z = body.angular_mask & 4u ? c.z.raw : 0;
    const Symmetric<std::int32_t>& m = body.inv_mantissa;
    // 30 bits times 31 bits, three times: below 2^63.
    const std::int64_t sums[3] = {m.xx * x + m.xy * y + m.xz * z, m.xy * x + m.yy * y + m.yz * z,
                                  m.xz * x + m.yz * y + m.zz * z};
    const int shift = body.inv_exponent + Length::fraction_bits - row_bits;
    Row row{};
    for (int i = 0; i < 3; ++i) {
        const std::int64_t v = shift >= 63  ? 0
                               : shift >= 0 ? shift_right_rounded(sums[i], shift)
                                            : shift_left_saturated(sums[i], std::min(-shift, 63));
        row.x[i] = static_cast<std::int32_t>(sign * std::clamp(v, -jacobian_limit, jacobian_limit));
    }
    return row;
}

/// |d|^2 over the axes the body may move along, plus |x|^2, with 56 fraction bits.
std::int64_t row_length_squared(const SolverBody& body, const std::int32_t d[3], const Row& row) {
    std::int64_t sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += ((std::int64_t{d[i]} * d[i]) & body.keep[i]) + std::int64_t{row.x[i]} * row.x[i];
    return sum;
}

/// The share of each body in the pair's inverse mass: alpha + beta = 1; 0 for what impulses do not move.
struct Shares {
    std::int64_t a, b; ///< 30 fraction bits
};
Shares shares_of(const BodyMass& a, const BodyStep& sa, const BodyMass& b, const BodyStep& sb) {
    constexpr std::int64_t one = std::int64_t{1} << 30;
    if (!sa.movable && !sb.movable) return {0, 0};
    if (!sa.movable) return {0, one};
    if (!sb.movable) return {one, 0};
    // alpha = mA^-1 / (mA^-1 + mB^-1) = mB / (mA + mB)
    const std::int64_t alpha = divide_shifted(b.mass.raw, (a.mass + b.mass).raw, 30);
    return {alpha, one - alpha};
}

/// Rows that move nothing to speak of (all of it locked) are left out.
constexpr std::int64_t least_inverse_mass = std::int64_t{1} << 28; // 1/4 with 30 fraction bits

struct PointScalars {
    Row xa[3], xb[3];
    std::int64_t inverse[3]; ///< k' = effective inverse mass over the pair's, 30 fraction bits
    std::int64_t inverse_min;
};

PointScalars point_scalars(const SolverBodies& bodies, const Contact& contact, const ContactPoint& point,
                           const UnitVec3 directions[3], const std::int32_t d[3][3], Shares shares) {
    const BodyStep& sa = bodies.step[contact.body_a];
    const BodyStep& sb = bodies.step[contact.body_b];
    PointScalars p{};
    for (int r = 0; r < 3; ++r) {
        if (sa.moves) p.xa[r] = angular_row(sa, point.lever_a, directions[r], -1);
        if (sb.moves) p.xb[r] = angular_row(sb, point.lever_b, directions[r], 1);
        const std::int64_t qa = row_length_squared(bodies.body[contact.body_a], d[r], p.xa[r]);
        const std::int64_t qb = row_length_squared(bodies.body[contact.body_b], d[r], p.xb[r]);
        // 56 bits down to 26, times 30, at most 52 * 2^56; back to 30.
        p.inverse[r] = shift_right_rounded((qa >> 30) * shares.a + (qb >> 30) * shares.b, 26);
        if (p.inverse[r] >= least_inverse_mass && (p.inverse_min == 0 || p.inverse[r] < p.inverse_min))
            p.inverse_min = p.inverse[r];
    }
    return p;
}

std::int32_t speed_along(const SolverBody& a, const SolverBody& b, const std::int32_t d[3], const Row& xa,
                         const Row& xb) {
    std::int64_t sum = 0;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t dv = std::int64_t{static_cast<std::int32_t>(b.v[i] >> row_bits)} -
                                static_cast<std::int32_t>(a.v[i] >> row_bits);
        sum += d[i] * dv + std::int64_t{xa.x[i]} * static_cast<std::int32_t>(a.u[i] >> row_bits) +
               std::int64_t{xb.x[i]} * static_cast<std::int32_t>(b.u[i] >> row_bits);
    }
    return saturate_to_int32(shift_right_rounded(sum, row_bits));
}

constexpr std::int32_t impulse_limit = 1 << 30; ///< 2048 m/s
/// A point that parts faster has bounced: the impulse that sent it off is none to start from [m/s].
constexpr std::int32_t leaving_speed = decimal<Speed>("0.25").raw;

template <unsigned N>
void fill_point(PointPack<N>& pack, unsigned lane, const PointScalars& p, const ContactPoint& point,
                Shares shares, const Softness& soft, std::int32_t approach, const ContactPointMemory& warm) {
    pack.separation.lane[lane] = point.separation.raw;
    pack.approach.lane[lane] = approach;
    if (p.inverse_min == 0) return;
    for (int r = 0; r < 3; ++r) {
        for (int i = 0; i < 3; ++i) {
            pack.xa[r][i].lane[lane] = p.xa[r].x[i];
            pack.xb[r][i].lane[lane] = p.xb[r].x[i];
        }
        if (p.inverse[r] >= least_inverse_mass)
            pack.kappa[r].lane[lane] = saturate_to_int32(divide_shifted(p.inverse_min, p.inverse[r], 30));
    }
    pack.kappa_soft.lane[lane] = static_cast<std::int32_t>(
        shift_right_rounded(std::int64_t{pack.kappa[0].lane[lane]} * soft.mass_scale.raw, 30));
    pack.ratio_a.lane[lane] = saturate_to_int32(divide_shifted(shares.a, p.inverse_min, 30));
    pack.ratio_b.lane[lane] = saturate_to_int32(divide_shifted(shares.b, p.inverse_min, 30));
    if (approach > leaving_speed) return;
    // Remembered as lambda (1/mA + 1/mB); p = j k'min.
    const std::int32_t j[3] = {warm.normal.raw, warm.tangent_1.raw, warm.tangent_2.raw};
    for (int r = 0; r < 3; ++r) {
        const std::int64_t impulse = narrow_rounded(Wide::product(j[r], p.inverse_min), 30);
        pack.impulse[r].lane[lane] =
            static_cast<std::int32_t>(std::clamp<std::int64_t>(impulse, -impulse_limit, impulse_limit));
    }
}

/// The mean of the normal rows in `points`; see MeanRow.
template <unsigned N>
void fill_mean(MeanRow<N>& mean, unsigned lane, const SolverBodies& bodies, const Contact& contact,
               const std::int32_t normal[3], std::span<const PointScalars> points, Shares shares) {
    const std::int64_t n = static_cast<std::int64_t>(points.size());
    Row xa{}, xb{};
    for (int i = 0; i < 3; ++i) {
        std::int64_t a = 0, b = 0;
        for (const PointScalars& p : points) a += p.xa[0].x[i], b += p.xb[0].x[i];
        xa.x[i] = static_cast<std::int32_t>(a / n);
        xb.x[i] = static_cast<std::int32_t>(b / n);
    }
    const std::int64_t qa = row_length_squared(bodies.body[contact.body_a], normal, xa);
    const std::int64_t qb = row_length_squared(bodies.body[contact.body_b], normal, xb);
    const std::int64_t inverse = shift_right_rounded((qa >> 30) * shares.a + (qb >> 30) * shares.b, 26);
    if (inverse < least_inverse_mass) return;
    for (int i = 0; i < 3; ++i) {
        mean.xa[i].lane[lane] = xa.x[i];
        mean.xb[i].lane[lane] = xb.x[i];
    }
    mean.count_inv.lane[lane] = static_cast<std::int32_t>((std::int64_t{1} << 30) / n);
    for (std::size_t k = 0; k < points.size(); ++k)
        mean.share[k].lane[lane] = saturate_to_int32(divide_shifted(points[k].inverse_min, inverse * n, 30));
}

/// The still body, behind the last, has none.
const BodyMass& mass_of(std::span<const BodyMass> mass, std::uint32_t body) {
    static constexpr BodyMass none{};
    return body < mass.size() ? mass[body] : none;
}

/// L = the largest principal gyration radius, but at most four times the smallest, of the body that turns more easily:
/// rows then stay within their format.
Real rolling_length(const BodyMass& mass) {
    const Vec3& k = mass.gyration;
    const Real least = min(k.x, min(k.y, k.z)), most = max(k.x, max(k.y, k.z));
    return min(most, least * 4);
}

/// L K^-1 e for world axis `axis`, with locked axes left out.
Row rolling_row(const BodyStep& body, Real length, int axis, std::int64_t sign) {
    const Symmetric<Real>& m = body.gyration_inv;
    if (!((body.angular_mask >> axis) & 1u)) return {};
    const Real column[3] = {axis == 0   ? m.xx
                            : axis == 1 ? m.xy
                                        : m.xz,
                            axis == 0   ? m.xy
                            : axis == 1 ? m.yy
                                        : m.yz,
                            axis == 0   ? m.xz
                            : axis == 1 ? m.yz
                                        : m.zz};
    Row row{};
    for (int i = 0; i < 3; ++i) {
        const std::int64_t x = to<Fixed<std::int64_t, row_bits>>(column[i] * length).raw;
        row.x[i] = static_cast<std::int32_t>(sign * std::clamp(x, -jacobian_limit, jacobian_limit));
    }
    return row;
}

template <unsigned N>
void fill_rolling(RollingRows<N>& rows, unsigned lane, const SolverBodies& bodies, const Contact& contact,
                  const ContactMemory& memory, std::span<const BodyMass> mass,
                  std::span<const PointScalars> points, Shares shares) {
    const BodyStep& sa = bodies.step[contact.body_a];
    const BodyStep& sb = bodies.step[contact.body_b];
    const Real la = rolling_length(mass_of(mass, contact.body_a)),
               lb = rolling_length(mass_of(mass, contact.body_b));
    const Real length = !sa.movable ? lb : !sb.movable ? la : min(la, lb);
    if (length <= Real{} || (!sa.movable && !sb.movable)) return;
    Row xa[3], xb[3];
    std::int64_t inverse[3], least = 0;
    constexpr std::int32_t nothing[3] = {0, 0, 0};
    for (int r = 0; r < 3; ++r) {
        if (sa.moves) xa[r] = rolling_row(sa, length, r, -1);
        if (sb.moves) xb[r] = rolling_row(sb, length, r, 1);
        const std::int64_t qa = row_length_squared(bodies.body[contact.body_a], nothing, xa[r]);
        const std::int64_t qb = row_length_squared(bodies.body[contact.body_b], nothing, xb[r]);
        inverse[r] = shift_right_rounded((qa >> 30) * shares.a + (qb >> 30) * shares.b, 26);
        if (inverse[r] >= least_inverse_mass && (least == 0 || inverse[r] < least)) least = inverse[r];
    }
    if (least == 0) return;
    const std::int32_t warm[3] = {memory.rolling.x.raw, memory.rolling.y.raw, memory.rolling.z.raw};
    for (int r = 0; r < 3; ++r) {
        if (inverse[r] < least_inverse_mass) continue;
        for (int i = 0; i < 3; ++i) {
            rows.xa[r][i].lane[lane] = xa[r].x[i];
            rows.xb[r][i].lane[lane] = xb[r].x[i];
        }
        rows.kappa[r].lane[lane] = saturate_to_int32(divide_shifted(least, inverse[r], 30));
        const std::int64_t impulse = narrow_rounded(Wide::product(warm[r], least), 30);
        rows.impulse[r].lane[lane] =
            static_cast<std::int32_t>(std::clamp<std::int64_t>(impulse, -impulse_limit, impulse_limit));
    }
    rows.ratio_a.lane[lane] = saturate_to_int32(divide_shifted(shares.a, least, 30));
    rows.ratio_b.lane[lane] = saturate_to_int32(divide_shifted(shares.b, least, 30));
    const std::int64_t per_length =
        std::min(divide_shifted(contact.rolling.raw, length.raw, 30), jacobian_limit);
    for (std::size_t k = 0; k < points.size(); ++k)
        if (points[k].inverse_min != 0)
            rows.share[k].lane[lane] = static_cast<std::int32_t>(std::min(
                divide_shifted(per_length * (least >> 8), points[k].inverse_min, 8), jacobian_limit));
}

template <unsigned N>
void fill_lane(ContactPack<N>& pack, std::span<RollingRows<N>> rolling, unsigned lane, const Contact& contact,
               const ContactMemory& memory, std::span<const BodyMass> mass, const StepConstants& step,
               const SolverBodies& bodies) {
    const BodyStep& sa = bodies.step[contact.body_a];
    const BodyStep& sb = bodies.step[contact.body_b];
    const Shares shares = shares_of(mass_of(mass, contact.body_a), sa, mass_of(mass, contact.body_b), sb);
    const Softness& soft = sa.movable && sb.movable ? step.soft : step.soft_static;
    const Tangents tangents = tangents_of(contact.normal);
    const UnitVec3 directions[3] = {contact.normal, tangents.first, tangents.second};
    std::int32_t d[3][3];
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < 3; ++i) {
            d[r][i] = to<Jacobian>(directions[r][i]).raw;
            pack.d[r][i].lane[lane] = d[r][i];
        }
    pack.body_a[lane] = contact.body_a;
    pack.body_b[lane] = contact.body_b;
    pack.moves_a |= (sa.movable ? 1u : 0u) << lane;
    pack.moves_b |= (sb.movable ? 1u : 0u) << lane;
    pack.point_count = std::max(pack.point_count, static_cast<std::int32_t>(contact.count));
    pack.friction.lane[lane] = contact.friction.raw;
    pack.restitution.lane[lane] = contact.restitution.raw;
    pack.bias_rate.lane[lane] = soft.bias_rate.raw;
    pack.impulse_scale.lane[lane] = soft.impulse_scale.raw;
    const SpeedVec3& slip = contact.surface_velocity;
    pack.surface[0].lane[lane] = dot<Speed>(slip, tangents.first).raw;
    pack.surface[1].lane[lane] = dot<Speed>(slip, tangents.second).raw;
    PointScalars all[4];
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        const ContactPoint& point = contact.points[k];
        const PointScalars& scalars = all[k] = point_scalars(bodies, contact, point, directions, d, shares);
        const std::int32_t approach = speed_along(bodies.body[contact.body_a], bodies.body[contact.body_b],
                                                  d[0], scalars.xa[0], scalars.xb[0]);
        fill_point(pack.points[k], lane, scalars, point, shares, soft, approach, memory.points[k]);
    }
    if (contact.count > 1)
        fill_mean(pack.mean, lane, bodies, contact, d[0], std::span(all, contact.count), shares);
    if (contact.rolling <= Unit{}) return;
    fill_rolling(rolling[pack.rolling], lane, bodies, contact, memory, mass, std::span(all, contact.count),
                 shares);
}

} // namespace

template <unsigned N> void ContactSolver<N>::reserve(std::size_t contacts) {
    packs.reserve(contacts);
    rolling.reserve(contacts);
    order.reserve(contacts);
    colour.reserve(contacts);
}

template <unsigned N> void ContactSolver<N>::place_packs(std::span<const Contact> contacts) {
    // Counting sort: by colour, within a colour by contact order.
    std::array<std::uint32_t, colour_max + 2> start{};
    for (std::uint32_t c : colour) ++start[c + 1];
    for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
    std::array<std::uint32_t, colour_max + 2> next = start;
    order.resize(contacts.size());
    for (std::uint32_t i = 0; i < contacts.size(); ++i) order[next[colour[i]]++] = i;

    std::uint32_t placed = 0, rolling_count = 0;
    packs.resize(contacts.size());
    for (std::uint32_t c = 0; c <= colour_max; ++c) {
        colour_begin[c] = placed;
        const std::uint32_t lanes = c == colour_max ? 1 : N; // the last colour's contacts may share bodies
        for (std::uint32_t i = start[c]; i < start[c + 1]; i += lanes) {
            ContactPack<N>& pack = packs[placed++];
            bool rolls = false;
            for (unsigned lane = 0; lane < N; ++lane) {
                const bool is_empty = lane >= lanes || i + lane >= start[c + 1];
                pack.contact[lane] = is_empty ? no_contact : order[i + lane];
                rolls |= !is_empty && contacts[order[i + lane]].rolling > Unit{};
            }
            pack.rolling = rolls ? rolling_count++ : no_contact;
        }
    }
    colour_begin[colour_max + 1] = placed;
    packs.resize(placed);
    rolling.resize(rolling_count);
}

template <unsigned N>
void ContactSolver<N>::prepare(std::span<const Contact> contacts, std::span<const ContactMemory> memory,
                               std::span<const BodyMass> mass, const StepConstants& step,
                               const SolverBodies& bodies, Tasks* tasks) {
    colour_contacts(contacts, bodies, body_colours, colour);
    place_packs(contacts);
    const auto fill = [&](ContactPack<N>& pack) {
        const ContactPack<N> placed = pack;
        pack = {};
        pack.rolling = placed.rolling;
        if (pack.rolling != no_contact) rolling[pack.rolling] = {};
        for (unsigned lane = 0; lane < N; ++lane) {
            const std::uint32_t index = pack.contact[lane] = placed.contact[lane];
            pack.body_a[lane] = pack.body_b[lane] = bodies.still();
            if (index != no_contact)
                fill_lane(pack, std::span(rolling), lane, contacts[index], memory[contacts[index].memory],
                          mass, step, bodies);
        }
    };
    base::for_chunks(tasks, static_cast<std::uint32_t>(packs.size()), pack_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) fill(packs[i]);
                     });
}

namespace {

/// An impulse in units of the row's own mass, as it is remembered: over the reduced mass of the two bodies.
Speed remembered(std::int32_t impulse, std::int32_t ratio_a, std::int32_t ratio_b, ClampCounts& clamps) {
    const std::int64_t ratio = std::int64_t{ratio_a} + ratio_b;
    if (magnitude(impulse) >= impulse_limit) ++clamps.impulse;
    return Speed::from_raw(saturate_to_int32(shift_right_rounded(impulse * (ratio >> 1), 29)));
}

} // namespace

template <unsigned N>
void ContactSolver<N>::store(std::span<const Contact> contacts, std::span<ContactMemory> memory,
                             ClampCounts& clamps, Tasks* tasks) const {
    const auto store_lane = [&](const ContactPack<N>& pack, unsigned lane, ClampCounts& counts) {
        const Contact& contact = contacts[pack.contact[lane]];
        ContactMemory& m = memory[contact.memory];
        for (std::uint32_t k = 0; k < contact.count; ++k) {
            const PointPack<N>& point = pack.points[k];
            const auto remember = [&](int r) {
                return remembered(point.impulse[r].lane[lane], point.ratio_a.lane[lane],
                                  point.ratio_b.lane[lane], counts);
            };
            m.points[k].normal = remember(0);
            m.points[k].tangent_1 = remember(1);
            m.points[k].tangent_2 = remember(2);
        }
        if (pack.rolling == no_contact) return;
        const RollingRows<N>& rows = rolling[pack.rolling];
        for (int r = 0; r < 3; ++r)
            m.rolling[r] = remembered(rows.impulse[r].lane[lane], rows.ratio_a.lane[lane],
                                      rows.ratio_b.lane[lane], counts);
    };
    base::for_chunks(tasks, static_cast<std::uint32_t>(packs.size()), 4 * pack_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         ClampCounts counts;
                         for (std::uint32_t i = first; i < last; ++i)
                             for (unsigned lane = 0; lane < N; ++lane)
                                 if (packs[i].contact[lane] != no_contact) store_lane(packs[i], lane, counts);
                         base::add_count(clamps.impulse, counts.impulse);
                     });
}

template <unsigned N> void ContactSolver<N>::poison(std::byte with) {
    auto& [pack_list, begins, rolling_list, order_list, colour_list, colours] = *this;
    base::poison(with, pack_list, begins, rolling_list, order_list, colour_list, colours);
}

template class ContactSolver<1>;
template class ContactSolver<4>;

} // namespace lockstone::dynamics
