// Quaternions from and to other representations. Products have about 60 bits; normalized_quat rounds once.
#include "math/elementary.h"

#include <algorithm>

namespace lockstone {
namespace {

/// floor(a * b / 2^n) for a product that is known to fit afterwards.
std::int64_t mul_shift(std::int64_t a, std::int64_t b, int n) {
    return static_cast<std::int64_t>((Wide::product(a, b) >> n).low_bits());
}

/// Keeps the sum of four squares in 127 bits, also if the input is no unit quaternion.
std::int64_t bounded(std::int64_t v) {
    constexpr std::int64_t limit = (std::int64_t{1} << 62) - 1;
    return std::clamp(v, -limit, limit);
}

/// a . b as quaternions, with 60 fraction bits.
std::int64_t dot_60(Quat a, Quat b) {
    return SumOfProducts<Unit, Unit>{}.add(a.x, b.x).add(a.y, b.y).add(a.z, b.z).add(a.w, b.w).exact();
}

Quat negated(Quat q) { return {-q.x, -q.y, -q.z, -q.w}; }

std::uint64_t square(std::int64_t v) { return static_cast<std::uint64_t>(v * v); }

} // namespace

Quat from_axis_angle(UnitVec3 axis, Real radians) {
    // Half the angle: the same integer with one more fraction bit.
    const detail::SinCos62 t = detail::sin_cos_62(radians.raw, Real::fraction_bits + 1);
    return detail::normalized_quat(mul_shift(axis.x.raw, t.sin, 32), mul_shift(axis.y.raw, t.sin, 32),
                                   mul_shift(axis.z.raw, t.sin, 32), t.cos >> 2);
}

AxisAngle to_axis_angle(Quat q) {
    if (q.w.raw < 0) q = negated(q);
    const UnitVec3 v{q.x, q.y, q.z};
    const std::int64_t sine = detail::sqrt_60(detail::square_sum(v).low);
    const std::int64_t half_angle = detail::atan2_60(sine, std::int64_t{q.w.raw} << 30);
    return {normalized_or(v, UnitVec3{unit_one, Unit{}, Unit{}}), round_from<Real>(half_angle, 59)};
}

Quat from_to(UnitVec3 a, UnitVec3 b) {
    using Sum = SumOfProducts<Unit, Unit>;
    const std::int64_t x = Sum{}.add(a.y, b.z).sub(a.z, b.y).exact(),
                       y = Sum{}.add(a.z, b.x).sub(a.x, b.z).exact(),
                       z = Sum{}.add(a.x, b.y).sub(a.y, b.x).exact();
    const std::int64_t along = Sum{}.add(a.x, b.x).add(a.y, b.y).add(a.z, b.z).exact();
    if (x == 0 && y == 0 && z == 0) {
        if (along >= 0) return Quat::identity();
        const UnitVec3 p = any_perpendicular(a);
        return {p.x, p.y, p.z, Unit{}};
    }
    // (a x b, |a| |b| + a . b), with the actual lengths: an assumed length of 1 would lose nearly opposite vectors.
    const Wide lengths = Wide::product_unsigned(detail::square_sum(a).low, detail::square_sum(b).low);
    const std::uint64_t both =
        detail::isqrt(static_cast<std::uint64_t>(lengths.high_bits()), lengths.low_bits());
    const std::int64_t w = add_saturated(saturate_to_int64(Wide::product_unsigned(both, 1)), along);
    return detail::normalized_quat(bounded(x), bounded(y), bounded(z), bounded(w));
}

Quat from_euler(Vec3 angles) {
    using detail::mul62;
    const detail::SinCos62 a = detail::sin_cos_62(angles.x.raw, 33), b = detail::sin_cos_62(angles.y.raw, 33),
                           c = detail::sin_cos_62(angles.z.raw, 33);
    const auto product = [](std::int64_t p, std::int64_t q, std::int64_t r) {
        return mul62(mul62(p, q), r) >> 1;
    };
    return detail::normalized_quat(product(a.sin, b.cos, c.cos) - product(a.cos, b.sin, c.sin),
                                   product(a.cos, b.sin, c.cos) + product(a.sin, b.cos, c.sin),
                                   product(a.cos, b.cos, c.sin) - product(a.sin, b.sin, c.cos),
                                   product(a.cos, b.cos, c.cos) + product(a.sin, b.sin, c.sin));
}

// Starts from the largest of the four components, so nothing cancels.
// source: S. W. Shepperd, Quaternion from Rotation Matrix, 1978.
Quat from_rotation(const Rotation& m) {
    const std::int64_t one = std::int64_t{1} << Unit::fraction_bits;
    const std::int64_t xx = m.x.x.raw, yy = m.y.y.raw, zz = m.z.z.raw, trace = xx + yy + zz;
    const auto pair = [](Unit a, Unit b) { return std::int64_t{a.raw} + b.raw; };
    const auto difference = [](Unit a, Unit b) { return std::int64_t{a.raw} - b.raw; };
    const std::int64_t yz = difference(m.y.z, m.z.y), zx = difference(m.z.x, m.x.z),
                       xy = difference(m.x.y, m.y.x);
    Quat q{};
    if (trace >= xx && trace >= yy && trace >= zz)
        q = detail::normalized_quat(yz, zx, xy, one + trace);
    else if (xx >= yy && xx >= zz)
        q = detail::normalized_quat(one + 2 * xx - trace, pair(m.x.y, m.y.x), pair(m.x.z, m.z.x), yz);
    else if (yy >= zz)
        q = detail::normalized_quat(pair(m.x.y, m.y.x), one + 2 * yy - trace, pair(m.y.z, m.z.y), zx);
    else
        q = detail::normalized_quat(pair(m.x.z, m.z.x), pair(m.y.z, m.z.y), one + 2 * zz - trace, xy);
    return q.w.raw < 0 ? negated(q) : q;
}

Quat slerp(Quat a, Quat b, Real t) {
    a = normalized(a);
    b = normalized(b);
    if (dot_60(a, b) < 0) b = negated(b);
    std::uint64_t apart = 0, together = 0;
    for (const auto& [p, q] : {std::pair{a.x, b.x}, {a.y, b.y}, {a.z, b.z}, {a.w, b.w}}) {
        apart += square(std::int64_t{p.raw} - q.raw);
        together += square(std::int64_t{p.raw} + q.raw);
    }
    if (apart == 0) return a;
    // The angle between them from chord and sum: accurate for small angles, where acos of the dot product is not.
    const std::int64_t angle = 2 * detail::atan2_60(detail::sqrt_60(apart), detail::sqrt_60(together));
    const std::int64_t part = mul_shift(angle, clamp(t, Real{}, Real(1)).raw, Real::fraction_bits);
    const std::int64_t sa = detail::sin_cos_62(angle - part, 60).sin, sb = detail::sin_cos_62(part, 60).sin;
    const int shift = 62 - bit_length(magnitude(sa) | magnitude(sb));
    const auto blend = [=](Unit p, Unit q) {
        return static_cast<std::int64_t>(
            ((Wide::product(p.raw, sa << shift) + Wide::product(q.raw, sb << shift)) >> 31).low_bits());
    };
    return detail::normalized_quat(blend(a.x, b.x), blend(a.y, b.y), blend(a.z, b.z), blend(a.w, b.w));
}

Quat nlerp(Quat a, Quat b, Real t) {
    if (dot_60(a, b) < 0) b = negated(b);
    const std::int64_t tb = clamp(t, Real{}, Real(1)).raw >> 1, ta = (std::int64_t{1} << 31) - tb;
    const auto blend = [=](Unit p, Unit q) { return p.raw * ta + q.raw * tb; };
    return detail::normalized_quat(blend(a.x, b.x), blend(a.y, b.y), blend(a.z, b.z), blend(a.w, b.w));
}

namespace detail {
namespace {

/// v * 2^-drop, rounded; a negative drop multiplies.
std::int64_t scaled(std::int64_t v, int drop) {
    return drop >= 0 ? shift_right_rounded(v, drop) : v * (std::int64_t{1} << -drop);
}

/// The unit quaternion along a quaternion of 46 fraction bits whose length is 1 to within 2^-21; others take the
/// slower path. With |q|^2 = 1 + e it is q (1 - e / 2), with an error of 3/8 e^2.
Quat nearly_normalized(std::int64_t x, std::int64_t y, std::int64_t z, std::int64_t w) {
    // e with 60 bits, from the squares of c and the cross products, where q = c 2^16 + r.
    std::uint64_t squares = 0; // modulo 2^64: the sum reaches 2^64 for the longest quaternions
    std::int64_t cross = 0;
    for (const std::int64_t p : {x, y, z, w}) {
        const std::int64_t c = p >> 16, r = p & 0xffff;
        squares += square(c), cross += c * r;
    }
    const auto e = static_cast<std::int64_t>(squares + static_cast<std::uint64_t>(cross >> 15) -
                                             (std::uint64_t{1} << 60));
    if (e >= SmallTurn::length_error || e <= -SmallTurn::length_error) return normalized_quat(x, y, z, w);
    const std::int64_t half_e = e >> 11; // 50 bits
    const auto one = [half_e](std::int64_t p) {
        const std::int64_t less = ((p >> 16) * half_e) >> 34;
        return Unit::from_raw(static_cast<std::int32_t>((p - less + (1 << 15)) >> 16));
    };
    return {one(x), one(y), one(z), one(w)};
}

/// A turn of less than 1/4 rad: h = v / 2 has 34 fraction bits and |h| < 2^-3.2. exp(h) = (h sinc, cosine) with the
/// first terms of each series: the remaining terms are below 2^-41. All products are of 32-bit numbers, so that lanes
/// compute the same: solve/bodies/turn_kernel.h.
Quat turned_slightly(Quat q, std::int64_t hx, std::int64_t hy, std::int64_t hz) {
    using T = SmallTurn;
    const std::int64_t z = (hx * hx + hy * hy + hz * hz) >> 32; // |h|^2, 36 bits
    const auto series = [z](std::int64_t first, std::int64_t second, std::int64_t third) {
        return (z * (first - ((z * (second - ((z * third) >> 36))) >> 36)));
    };
    const std::int64_t sinc_less_1 = -(series(T::sixth, T::one_of_120, T::one_of_5040) >> 27); // 39 bits
    const std::int64_t c = -(series(T::half, T::one_of_24, T::one_of_720) >> 32); // cosine - 1, 34 bits
    const std::int64_t qx = q.x.raw, qy = q.y.raw, qz = q.z.raw, qw = q.w.raw;
    // q + (cosine - 1) q + sinc (h q), where h q has 64 bits.
    const auto moved = [c, sinc_less_1](std::int64_t from, std::int64_t by_h) {
        const std::int64_t change = c * from + by_h + (((by_h >> 30) * sinc_less_1) >> 9);
        return from * (1 << 16) + (change >> 18);
    };
    return nearly_normalized(moved(qx, hx * qw + hy * qz - hz * qy), moved(qy, hy * qw - hx * qz + hz * qx),
                             moved(qz, hx * qy - hy * qx + hz * qw), moved(qw, -hx * qx - hy * qy - hz * qz));
}

/// A turn of any angle. `v` has `fraction_bits` and a component of at least 1/16.
Quat turned(Quat q, std::array<std::int64_t, 3> v, int fraction_bits) {
    // Scaled exactly to 54 bits if it is shorter; to 61 bits if it is longer than that.
    const int bits = bit_length(magnitude(v[0]) | magnitude(v[1]) | magnitude(v[2]));
    const int spare = bits < 54 ? 54 - bits : bits > 61 ? 61 - bits : 0;
    for (std::int64_t& c : v) c = scaled(c, -spare);
    const Wide n = Wide::product(v[0], v[0]) + Wide::product(v[1], v[1]) + Wide::product(v[2], v[2]);
    const std::uint64_t high = static_cast<std::uint64_t>(n.high_bits()), low = n.low_bits();
    const InverseRoot r = inverse_root(high, low);
    const SinCos62 t = sin_cos_62(static_cast<std::int64_t>(isqrt(high, low)), fraction_bits + spare + 1);
    const auto axis = [&](std::int64_t c) { return mul62(scaled_to_60(c, r), t.sin); };
    const std::int64_t x = axis(v[0]), y = axis(v[1]), z = axis(v[2]), w = t.cos >> 2; // 60 bits
    const std::int64_t qx = q.x.raw, qy = q.y.raw, qz = q.z.raw, qw = q.w.raw;
    const auto sum = [](Wide a, Wide b, Wide c, Wide d) {
        return static_cast<std::int64_t>((((a + b) + (c + d)) >> 33).low_bits());
    };
    const auto p = [](std::int64_t a, std::int64_t b) { return Wide::product(a, b); };
    return normalized_quat(
        sum(p(w, qx), p(x, qw), p(y, qz), p(-z, qy)), sum(p(w, qy), p(-x, qz), p(y, qw), p(z, qx)),
        sum(p(w, qz), p(x, qy), p(-y, qx), p(z, qw)), sum(p(w, qw), p(-x, qx), p(-y, qy), p(-z, qz)));
}

} // namespace

Quat integrate_rotation(Quat q, const std::array<std::int64_t, 3>& v, int fraction_bits) {
    const std::uint64_t largest = std::max({magnitude(v[0]), magnitude(v[1]), magnitude(v[2])});
    const int bits = bit_length(largest); // |component| < 2^(bits - fraction_bits)
    if (bits > std::max(fraction_bits - SmallTurn::least_bits, 0)) return turned(q, v, fraction_bits);
    const int drop = fraction_bits + 1 - 34;
    return turned_slightly(q, scaled(v[0], drop), scaled(v[1], drop), scaled(v[2], drop));
}

} // namespace detail
} // namespace lockstone
