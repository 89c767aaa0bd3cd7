// Mass properties and volumes of primitives over the whole documented range, against MPFR.
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "oracle/big.h"
#include "shapes/submerged.h"
#include "support/rigs/scale_field.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <string>

using namespace lockstone;
using oracle::Big;

namespace {

/// Volume [m^3] and squared radii of gyration about the centre [m^2]; kz equals kx except for boxes. All at scale 1.
struct Exact {
    Big volume, kx, ky, kz;
};

/// Sums over thin discs across the y axis.
struct Discs {
    Big volume, along, square, first; ///< integrals of rho^2, rho^4, rho^2 y^2 and rho^2 y

    void add(Big weight, Big rho, Big y) {
        const Big disc = rho * rho * weight;
        volume = volume + disc, along = along + disc * rho * rho;
        square = square + disc * y * y, first = first + disc * y;
    }
    /// y = middle + r sin(phi), rho = out + r cos(phi) between two angles: smooth, so Simpson's rule is exact to 1e-11.
    void add_arc(Big middle, Big out, Big r, Big from, Big to) {
        constexpr int pieces = 200;
        const Big step = (to - from) / Big(2 * pieces);
        for (int i = 0; i <= 2 * pieces; ++i) {
            const Big phi = from + step * Big(i), share = i == 0 || i == 2 * pieces ? 1 : i % 2 == 1 ? 4 : 2;
            add(share * step / Big(3) * r * cos(phi), out + r * cos(phi), middle + r * sin(phi));
        }
    }
    /// A frustum: a polynomial of degree six at most, so Boole's rule with an error of h^7 over many pieces is enough.
    void add_frustum(Big y0, Big rho0, Big y1, Big rho1) {
        constexpr int pieces = 32;
        constexpr double weights[] = {7, 32, 12, 32, 7};
        for (int i = 0; i < pieces; ++i)
            for (int k = 0; k < 5; ++k) {
                const Big t = Big(4 * i + k) / Big(4 * pieces);
                add(Big(weights[k]) * (y1 - y0) / Big(90 * pieces), rho0 + (rho1 - rho0) * t,
                    y0 + (y1 - y0) * t);
            }
    }
    Exact result() const {
        const Big ky = along / volume / Big(2), center = first / volume;
        const Big kx = ky / Big(2) + square / volume - center * center;
        return {volume * Big::pi(), kx, ky, kx};
    }
};

Exact exact_box(const Geometry& g) {
    const Big h[3] = {Big(g.half_extent.x), Big(g.half_extent.y), Big(g.half_extent.z)}, r(g.radius);
    const Big pi = Big::pi();
    const auto volume_of = [&](const Big(&e)[3]) {
        return Big(8) * e[0] * e[1] * e[2] + Big(8) * r * (e[0] * e[1] + e[1] * e[2] + e[2] * e[0]) +
               Big(2) * pi * r * r * (e[0] + e[1] + e[2]) + Big(4) / Big(3) * pi * r * r * r;
    };
    // The integral of x^2: slices at x are rounded rectangles of area A(s), where s is the rounding that remains there.
    const auto moment = [&](int i) {
        const Big &a = h[i], &b = h[(i + 1) % 3], &c = h[(i + 2) % 3];
        const Big flat = Big(4) * b * c, line = Big(4) * (b + c);
        const Big inside = Big(2) / Big(3) * a * a * a * (flat + line * r + pi * r * r);
        // x = a + t, s^2 = r^2 - t^2: integrals over t in 0..r of (a + t)^2 (flat + line s + pi s^2).
        const Big r2 = r * r, r3 = r2 * r, r4 = r3 * r, r5 = r4 * r;
        const Big one = a * a * r + a * r2 + r3 / Big(3);
        const Big s = a * a * pi * r2 / Big(4) + Big(2) * a * r3 / Big(3) + pi * r4 / Big(16);
        const Big ss = a * a * Big(2) * r3 / Big(3) + a * r4 / Big(2) + Big(2) * r5 / Big(15);
        return inside + Big(2) * (flat * one + line * s + pi * ss);
    };
    const Big volume = volume_of(h), x = moment(0) / volume, y = moment(1) / volume, z = moment(2) / volume;
    return {volume, y + z, x + z, x + y};
}

Exact exact(const Geometry& g) {
    const Big b(g.half_extent.x), h(g.half_extent.y), r(g.radius), quarter = Big::pi() / Big(2);
    Discs discs;
    switch (g.kind) {
    case ShapeKind::sphere: {
        const Big k = Big(2) / Big(5) * r * r;
        return {Big(4) / Big(3) * Big::pi() * r * r * r, k, k, k};
    }
    case ShapeKind::capsule:
        discs.add_arc(-h, 0, r, -quarter, 0);
        if (Big(0) < h) discs.add_frustum(-h, r, h, r);
        discs.add_arc(h, 0, r, 0, quarter);
        return discs.result();
    case ShapeKind::cylinder:
        if (Big(0) < r) discs.add_arc(-h, b, r, -quarter, 0);
        discs.add_frustum(-h, b + r, h, b + r);
        if (Big(0) < r) discs.add_arc(h, b, r, 0, quarter);
        return discs.result();
    case ShapeKind::cone: {
        const Big lean = atan(b / (Big(2) * h)); // of the slant's outward direction over the horizontal
        if (Big(0) < r) discs.add_arc(-h, b, r, -quarter, lean);
        discs.add_frustum(-h + r * sin(lean), b + r * cos(lean), h + r * sin(lean), r * cos(lean));
        if (Big(0) < r) discs.add_arc(h, 0, r, lean, quarter);
        return discs.result();
    }
    default:
        return exact_box(g);
    }
}

/// The tolerance of a value: in steps of its format, and relative to the value.
struct Bound {
    double steps, relative;
};
/// Plain shapes have 62 bits and one rounding; rounded cones an angle of 32 fraction bits; the reference's arcs 1e-11.
Bound bound_of(const Geometry& g) {
    const bool is_rounded = g.radius > Length{} && g.kind != ShapeKind::sphere;
    const double relative = g.kind == ShapeKind::cone && is_rounded ? 4e-9 : is_rounded ? 1e-10 : 1e-17;
    return {0.501, relative};
}

template <FixedPoint T> bool is_off(T found, const Big& wanted, Bound bound, double factor = 1) {
    if (found == T::max()) return wanted < Big(found); // clamped
    const double step = 1.0 / static_cast<double>(std::uint64_t{1} << T::fraction_bits);
    const double allowed = factor * bound.steps * step + bound.relative * abs(wanted).to_double();
    return abs(Big(found) - wanted).to_double() > allowed;
}

/// Returns an error sentence unless the properties and the volume are right to within the bound.
std::string complaint(const Geometry& g, const MassProperties& m, shapes::Scaled volume, Real density) {
    Geometry at_one = g;
    at_one.scale = scale_one;
    const Exact e = exact(at_one);
    const double factor = static_cast<double>(g.scale.x.raw >> Length::fraction_bits),
                 cubed = factor * factor * factor;
    const Bound bound = bound_of(g);
    if (is_off(m.mass, e.volume * Big(cubed) * Big(density), bound, cubed)) return "mass";
    const Big square(factor * factor);
    if (is_off(m.gyration_squared.x.x, e.kx * square, bound, factor * factor)) return "x";
    if (is_off(m.gyration_squared.y.y, e.ky * square, bound, factor * factor)) return "y";
    if (is_off(m.gyration_squared.z.z, e.kz * square, bound, factor * factor)) return "z";
    const bool leans = g.kind == ShapeKind::cone; // a cone's centre is below the middle of its height
    if (m.center.x != Real{} || m.center.z != Real{} || (m.center.y != Real{} && !leans)) return "centre";
    const Matrix3<I20F44>& k = m.gyration_squared;
    for (const I20F44 beside : {k.x.y, k.x.z, k.y.x, k.y.z, k.z.x, k.z.y})
        if (beside != I20F44{}) return "product";
    Big found(volume.mantissa, 0);
    for (int i = volume.exponent; i != 0; i += i < 0 ? 1 : -1)
        found = i < 0 ? found / Big(2) : found * Big(2);
    const double step = e.volume < Big(21474) ? 1.2e-15 : 1.2e-10; // half a step of a Real, see volume_of
    const double off = abs(found - e.volume * Big(cubed)).to_double();
    if (off > cubed * step + bound.relative * cubed * e.volume.to_double() * 2) return "volume";
    return {};
}

std::string complaint(const Geometry& g, Real density) {
    return complaint(g, mass_properties(g, density), shapes::volume_of({.geometry = g}), density);
}

/// Sizes at the limits of the range and in between, by powers of two.
Real size(Random& random, Real high) {
    const Real low = to<Real>(shape_size_min);
    if (high <= low) return low;
    const std::uint32_t which = random.below(8);
    if (which < 2) return which == 0 ? low : high;
    const Real between = which < 4 ? random.range(low, high)
                                   : low + shift_right(high - low, static_cast<int>(random.below(16)));
    return to<Real>(to<Length>(between)); // as a geometry stores it, or sums would leave the range by a step
}

Geometry any_primitive(Random& random) {
    const Real most = to<Real>(shape_size_max);
    const Real a = size(random, most), b = size(random, most), c = size(random, most);
    const Real left = most - max(a, max(b, c));
    const Real rounding =
        random.below(2) == 0 || left <= to<Real>(shape_size_min) ? Real{} : size(random, left);
    switch (random.below(5)) {
    case 0:
        return sphere(a);
    case 1: {
        const Real segment = random.below(8) == 0 ? Real{} : min(b, most - a);
        return capsule(a, segment);
    }
    case 2:
        return rounded(cylinder(a, b), rounding);
    case 3:
        return rounded(cone(a, b), rounding);
    default:
        return rounded(box(a, b, c), rounding);
    }
}

} // namespace

