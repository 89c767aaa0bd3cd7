#include "solve/contacts/contact_memory.h"

#include <algorithm>
#include <bit>

namespace lockstone::solve {

namespace {

/// A new point matches a remembered point of another feature up to this distance [m].
constexpr std::int64_t same_point_distance = decimal<Length>("0.02").raw;

/// 44 fraction bits. Differences reach 256 m, and the square of that exceeds 64 bits. A difference of more than 64 m
/// along an axis counts as 64 m; points so far apart never match.
constexpr std::int64_t far = std::int64_t{64} << Length::fraction_bits;

std::int64_t distance_squared(LengthVec3 a, LengthVec3 b) {
    const auto square = [](std::int64_t d) {
        const std::int64_t near = std::clamp(d, -far, far); // 2^30: the sum of three stays below 2^58
        return (near * near) >> 4;
    };
    return square(std::int64_t{a.x.raw} - b.x.raw) + square(std::int64_t{a.y.raw} - b.y.raw) +
           square(std::int64_t{a.z.raw} - b.z.raw);
}

constexpr Unit same_direction = decimal<Unit>("0.94"); ///< cosine of 20 degrees

/// The points of the old manifolds whose normal is close enough to `normal`: a bit for each, four bits a manifold.
std::uint32_t find_serving(std::span<const ContactMemory> old, UnitVec3 normal) {
    std::uint32_t points = 0;
    for (std::uint32_t m = 0; m < old.size(); ++m)
        if (old[m].count != 0 && dot<Unit>(old[m].normal, normal) >= same_direction)
            points |= ((1u << old[m].count) - 1) << 4 * m;
    return points;
}

/// Friction acts on a manifold as a whole: the first new manifold that takes one of its points takes its friction.
void take_friction(std::span<const ContactMemory> old, std::uint32_t bit, Taken& taken,
                   ContactMemory& fresh) {
    const std::uint32_t m = static_cast<std::uint32_t>(std::countr_zero(bit)) / 4;
    if ((taken.friction >> m) & 1u) return;
    taken.friction |= 1u << m;
    fresh.tangent_1 = fresh.tangent_1 + old[m].tangent_1;
    fresh.tangent_2 = fresh.tangent_2 + old[m].tangent_2;
    fresh.twist = fresh.twist + old[m].twist;
}

/// Calls visit(bit, point) for these points, in order, until it returns true.
template <class Visit>
void for_each_point(std::span<const ContactMemory> old, std::uint32_t points, Visit&& visit) {
    for (; points != 0; points &= points - 1) {
        const std::uint32_t i = static_cast<std::uint32_t>(std::countr_zero(points));
        if (visit(1u << i, old[i / 4].points[i % 4])) return;
    }
}

} // namespace

void carry_impulses(std::span<const ContactMemory> old, Taken& taken, ContactMemory& fresh) {
    const std::uint32_t serving = find_serving(old, fresh.normal);
    if (serving == 0) return;
    bool found[4] = {};
    for (std::uint32_t k = 0; k < fresh.count; ++k)
        for_each_point(old, serving & ~taken.points, [&](std::uint32_t bit, const ContactPointMemory& point) {
            if (point.feature != fresh.points[k].feature) return false;
            fresh.points[k].normal = point.normal;
            taken.points |= bit;
            take_friction(old, bit, taken, fresh);
            return found[k] = true;
        });
    for (std::uint32_t k = 0; k < fresh.count; ++k) {
        if (found[k]) continue;
        std::int64_t nearest = (same_point_distance * same_point_distance) >> 4;
        std::uint32_t best = 0;
        for_each_point(old, serving & ~taken.points, [&](std::uint32_t bit, const ContactPointMemory& point) {
            const std::int64_t d = distance_squared(point.position, fresh.points[k].position);
            if (d > nearest) return false;
            fresh.points[k].normal = point.normal;
            nearest = d, best = bit;
            return false;
        });
        if (best == 0) continue;
        taken.points |= best;
        take_friction(old, best, taken, fresh);
    }
    fresh.rolling = old[static_cast<std::uint32_t>(std::countr_zero(serving)) / 4].rolling;
}

Length recycling_limit(std::span<const ContactMemory> rows, Coordinate reach, Length thinnest) {
    const std::int64_t by_reach =
                           std::min<std::int64_t>(reach.raw >> recycling_reach_shift, Length::max().raw),
                       by_thinnest = thinnest.raw >> recycling_thin_shift;
    const auto within_reach = [&](std::int64_t limit) {
        return Length::from_raw(static_cast<std::int32_t>(std::min(limit, by_reach)));
    };
    for (const ContactMemory& row : rows)
        if (!(row.flags & contact_on_face)) return within_reach(recycling.raw);
    // At least the limit of edges.
    return within_reach(
        std::max<std::int64_t>(recycling.raw, std::min<std::int64_t>(recycling_on_face.raw, by_thinnest)));
}

} // namespace lockstone::solve
