#include "shapes/mesh/triangle.h"

#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone::shapes {
namespace {

struct Wide3 {
    Wide x, y, z;
};

int length_of(Wide w) {
    const Wide positive = w.is_negative() ? Wide::from(0) - w : w;
    const std::uint64_t high = static_cast<std::uint64_t>(positive.high_bits());
    return high != 0 ? 64 + bit_length(high) : bit_length(positive.low_bits());
}
/// Reduces all three to 60 significant bits of the longest.
Vec3 leading(const Wide3& n) {
    const int length = std::max(length_of(n.x), std::max(length_of(n.y), length_of(n.z)));
    const int drop = length > 60 ? length - 60 : 0;
    const auto raw = [drop](Wide w) { return Real::from_raw(narrow_rounded(w, drop)); };
    return {raw(n.x), raw(n.y), raw(n.z)};
}

/// Differences are below 2^40, so all terms are below 2^81.
Wide3 cross_of(const CoordinateVec3 (&c)[3]) {
    const CoordinateVec3 u = c[1] - c[0], v = c[2] - c[0];
    const auto minor = [](Coordinate a, Coordinate b, Coordinate x, Coordinate y) {
        return Wide::product(a.raw, b.raw) - Wide::product(x.raw, y.raw);
    };
    return {minor(u.y, v.z, u.z, v.y), minor(u.z, v.x, u.x, v.z), minor(u.x, v.y, u.y, v.x)};
}

/// Bounds are clamped to this, which is beyond any asset.
constexpr std::int64_t reach = std::int64_t{1} << 45;

/// ceil(n / d), d > 0.
std::int64_t divided_up(Wide n, std::int64_t d) {
    const bool negative = n.is_negative();
    const Wide m = negative ? Wide::from(0) - n : n; // below 2^70, the quotient below 2^53
    const auto qr = divide_128_by_64(static_cast<std::uint64_t>(m.high_bits()), m.low_bits(),
                                     static_cast<std::uint64_t>(d));
    const std::int64_t q = static_cast<std::int64_t>(qr.quotient);
    return negative ? -q : q + (qr.remainder != 0 ? 1 : 0);
}

// round(x s) >= q is x s >= q - 1/2; in raw values 2 x s >= (2 q - 1) 2^24.
Coordinate least(Coordinate q, Length s) {
    const std::int64_t bound = std::clamp(q.raw, -reach, reach);
    return Coordinate::from_raw(divided_up(Wide::from(2 * bound - 1) << 23, s.raw));
}
// round(x s) <= q is x s < q + 1/2.
Coordinate greatest(Coordinate q, Length s) {
    const std::int64_t bound = std::clamp(q.raw, -reach, reach);
    return Coordinate::from_raw(divided_up(Wide::from(2 * bound + 1) << 23, s.raw) - 1);
}

} // namespace

UnitVec3 triangle_normal(const CoordinateVec3 (&corner)[3], LengthVec3 scale) {
    const Vec3 n = leading(cross_of(corner));
    if (scale == scale_one) return normalized(n);
    // A normal scales by the product of the other two axes' factors: 59 + 62 bits.
    const auto times = [](Real a, Length s, Length t) {
        return Wide::product(a.raw, std::int64_t{s.raw} * t.raw);
    };
    return normalized(
        leading({times(n.x, scale.y, scale.z), times(n.y, scale.x, scale.z), times(n.z, scale.x, scale.y)}));
}

bool has_area(const CoordinateVec3 (&corner)[3]) {
    const Wide3 n = cross_of(corner);
    const Wide zero = Wide::from(0);
    return !(n.x == zero && n.y == zero && n.z == zero);
}

int side_of(const CoordinateVec3 (&corner)[3], CoordinateVec3 p) {
    // The determinant needs 2^121: cross products below 2^81 times differences below 2^40.
    const Wide3 n = cross_of(corner);
    const CoordinateVec3 d = p - corner[0];
    const auto times = [](Wide c, std::int64_t by) {
        const std::int64_t high = static_cast<std::int64_t>((c >> 32).low_bits());
        return (Wide::product(high, by) << 32) +
               Wide::product(static_cast<std::int64_t>(c.low_bits() & 0xffffffffu), by);
    };
    const Wide h = times(n.x, d.x.raw) + times(n.y, d.y.raw) + times(n.z, d.z.raw);
    return h.is_negative() ? -1 : h == Wide::from(0) ? 0 : 1;
}

bool is_flat(UnitVec3 a, UnitVec3 b, Unit sine) {
    if (dot(a, b) < Unit{}) return false;
    const UnitVec3 c = cross(a, b);
    return dot<I4F60>(c, c) < mul<I4F60>(sine, sine);
}

Extent at_scale_one(const Extent& where, LengthVec3 scale) {
    if (scale == scale_one) return where;
    return {{least(where.lower.x, scale.x), least(where.lower.y, scale.y), least(where.lower.z, scale.z)},
            {greatest(where.upper.x, scale.x), greatest(where.upper.y, scale.y),
             greatest(where.upper.z, scale.z)}};
}

} // namespace lockstone::shapes