TEST_CASE("mass and inertia and volume of primitives of 2.5 mm to 100 m at every scale are right to the last "
          "bits") {
    Random random = Random::seeded(7);
    const int tries = std::getenv("LOCKSTONE_LONG") != nullptr ? 100000 : 2000;
    int failures = 0;
    for (int i = 0; i < tries && failures < 5; ++i) {
        Geometry g = any_primitive(random);
        g = test::with_scale(g, Real(1 << random.below(4)));
        REQUIRE(validate(g) == "");
        const Real density = random.below(4) == 0 ? 0.01_r : size(random, Real(100000));
        const std::string what = complaint(g, density);
        if (what.empty()) continue;
        ++failures;
        INFO(what, " of a ", std::string(name_of(g.kind)), " of ", to_string(to<Real>(g.half_extent.x)), ", ",
             to_string(to<Real>(g.half_extent.y)), ", ", to_string(to<Real>(g.half_extent.z)), ", radius ",
             to_string(to<Real>(g.radius)), ", scale ", g.scale.x.raw >> 24, ", density ",
             to_string(density));
        CHECK(what == "");
    }
}

TEST_CASE(
    "cubes of 10700 to 21500 m^3 have the right volume although their mass at 100000 kg/m^3 takes 63 bits") {
    for (int i = 0; i <= 120; ++i) {
        const Real half_edge = Real(11) + Real(i) / Real(40); // 10,648 to 21,952 m^3
        CHECK(complaint(box(half_edge, half_edge, half_edge), Real(1)) == "");
    }
}

