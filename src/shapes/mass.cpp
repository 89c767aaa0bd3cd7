// Mass, centre and squared gyration radii of the solid shapes.
//
// source: Eberly, Game Physics, 2nd ed., 2.5.5 (solids of revolution, parallel axis theorem); the capsule's
// form is the sum of a cylinder and two hemispheres, simplified so that one division remains.
#include "lockstone/shape.h"

#include "lockstone/math/math.h"
#include "shapes/mass.h"

#include <algorithm>

namespace lockstone {
namespace {

using shapes::Scaled;
using shapes::scaled;
using shapes::unscaled;

constexpr I4F60 pi_thirds = decimal<I4F60>("1.04719755119659774615421446109316763");
constexpr I4F60 sphere_volume = decimal<I4F60>("4.18879020478639098461685784437267051"); // 4/3 pi

/// value / divisor for 0 <= value < 2^127, rounded; clamped to int64.
std::int64_t divide_rounded(Wide value, std::uint64_t divisor) {
    const Wide with_half = value + Wide::from(static_cast<std::int64_t>(divisor / 2));
    const std::uint64_t high = static_cast<std::uint64_t>(with_half.high_bits());
    if (high >= divisor) return std::numeric_limits<std::int64_t>::max();
    const std::uint64_t q = divide_128_by_64(high, with_half.low_bits(), divisor).quotient;
    return static_cast<std::int64_t>(std::min<std::uint64_t>(q, std::numeric_limits<std::int64_t>::max()));
}

MassProperties solid(Scaled volume, Real density, I20F44 xx, I20F44 yy, I20F44 zz) {
    return {unscaled<Real>(volume * scaled(density)), Vec3{}, Matrix3<I20F44>::diagonal(xx, yy, zz)};
}

// Sizes below are raw Lengths of at most 100 m: below 2^30.7, their squares below 2^61.4. Two squares add up in
// 64 bits; three or four times a square does not fit.

MassProperties sphere_mass(std::int64_t r, Real density) {
    const Scaled radius = scaled(r, Length::fraction_bits);
    const I20F44 k = I20F44::from_raw(divide_rounded(Wide::product(2 * r, r), 5 * 16)); // 2/5 r^2, F48 to F44
    return solid(scaled(sphere_volume) * radius * (radius * radius), density, k, k, k);
}

MassProperties box_mass(const LengthVec3& h, Real density) {
    const auto square = [](Length a) { return std::int64_t{a.raw} * a.raw; };
    const auto third = [](std::int64_t sum) {
        return I20F44::from_raw(divide_rounded(Wide::from(sum), 3 * 16));
    };
    const Scaled octant = scaled(h.x) * scaled(h.y) * scaled(h.z);
    return solid({octant.mantissa, octant.exponent + 3}, density, third(square(h.y) + square(h.z)),
                 third(square(h.x) + square(h.z)), third(square(h.x) + square(h.y)));
}

/// h half the segment, r the radius:
///   volume = pi/3 r^2 (6 h + 4 r)
///   k_y^2  = r^2 (15 h + 8 r) / (10 (3 h + 2 r))
///   k_x^2  = (20 h^3 + 40 h^2 r + 45 h r^2 + 16 r^3) / (20 (3 h + 2 r))
MassProperties capsule_mass(std::int64_t h, std::int64_t r, Real density) {
    const Scaled radius = scaled(r, Length::fraction_bits);
    const Scaled volume =
        scaled(pi_thirds) * (radius * radius) * scaled(6 * h + 4 * r, Length::fraction_bits);
    const std::uint64_t thirds = static_cast<std::uint64_t>(3 * h + 2 * r);
    if (thirds == 0) return solid(volume, density, I20F44{}, I20F44{}, I20F44{});
    const Wide along = Wide::product(r * r, 15 * h + 8 * r);
    const Wide across = Wide::product(h * h, 20 * h + 40 * r) + Wide::product(r * r, 45 * h + 16 * r);
    const I20F44 ky = I20F44::from_raw(divide_rounded(along, 10 * 16 * thirds));
    const I20F44 kx = I20F44::from_raw(divide_rounded(across, 20 * 16 * thirds));
    return solid(volume, density, kx, ky, kx);
}

/// volume = 2 pi r^2 h, k_y^2 = r^2 / 2, k_x^2 = r^2 / 4 + h^2 / 3
MassProperties cylinder_mass(std::int64_t r, std::int64_t h, Real density) {
    const Scaled radius = scaled(r, Length::fraction_bits);
    const Scaled volume = scaled(pi_thirds) * (radius * radius) * scaled(6 * h, Length::fraction_bits);
    const I20F44 ky = I20F44::from_raw(divide_rounded(Wide::product(r, r), 2 * 16));
    const Wide across = Wide::product(3 * r, r) + Wide::product(4 * h, h); // up to 7 * 2^61.3: beyond 64 bits
    const I20F44 kx = I20F44::from_raw(divide_rounded(across, 12 * 16));
    return solid(volume, density, kx, ky, kx);
}

/// volume = 2/3 pi r^2 h, centre at y = -h / 2, k_y^2 = 3/10 r^2, k_x^2 = 3/20 (r^2 + h^2)
MassProperties cone_mass(std::int64_t r, std::int64_t h, Real density) {
    const Scaled radius = scaled(r, Length::fraction_bits);
    const Scaled volume = scaled(pi_thirds) * (radius * radius) * scaled(2 * h, Length::fraction_bits);
    const I20F44 ky = I20F44::from_raw(divide_rounded(Wide::product(3 * r, r), 10 * 16));
    const I20F44 kx = I20F44::from_raw(divide_rounded(Wide::product(3, r * r + h * h), 20 * 16));
    MassProperties m = solid(volume, density, kx, ky, kx);
    m.center.y = round_from<Real>(-h, Length::fraction_bits + 1);
    return m;
}

MassProperties primitive_mass(const Geometry& g, Real density) {
    const LengthVec3& half = g.half_extent;
    const bool round = g.radius > Length{};
    switch (g.kind) {
    case ShapeKind::sphere:
        return sphere_mass(g.radius.raw, density);
    case ShapeKind::capsule:
        return capsule_mass(half.y.raw, g.radius.raw, density);
    case ShapeKind::cylinder:
        return round ? shapes::rounded_cylinder_mass(half.x, half.y, g.radius, density)
                     : cylinder_mass(half.x.raw, half.y.raw, density);
    case ShapeKind::cone:
        return round ? shapes::rounded_cone_mass(half.x, half.y, g.radius, density)
                     : cone_mass(half.x.raw, half.y.raw, density);
    case ShapeKind::box:
        return round ? shapes::rounded_box_mass(half, g.radius, density) : box_mass(half, density);
    default:
        return MassProperties{};
    }
}

/// A symmetric matrix; the lower triangle copies the upper.
Matrix3<I20F44> symmetric(const Matrix3<I20F44>& k) {
    return {{k.x.x, k.y.x, k.z.x}, {k.y.x, k.y.y, k.z.y}, {k.z.x, k.z.y, k.z.z}};
}

/// R K R^T for a symmetric K; the lower triangle copies the upper.
Matrix3<I20F44> rotated(Quat rotation, const Matrix3<I20F44>& k) {
    if (rotation == Quat::identity()) return symmetric(k); // the products would be exact
    const Rotation r = to_rotation(rotation);
    const Matrix3<I20F44> half_way = mul<I20F44>(r, k); // columns of R K
    const Matrix3<I20F44> rows = transpose(half_way);   // rows of R K
    const Rotation t = transpose(r);                    // rows of R
    const I20F44 xy = dot<I20F44>(rows.x, t.y), xz = dot<I20F44>(rows.x, t.z), yz = dot<I20F44>(rows.y, t.z);
    return {{dot<I20F44>(rows.x, t.x), xy, xz},
            {xy, dot<I20F44>(rows.y, t.y), yz},
            {xz, yz, dot<I20F44>(rows.z, t.z)}};
}

/// |d|^2 1 - d d^T: the contribution of a point mass at d to inertia / mass.
Matrix3<I20F44> point_gyration(Vec3 d) {
    using Sum = SumOfProducts<Real, Real>;
    const I20F44 xx = Sum{}.add(d.y, d.y).add(d.z, d.z).round<I20F44>();
    const I20F44 yy = Sum{}.add(d.x, d.x).add(d.z, d.z).round<I20F44>();
    const I20F44 zz = Sum{}.add(d.x, d.x).add(d.y, d.y).round<I20F44>();
    const I20F44 xy = Sum{}.sub(d.x, d.y).round<I20F44>(), xz = Sum{}.sub(d.x, d.z).round<I20F44>();
    const I20F44 yz = Sum{}.sub(d.y, d.z).round<I20F44>();
    return {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
}

} // namespace

MassProperties mass_properties(const Geometry& g, Real density) {
    return density < Real{} || !validate(g).empty() ? MassProperties{}
                                                    : shapes::mass_of_primitive(g, density);
}

MassProperties shapes::mass_of_primitive(const Geometry& g, Real density) {
    MassProperties m = primitive_mass(g, density);
    const std::int64_t factor = g.scale.x.raw >> Length::fraction_bits; // 1, 2, 4 or 8
    if (factor <= 1) return m;
    m.mass = m.mass * (factor * factor * factor);
    m.center = {m.center.x * factor, m.center.y * factor, m.center.z * factor};
    const auto square = [factor](const Vector3<I20F44>& c) {
        return Vector3<I20F44>{c.x * (factor * factor), c.y * (factor * factor), c.z * (factor * factor)};
    };
    m.gyration_squared = {square(m.gyration_squared.x), square(m.gyration_squared.y),
                          square(m.gyration_squared.z)};
    return m;
}

MassProperties combine(std::span<const MassPart> parts) {
    MassProperties body{};
    for (const MassPart& part : parts) body.mass += part.properties.mass;
    if (body.mass <= Real{}) return MassProperties{};
    if (parts.size() == 1) { // the share is one, and the part has no offset
        const MassProperties& only = parts[0].properties;
        body.center = parts[0].local * only.center;
        body.gyration_squared = rotated(parts[0].local.rotation, only.gyration_squared);
        return body;
    }
    const auto share = [&](const MassPart& part) {
        return I2F62::from_raw(divide_shifted(part.properties.mass.raw, body.mass.raw, I2F62::fraction_bits));
    };
    for (const MassPart& part : parts)
        body.center += scale<Real>(part.local * part.properties.center, share(part));
    for (const MassPart& part : parts) {
        const Vec3 offset = part.local * part.properties.center - body.center;
        const Matrix3<I20F44> about_body =
            rotated(part.local.rotation, part.properties.gyration_squared) + point_gyration(offset);
        const I2F62 s = share(part);
        const auto shared = [s](const Vector3<I20F44>& column) { return scale<I20F44>(column, s); };
        body.gyration_squared =
            body.gyration_squared +
            Matrix3<I20F44>{shared(about_body.x), shared(about_body.y), shared(about_body.z)};
    }
    return body;
}

PrincipalGyration principal_gyration(const MassProperties& properties) {
    const Matrix3<I20F44>& k = properties.gyration_squared;
    const std::int64_t widest = max(k.x.x, max(k.y.y, k.z.z)).raw;
    // Scales by a power of two so that `diagonalize` gets all significant bits of small bodies.
    const int shift = widest <= 0 ? 0 : 56 - std::min(56, bit_length(static_cast<std::uint64_t>(widest)));
    const auto column = [shift](const Vector3<I20F44>& c) {
        const auto scaled_up = [shift](I20F44 v) {
            return Real::from_raw(shift_left_saturated(v.raw, shift));
        };
        return Vec3{scaled_up(c.x), scaled_up(c.y), scaled_up(c.z)};
    };
    const Diagonal diagonal = diagonalize({column(k.x), column(k.y), column(k.z)});
    const auto radius = [shift](Real v) { // sqrt(raw 2^(-44 - shift)) in 32 fraction bits
        return Real::from_raw(static_cast<std::int64_t>(isqrt((Wide::from(v.raw) << 20) >> shift)));
    };
    return {{radius(diagonal.values.x), radius(diagonal.values.y), radius(diagonal.values.z)}, diagonal.axes};
}

} // namespace lockstone
