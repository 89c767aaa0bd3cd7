// Rounded boxes by Steiner's decomposition, rounded cylinders and cones by Pappus's theorem.
//
// source: Schneider, Convex Bodies, 4.1 (Steiner); Eberly, Game Physics, 2nd ed., 2.5.5 (solids of revolution).
#include "shapes/mass.h"

#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone::shapes {
namespace {

Scaled over(Scaled a, std::int32_t n) { return a / scaled(n, 0); }
Scaled square(Scaled a) { return a * a; }

/// The integral of x^2 over a box (a, b, c) rounded by r: the sum over the core, the slabs on its faces, the
/// quarter cylinders along its edges and the eighths of a ball at its corners.
Scaled second_moment(Scaled a, Scaled b, Scaled c, Scaled r) {
    const Scaled mean = over(square(a), 3); // mean of x^2 over the core's width
    const Scaled across = mean * (8 * a) * (b * c + r * (b + c));
    const Scaled slabs_x = over(8 * b * c * r * (3 * square(a) + 3 * a * r + square(r)), 3);
    const Scaled along_x = 2 * (scaled_pi * square(r) * a) * mean;
    const Scaled disc =
        scaled_pi * square(r) * (square(a) + over(square(r), 4)) + over(8 * a * r * square(r), 3);
    const Scaled ball = over(4 * scaled_pi * r * square(r), 3);
    const Scaled corners = ball * (square(a) + over(3 * a * r, 4) + over(square(r), 5));
    return across + slabs_x + along_x + 2 * (b + c) * disc + corners;
}

/// Moments of a plane region at distances rho > 0 from the axis of revolution.
struct Profile {
    Scaled one{}, y{}, yy{}, rho_rho{}; ///< integrals of rho, rho y, rho y^2 and rho^3

    void add(Scaled weight, Scaled rho, Scaled at_y) {
        const Scaled w = weight * rho;
        one = one + w;
        y = y + w * at_y;
        yy = yy + w * square(at_y);
        rho_rho = rho_rho + w * square(rho);
    }
    /// Adds a parallelogram by a corner and two sides. Exact, because Simpson's rule is exact for cubics.
    void add_parallelogram(const Scaled (&from)[2], const Scaled (&u)[2], const Scaled (&v)[2]) {
        Scaled area = u[0] * v[1] - u[1] * v[0];
        if (area.mantissa < 0) area = -area;
        for (int i = 0; i <= 2; ++i)
            for (int j = 0; j <= 2; ++j) {
                const auto at = [&](int k) { return from[k] + over(i * u[k] + j * v[k], 2); };
                add(over((i == 1 ? 4 : 1) * ((j == 1 ? 4 : 1) * area), 36), at(0), at(1));
            }
    }
    void add_cone(Scaled r, Scaled h) {
        const Scaled w = over(square(r) * h, 3);
        one = one + w;
        y = y - over(w * h, 2);
        yy = yy + over(2 * w * square(h), 5);
        rho_rho = rho_rho + over(3 * w * square(r), 10);
    }
    struct Ray {
        Scaled angle, cos, sin;
    };
    /// Adds a sector of a disc around (rho, at_y) between two rays.
    void add_sector(Scaled rho, Scaled at_y, Scaled r, Ray from, Ray to) {
        const auto cubed = [](Scaled s) { return s * square(s); };
        const Scaled turn = to.angle - from.angle, sines = to.sin * to.cos - from.sin * from.cos;
        const Scaled r2 = over(square(r), 2), r3 = over(cubed(r), 3), r4 = over(square(square(r)), 4);
        const Scaled r5 = over(cubed(r) * square(r), 5);
        // Moments u^i v^j of the sector about its own centre.
        const Scaled m00 = r2 * turn, m10 = r3 * (to.sin - from.sin), m01 = r3 * (from.cos - to.cos);
        const Scaled m20 = over(r4 * (turn + sines), 2), m02 = over(r4 * (turn - sines), 2);
        const Scaled m11 = over(r4 * (square(to.sin) - square(from.sin)), 2);
        const Scaled cubes = over(cubed(to.sin) - cubed(from.sin), 3);
        const Scaled m30 = r5 * (to.sin - from.sin - cubes), m12 = r5 * cubes;
        const Scaled w = rho * m00 + m10, wv = rho * m01 + m11;
        one = one + w;
        y = y + at_y * w + wv;
        yy = yy + square(at_y) * w + 2 * (at_y * wv) + rho * m02 + m12;
        rho_rho = rho_rho + cubed(rho) * m00 + 3 * (square(rho) * m10) + 3 * (rho * m20) + m30;
    }