TEST_CASE("rounded cones of millimetres are as exact as those of metres") {
    const Real sizes[] = {0.0025_r, 0.004_r, 0.0055_r, 0.02_r, 3_r, 40_r};
    for (const Real base : sizes)
        for (const Real height : sizes)
            for (const Real rounding : sizes) {
                INFO(to_string(base), ", ", to_string(height), " rounded by ", to_string(rounding));
                CHECK(complaint(rounded(cone(base, height), rounding), Real(100000)) == "");
            }
}

TEST_CASE("planted fault: the test detects a cylinder's inertia in 64 bits and a volume with a lost bit") {
    const Geometry g = cylinder(Real(1), Real(95));
    const MassProperties good = mass_properties(g, Real(1));
    const shapes::Scaled volume = shapes::volume_of({.geometry = g});
    REQUIRE(complaint(g, good, volume, Real(1)) == "");
    MassProperties bad = good;
    const std::uint64_t r = static_cast<std::uint64_t>(g.half_extent.x.raw),
                        h = static_cast<std::uint64_t>(g.half_extent.y.raw);
    bad.gyration_squared.x.x = I20F44::from_raw(static_cast<std::int64_t>(3 * r * r + 4 * h * h) / (12 * 16));
    CHECK(complaint(g, bad, volume, Real(1)) == "x");
    CHECK(complaint(g, good, {volume.mantissa / 2, volume.exponent}, Real(1)) == "volume");
    bad = good, bad.mass += Real::step();
    CHECK(complaint(g, bad, volume, Real(1)) == "mass");
    bad = good, bad.center.y = Real::step();
    CHECK(complaint(g, bad, volume, Real(1)) == "centre");
    bad = good, bad.gyration_squared.x.y = I20F44::step();
    CHECK(complaint(g, bad, volume, Real(1)) == "product");
}

TEST_CASE(
    "scaled() keeps mantissas below 2^62 and values of 63 bits or that round up to 2^62 divide like others") {
    using shapes::Scaled;
    using shapes::scaled;
    constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
    for (const Scaled s : {scaled(most, 0), scaled(std::numeric_limits<std::int64_t>::min(), 0),
                           scaled(Wide::product(most, most), 0), scaled(Real::max())}) {
        CHECK(magnitude(s.mantissa) < std::uint64_t{1} << 62);
        CHECK(shapes::unscaled<Real>(s / s) == Real(1));
    }
    CHECK(shapes::unscaled<Real>(scaled(Real::max()) / scaled(Real(2))) == half(Real::max()));
}
