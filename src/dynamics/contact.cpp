#include "dynamics/contact_rows.h"

#include "base/poison.h"

#include <bit>

namespace lockstone::dynamics {

/// The frame (pole, from) turned along the shortest arc from the pole to the normal: from - (pole + n) (n . from) / (1 +
/// n . pole). It jumps nowhere but opposite the pole, which is a direction that scenes have no use for.
Tangents tangents_of(UnitVec3 normal) {
    constexpr std::int64_t one = std::int64_t{1} << 30;
    constexpr std::int64_t pole[3] = {2 * one / 7, 3 * one / 7, 6 * one / 7},
                           from[3] = {6 * one / 7, 2 * one / 7, -3 * one / 7};
    const std::int64_t n[3] = {normal.x.raw, normal.y.raw, normal.z.raw};
    std::int64_t along = 0, off = 0;
    for (int i = 0; i < 3; ++i) along += n[i] * pole[i], off += n[i] * from[i];
    along = shift_right_rounded(along, 30);
    UnitVec3 first;
    if (along < -one + (one >> 6))
        first = normalized(UnitVec3{Unit{}, -normal.z, normal.y});
    else {
        const std::int64_t share = divide_shifted(shift_right_rounded(off, 30), one + along, 30); // below 16
        for (int i = 0; i < 3; ++i)
            first[i] = Unit::from_raw(static_cast<std::int32_t>(
                std::clamp(from[i] - shift_right_rounded((pole[i] + n[i]) * share, 30), -one, one)));
    }
    return {first, cross<Unit>(normal, first)};
}

// ---- preparing one point ------------------------------------------------------------------------------------------

namespace {

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
                Shares shares, std::int64_t inverse_min, const Softness& soft, std::int32_t approach,
                const ContactPointMemory& warm) {
    pack.separation.lane[lane] = point.separation.raw;
    pack.approach.lane[lane] = approach;
    if (p.inverse_min == 0) return;
    for (int r = 0; r < 3; ++r) {
        for (int i = 0; i < 3; ++i) {
            pack.xa[r][i].lane[lane] = p.xa[r].x[i];
            pack.xb[r][i].lane[lane] = p.xb[r].x[i];
        }
        if (p.inverse[r] >= least_inverse_mass)
            pack.kappa[r].lane[lane] = saturate_to_int32(divide_shifted(inverse_min, p.inverse[r], 30));
    }
    pack.kappa_soft.lane[lane] = static_cast<std::int32_t>(
        shift_right_rounded(std::int64_t{pack.kappa[0].lane[lane]} * soft.mass_scale.raw, 30));
    pack.ratio_a.lane[lane] = saturate_to_int32(divide_shifted(shares.a, inverse_min, 30));
    pack.ratio_b.lane[lane] = saturate_to_int32(divide_shifted(shares.b, inverse_min, 30));
    if (approach > leaving_speed) return;
    // Remembered as lambda (1/mA + 1/mB); p = j k'min.
    const std::int32_t j[3] = {warm.normal.raw, warm.tangent_1.raw, warm.tangent_2.raw};
    for (int r = 0; r < 3; ++r) {
        const std::int64_t impulse = narrow_rounded(Wide::product(j[r], inverse_min), 30);
        pack.impulse[r].lane[lane] =
            static_cast<std::int32_t>(std::clamp<std::int64_t>(impulse, -impulse_limit, impulse_limit));
    }
}

/// The mean of the normal rows in `points`; see MeanRow.
template <unsigned N>
void fill_mean(MeanRow<N>& mean, unsigned lane, const SolverBodies& bodies, const Contact& contact,
               const std::int32_t normal[3], std::span<const PointScalars> points, Shares shares,
               std::int64_t inverse_min) {
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
        mean.share[k].lane[lane] = saturate_to_int32(divide_shifted(inverse_min, inverse * n, 30));
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
                  std::span<const PointScalars> points, std::int64_t inverse_min, Shares shares) {
    const BodyStep& sa = bodies.step[contact.body_a];
    const BodyStep& sb = bodies.step[contact.body_b];
    const Real la = rolling_length(mass_of(mass, contact.body_a)),
               lb = rolling_length(mass_of(mass, contact.body_b));
    const Real length = !sa.movable ? lb : !sb.movable ? la : min(la, lb);
    if (length <= Real{} || (!sa.movable && !sb.movable)) return;
    Row xa[3]{}, xb[3]{}; // zero of what does not move
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
            rows.share[k].lane[lane] = static_cast<std::int32_t>(
                std::min(divide_shifted(per_length * (least >> 8), inverse_min, 8), jacobian_limit));
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
    std::int64_t inverse_min = 0, inverse_mean = 0;
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        all[k] = point_scalars(bodies, contact, contact.points[k], directions, d, shares);
        if (all[k].inverse_min != 0 && (inverse_min == 0 || all[k].inverse_min < inverse_min))
            inverse_min = all[k].inverse_min;
        inverse_mean += all[k].inverse[0] / contact.count;
    }
    const std::span<const PointScalars> scalars(all, contact.count);
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        const std::int32_t approach = speed_along(bodies.body[contact.body_a], bodies.body[contact.body_b],
                                                  d[0], all[k].xa[0], all[k].xb[0]);
        fill_point(pack.points[k], lane, all[k], contact.points[k], shares, inverse_min, soft, approach,
                   memory.points[k]);
    }
    if (contact.count > 1 && inverse_min != 0) {
        fill_mean(pack.mean, lane, bodies, contact, d[0], scalars, shares, inverse_min);
        fill_block(pack, lane, bodies, contact, directions, shares, soft, inverse_min, inverse_mean);
    }
    if (contact.rolling > Unit{} && inverse_min != 0)
        fill_rolling(rolling[pack.rolling], lane, bodies, contact, memory, mass, scalars, inverse_min,
                     shares);
}

} // namespace