    MassProperties revolved(Real density) const {
        const Scaled center = y / one, along = rho_rho / one;
        const Scaled across = over(along, 2) + yy / one - square(center);
        const I20F44 kx = unscaled<I20F44>(across), ky = unscaled<I20F44>(along);
        return {unscaled<Real>(2 * scaled_pi * one * scaled(density)),
                {Real{}, unscaled<Real>(center), Real{}},
                Matrix3<I20F44>::diagonal(kx, ky, kx)};
    }
};

constexpr Scaled zero{0, 0}, plus_one{1, 0}, minus_one{-1, 0};

} // namespace

MassProperties rounded_box_mass(const LengthVec3& half_extent, Length radius, Real density) {
    const Scaled a = scaled(half_extent.x), b = scaled(half_extent.y), c = scaled(half_extent.z);
    const Scaled r = scaled(radius);
    const Scaled volume = 8 * a * b * c + 8 * r * (a * b + b * c + c * a) +
                          2 * scaled_pi * square(r) * (a + b + c) + over(4 * scaled_pi * r * square(r), 3);
    const Scaled xx = second_moment(a, b, c, r) / volume, yy = second_moment(b, c, a, r) / volume;
    const Scaled zz = second_moment(c, a, b, r) / volume;
    return {unscaled<Real>(volume * scaled(density)), Vec3{},
            Matrix3<I20F44>::diagonal(unscaled<I20F44>(yy + zz), unscaled<I20F44>(xx + zz),
                                      unscaled<I20F44>(xx + yy))};
}

MassProperties rounded_cylinder_mass(Length core_radius, Length half_height, Length radius, Real density) {
    const Scaled c = scaled(core_radius), h = scaled(half_height), r = scaled(radius);
    const Scaled quarter = over(scaled_pi, 2);
    Profile profile;
    profile.add_parallelogram({zero, -h - r}, {c, zero}, {zero, 2 * (h + r)});
    profile.add_parallelogram({c, -h}, {r, zero}, {zero, 2 * h});
    profile.add_sector(c, h, r, {zero, plus_one, zero}, {quarter, zero, plus_one});
    profile.add_sector(c, -h, r, {-quarter, zero, minus_one}, {zero, plus_one, zero});
    MassProperties m = profile.revolved(density);
    m.center = Vec3{};
    return m;
}

MassProperties rounded_cone_mass(Length base_radius, Length half_height, Length radius, Real density) {
    const Scaled b = scaled(base_radius), h = scaled(half_height), r = scaled(radius);
    const Scaled quarter = over(scaled_pi, 2);
    // The slant's outward direction is (2 h, b) / length. Both are first shifted to 2^27 or more: else the
    // length of a cone of millimetres would have a relative rounding error of 2e-8.
    const std::int64_t across = std::int64_t{2} * half_height.raw;
    const int up =
        60 - bit_length(static_cast<std::uint64_t>(std::max<std::int64_t>(across, base_radius.raw)));
    const Vec3 slant{Real::from_raw(across << up), Real::from_raw(std::int64_t{base_radius.raw} << up),
                     Real{}};
    const Scaled slant_length = scaled(length(slant));
    const Profile::Ray out{scaled(atan2(slant.y, slant.x)), scaled(slant.x) / slant_length,
                           scaled(slant.y) / slant_length};
    Profile profile;
    profile.add_cone(b, h);
    profile.add_parallelogram({zero, -h - r}, {b, zero}, {zero, r});
    profile.add_parallelogram({b, -h}, {-b, 2 * h}, {r * out.cos, r * out.sin});
    profile.add_sector(b, -h, r, {-quarter, zero, minus_one}, out);
    profile.add_sector(zero, h, r, out, {quarter, zero, plus_one});
    return profile.revolved(density);
}

} // namespace lockstone::shapes
