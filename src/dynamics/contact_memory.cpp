#include "dynamics/contact_memory.h"

#include <algorithm>
#include <bit>

namespace lockstone::dynamics {

namespace {

/// How far a point may be from a remembered one of another feature and still be the same contact [m].
constexpr std::int64_t same_point_distance = decimal<Length>("0.02").raw;

/// 44 fraction bits. Differences reach 256 m, whose square is beyond 64 bits; what is further than 64 m along an axis counts
/// as that far, for nothing so far is the same point.
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

bool has_impulses(const ContactMemory& old, const ContactMemory& fresh) {
    return old.count != 0 && dot<Unit>(old.normal, fresh.normal) >= same_direction;
}

/// Friction acts on a manifold as a whole: it goes to the first that takes a point of it.
void take_friction(std::span<const ContactMemory> old, std::uint32_t bit, Taken& taken, ContactMemory& fresh) {
    const std::uint32_t m = static_cast<std::uint32_t>(std::countr_zero(bit)) / 4;
    if ((taken.friction >> m) & 1u) return;
    taken.friction |= 1u << m;
    fresh.tangent_1 = fresh.tangent_1 + old[m].tangent_1;
    fresh.tangent_2 = fresh.tangent_2 + old[m].tangent_2;
    fresh.twist = fresh.twist + old[m].twist;
}

/// Calls visit(bit, point) for every old point that is left, in order.
template <class Visit>
void for_each_left(std::span<const ContactMemory> old, const std::uint32_t& taken, const ContactMemory& fresh,
                   Visit&& visit) {
    for (std::uint32_t m = 0; m < old.size(); ++m) {
        if (!has_impulses(old[m], fresh)) continue;
        for (std::uint32_t i = 0; i < old[m].count; ++i)
            if (const std::uint32_t bit = 1u << (4 * m + i); !(taken & bit)) visit(bit, old[m].points[i]);
    }
}

/// Not below the length of a vector, and not above 1.12 times it: the widest component and half of the others.
std::int64_t length_above(std::int64_t x, std::int64_t y, std::int64_t z) {
    x = x < 0 ? -x : x, y = y < 0 ? -y : y, z = z < 0 ? -z : z;
    const std::int64_t widest = std::max(x, std::max(y, z));
    return widest + ((x + y + z - widest + 1) >> 1);
}

/// The vector part of rotation * conjugate(made), for a small turn half the rotation vector; its scalar is positive. Both
/// have unit length, so products are below 2^61 and four of them fit.
struct HalfTurn {
    std::int64_t x, y, z; ///< 30 fraction bits
};
HalfTurn half_turn(Quat now, Quat made) {
    const std::int64_t x = now.x.raw, y = now.y.raw, z = now.z.raw, w = now.w.raw;
    const std::int64_t mx = made.x.raw, my = made.y.raw, mz = made.z.raw, mw = made.w.raw;
    const std::int64_t sign = w * mw + x * mx + y * my + z * mz < 0 ? -1 : 1;
    const auto part = [&](std::int64_t sum) { return sign * shift_right_rounded(sum, Unit::fraction_bits); };
    return {part(x * mw - w * mx + z * my - y * mz), part(y * mw - w * my + x * mz - z * mx),
            part(z * mw - w * mz + y * mx - x * my)};
}

/// Most of u for a pair's manifolds: that of the row that bears least.
std::int64_t recycling_limit(std::span<const ContactMemory> rows, Coordinate reach) {
    const std::int64_t by_reach = reach.raw >> recycling_reach_shift;
    for (const ContactMemory& row : rows)
        if (!(row.flags & contact_on_face)) return std::min<std::int64_t>(recycling.raw, by_reach);
    return std::min<std::int64_t>(recycling_on_face.raw, by_reach);
}

} // namespace

void carry_impulses(std::span<const ContactMemory> old, Taken& taken, ContactMemory& fresh) {
    bool found[4] = {};
    for (std::uint32_t k = 0; k < fresh.count; ++k)
        for_each_left(old, taken.points, fresh, [&](std::uint32_t bit, const ContactPointMemory& point) {
            if (found[k] || point.feature != fresh.points[k].feature) return;
            fresh.points[k].normal = point.normal;
            found[k] = true;
            taken.points |= bit;
            take_friction(old, bit, taken, fresh);
        });
    for (std::uint32_t k = 0; k < fresh.count; ++k) {
        if (found[k]) continue;
        std::int64_t nearest = (same_point_distance * same_point_distance) >> 4;
        std::uint32_t best = 0;
        for_each_left(old, taken.points, fresh, [&](std::uint32_t bit, const ContactPointMemory& point) {
            const std::int64_t d = distance_squared(point.position, fresh.points[k].position);
            if (d > nearest) return;
            fresh.points[k].normal = point.normal;
            nearest = d, best = bit;
        });
        if (best == 0) continue;
        taken.points |= best;
        take_friction(old, best, taken, fresh);
    }
    for (const ContactMemory& m : old)
        if (has_impulses(m, fresh)) {
            fresh.rolling = m.rolling;
            break;
        }
}

bool still_good(std::span<const ContactMemory> rows, const Placing& now, Length margin, Shift& shift) {
    const ContactMemory& made = rows[0];
    if (margin > made.margin) return false;
    const std::int64_t limit = recycling_limit(rows, now.reach);
    const CoordinateVec3 moved = now.position - made.made_position;
    for (int i = 0; i < 3; ++i)
        if (moved[i].raw > limit || moved[i].raw < -limit) return false;
    const HalfTurn half = half_turn(now.rotation, made.made_rotation);
    const std::int64_t turn = 2 * length_above(half.x, half.y, half.z);
    if (turn > recycling_turn.raw) return false; // and so the product fits
    const std::int64_t by_turn = (turn * now.reach.raw >> Unit::fraction_bits) + 1;
    if (length_above(moved.x.raw, moved.y.raw, moved.z.raw) + by_turn > limit) return false;
    const auto twice = [](std::int64_t x) { return Unit::from_raw(static_cast<std::int32_t>(2 * x)); };
    shift.moved = to<Length>(moved);
    shift.turned = {twice(half.x), twice(half.y), twice(half.z)};
    return true;
}

// n . (m + t x p) = n . m + (n x t) . p; below 2^46 and 2^61, 54 fraction bits.
std::array<Separation, 4> separations_after(const ContactMemory& memory, const Shift& shift) {
    const std::int64_t n[3] = {memory.normal.x.raw, memory.normal.y.raw, memory.normal.z.raw};
    const std::int64_t t[3] = {shift.turned.x.raw, shift.turned.y.raw, shift.turned.z.raw};
    const std::int64_t along = n[0] * shift.moved.x.raw + n[1] * shift.moved.y.raw + n[2] * shift.moved.z.raw;
    const auto part = [](std::int64_t sum) { return shift_right_rounded(sum, Unit::fraction_bits); };
    const std::int64_t x = part(n[1] * t[2] - n[2] * t[1]), y = part(n[2] * t[0] - n[0] * t[2]),
                       z = part(n[0] * t[1] - n[1] * t[0]);
    constexpr int drop = Unit::fraction_bits + Length::fraction_bits - Separation::fraction_bits;
    std::array<Separation, 4> out{};
    for (std::uint32_t k = 0; k < memory.count; ++k) {
        const ContactPointMemory& p = memory.points[k];
        const std::int64_t by = along + x * p.position.x.raw + y * p.position.y.raw + z * p.position.z.raw;
        out[k] = Separation::from_raw(saturate_to_int32(p.separation.raw + shift_right_rounded(by, drop)));
    }
    return out;
}

} // namespace lockstone::dynamics
