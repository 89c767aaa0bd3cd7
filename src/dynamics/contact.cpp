#include "dynamics/contact.h"

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

/// How far a point may be from a remembered one of another feature and still be the same contact [m].
constexpr std::int64_t same_point_distance = decimal<Length>("0.02").raw;

std::int64_t distance_squared(LengthVec3 a, LengthVec3 b) {
    const auto square = [](std::int64_t d) { return (d * d) >> 4; };
    return square(std::int64_t{a.x.raw} - b.x.raw) + square(std::int64_t{a.y.raw} - b.y.raw) +
           square(std::int64_t{a.z.raw} - b.z.raw);
}

/// For each point what it was in the last tick: by feature; for the rest the nearest that is left, if it is near. When
/// two edges nearly coincide, the feature of a corner flips from one body's to the other's while the corner stays:
/// a tower that forgets those impulses rocks.
using Recollection = std::array<const ContactPointMemory*, 4>;

Recollection recollect(const ContactMemory& memory, const Contact& contact) {
    Recollection found{};
    bool taken[4] = {};
    for (std::uint32_t k = 0; k < contact.count; ++k)
        for (std::uint32_t i = 0; i < memory.count; ++i)
            if (memory.points[i].feature == contact.points[k].feature && !taken[i]) {
                found[k] = &memory.points[i];
                taken[i] = true;
                break;
            }
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        if (found[k] != nullptr) continue;
        std::int64_t nearest = (same_point_distance * same_point_distance) >> 4;
        std::uint32_t best = 4;
        for (std::uint32_t i = 0; i < memory.count; ++i) {
            const std::int64_t d = distance_squared(memory.points[i].position, contact.points[k].position);
            if (!taken[i] && d <= nearest) nearest = d, best = i;
        }
        if (best == 4) continue;
        found[k] = &memory.points[best];
        taken[best] = true;
    }
    return found;
}

constexpr std::int32_t impulse_limit = 1 << 30; ///< 2048 m/s
/// A point that parts faster has bounced: the impulse that sent it off is none to start from [m/s].
constexpr std::int32_t leaving_speed = decimal<Speed>("0.25").raw;

template <unsigned N>
void fill_point(PointPack<N>& pack, unsigned lane, const PointScalars& p, const ContactPoint& point,
                Shares shares, const Softness& soft, std::int32_t approach, const ContactPointMemory* warm) {
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
    if (warm == nullptr || approach > leaving_speed) return;
    // Remembered as lambda (1/mA + 1/mB); p = j k'min.
    const std::int32_t j[3] = {warm->normal.raw, warm->tangent_1.raw, warm->tangent_2.raw};
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

template <unsigned N>
void fill_lane(ContactPack<N>& pack, unsigned lane, std::uint32_t index, const Contact& contact,
               const ContactMemory& memory, std::span<const BodyMass> mass, const StepConstants& step,
               const SolverBodies& bodies) {
    const BodyStep& sa = bodies.step[contact.body_a];
    const BodyStep& sb = bodies.step[contact.body_b];
    const Shares shares = shares_of(mass[contact.body_a], sa, mass[contact.body_b], sb);
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
    pack.contact[lane] = index;
    pack.point_count = std::max(pack.point_count, static_cast<std::int32_t>(contact.count));
    pack.friction.lane[lane] = contact.friction.raw;
    pack.restitution.lane[lane] = contact.restitution.raw;
    pack.bias_rate.lane[lane] = soft.bias_rate.raw;
    pack.impulse_scale.lane[lane] = soft.impulse_scale.raw;
    const Recollection warm = recollect(memory, contact);
    PointScalars all[4];
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        const ContactPoint& point = contact.points[k];
        const PointScalars& scalars = all[k] = point_scalars(bodies, contact, point, directions, d, shares);
        const std::int32_t approach = speed_along(bodies.body[contact.body_a], bodies.body[contact.body_b],
                                                  d[0], scalars.xa[0], scalars.xb[0]);
        fill_point(pack.points[k], lane, scalars, point, shares, soft, approach, warm[k]);
    }
    if (contact.count > 1)
        fill_mean(pack.mean, lane, bodies, contact, d[0], std::span(all, contact.count), shares);
}

} // namespace

template <unsigned N> void ContactSolver<N>::reserve(std::size_t contacts) {
    packs.reserve(contacts);
    order.reserve(contacts);
    colour.reserve(contacts);
}

template <unsigned N>
void ContactSolver<N>::prepare(std::span<const Contact> contacts, std::span<const ContactMemory> memory,
                               std::span<const BodyMass> mass, const StepConstants& step,
                               const SolverBodies& bodies) {
    colour_contacts(contacts, bodies, body_colours, colour);
    // Counting sort: by colour, within a colour by contact order.
    std::array<std::uint32_t, colour_max + 2> start{};
    for (std::uint32_t c : colour) ++start[c + 1];
    for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
    std::array<std::uint32_t, colour_max + 2> next = start;
    order.resize(contacts.size());
    for (std::uint32_t i = 0; i < contacts.size(); ++i) order[next[colour[i]]++] = i;

    packs.clear();
    for (std::uint32_t c = 0; c <= colour_max; ++c) {
        const std::uint32_t lanes = c == colour_max ? 1 : N; // the last colour's contacts may share bodies
        for (std::uint32_t i = start[c]; i < start[c + 1]; i += lanes) {
            ContactPack<N>& pack = packs.emplace_back();
            for (unsigned lane = 0; lane < N; ++lane) {
                pack.body_a[lane] = pack.body_b[lane] = bodies.still();
                pack.contact[lane] = no_contact;
                if (lane >= lanes || i + lane >= start[c + 1]) continue;
                const std::uint32_t index = order[i + lane];
                fill_lane(pack, lane, index, contacts[index], memory[contacts[index].memory], mass, step,
                          bodies);
            }
        }
    }
}

template <unsigned N>
void ContactSolver<N>::store(std::span<const Contact> contacts, std::span<ContactMemory> memory,
                             ClampCounts& clamps) const {
    for (const ContactPack<N>& pack : packs)
        for (unsigned lane = 0; lane < N; ++lane) {
            if (pack.contact[lane] == no_contact) continue;
            const Contact& contact = contacts[pack.contact[lane]];
            ContactMemory& m = memory[contact.memory];
            m.count = contact.count;
            m.points = {};
            for (std::uint32_t k = 0; k < contact.count; ++k) {
                const PointPack<N>& point = pack.points[k];
                const std::int64_t ratio = std::int64_t{point.ratio_a.lane[lane]} + point.ratio_b.lane[lane];
                const auto remember = [&](int r) {
                    const std::int64_t j =
                        shift_right_rounded(point.impulse[r].lane[lane] * (ratio >> 1), 29);
                    if (magnitude(point.impulse[r].lane[lane]) >= impulse_limit) ++clamps.impulse;
                    return Speed::from_raw(saturate_to_int32(j));
                };
                m.points[k] = {contact.points[k].position, contact.points[k].feature, remember(0),
                               remember(1), remember(2)};
            }
        }
}

template class ContactSolver<1>;
template class ContactSolver<4>;

} // namespace lockstone::dynamics