template <unsigned N> void ContactSolver<N>::reserve(std::size_t contacts, std::size_t bodies) {
    packs.reserve(contacts);
    rolling.reserve(contacts);
    stage_begin.reserve(contacts + 1);
    order.reserve(contacts, bodies);
}

template <unsigned N> void ContactSolver<N>::place_packs(std::span<const Contact> contacts) {
    std::uint32_t placed = 0, rolling_count = 0;
    stage_begin.clear();
    stage_begin.reserve(std::bit_ceil(contacts.size()) + 1);
    rolling.reserve(std::bit_ceil(contacts.size()));
    packs.reserve(std::bit_ceil(contacts.size()));
    for (std::uint32_t s = 0; s < order.stage_count(); ++s)
        placed += static_cast<std::uint32_t>((order.stage(s).size() + N - 1) / N);
    packs.resize(placed);
    placed = 0;
    for (std::uint32_t s = 0; s < order.stage_count(); ++s) {
        stage_begin.push_back(placed);
        const std::span<const std::uint32_t> stage = order.stage(s);
        for (std::size_t i = 0; i < stage.size(); i += N) {
            ContactPack<N>& pack = packs[placed++];
            bool rolls = false;
            for (unsigned lane = 0; lane < N; ++lane) {
                pack.contact[lane] = i + lane < stage.size() ? stage[i + lane] : no_contact;
                rolls |= pack.contact[lane] != no_contact && contacts[pack.contact[lane]].rolling > Unit{};
            }
            pack.rolling = rolls ? rolling_count++ : no_contact;
        }
    }
    stage_begin.push_back(placed);
    rolling.resize(rolling_count);
}

template <unsigned N>
void ContactSolver<N>::prepare(std::span<const Contact> contacts, std::span<const ContactMemory> memory,
                               std::span<const BodyMass> mass, const StepConstants& step,
                               const SolverBodies& bodies, Tasks* tasks) {
    order.find(contacts, bodies);
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
    base::poison(with, packs, stage_begin, rolling);
    order.poison(with);
}

template class ContactSolver<1>;
template class ContactSolver<4>;

} // namespace lockstone::dynamics
