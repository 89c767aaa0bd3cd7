// Mass properties against closed forms, numerical integration and random sampling in double precision.
#include "lockstone/math/math.h"
#include "lockstone/shape.h"
#include "oracle/double_shapes.h"
#include "support/about.h"

#include <doctest/doctest.h>

#include <vector>

using namespace lockstone;
using oracle::D3;
using oracle::to_double;

namespace {

struct Reference {
    double mass, kx, ky; // squared gyration radii; kz = kx but for boxes
};

/// Thin discs across the local y axis, by Simpson's rule: knows nothing of the closed forms.
Reference integrate_round(const Geometry& g, double density) {
    const double r = to_double(g.radius), h = to_double(g.half_extent.y), top = h + r;
    double volume = 0, ky = 0, kx = 0;
    // The caps' discs are polynomials in y, the cylinder's are constant: Simpson is exact on each piece.
    const auto add = [&](double from, double to) {
        constexpr int pieces = 200;
        for (int i = 0; i <= 2 * pieces; ++i) {
            const double y = from + (to - from) * i / (2.0 * pieces);
            const double weight = (to - from) / (6.0 * pieces) *
                                  (i == 0 || i == 2 * pieces ? 1
                                   : i % 2 == 1              ? 4
                                                             : 2);
            const double past = std::max(0.0, std::abs(y) - h), square = std::max(0.0, r * r - past * past);
            const double disc = 3.14159265358979323846 * square * weight;
            volume += disc;
            ky += disc * square / 2;
            kx += disc * (square / 4 + y * y);
        }
    };
    add(-top, -h);
    if (h > 0) add(-h, h);
    add(h, top);
    return {volume * density, kx / volume, ky / volume};
}

/// Empty when the properties match within `relative`.
std::string check_round(const MassProperties& m, const Reference& e, double relative) {
    const auto close = [&](double x, double expected) {
        return std::abs(x - expected) <= relative * expected + 1e-13;
    };
    if (!(m.center == Vec3{})) return "centre";
    if (std::abs(to_double(m.mass) - e.mass) > 2e-10 + relative * e.mass) return "mass";
    if (!close(to_double(m.gyration_squared.x.x), e.kx) || !close(to_double(m.gyration_squared.z.z), e.kx))
        return "across";
    if (!close(to_double(m.gyration_squared.y.y), e.ky)) return "along";
    return {};
}

double entry(const Matrix3<I20F44>& m, int row, int column) {
    const Vector3<I20F44>& c = column == 0 ? m.x : column == 1 ? m.y : m.z;
    return to_double(c[row]);
}

} // namespace

TEST_CASE("spheres and capsules from 5 mm to 100 m match numerical integration") {
    oracle::Random random(31);
    for (int i = 0, good = 0; good < 500; ++i) {
        const double size = random.log_uniform(0.0125, 60);
        const Geometry g =
            oracle::random_shape(random, i % 2 == 0 ? ShapeKind::sphere : ShapeKind::capsule, size);
        if (!validate(g).empty()) continue; // a hair below 2.5 mm or above 100 m has no mass
        ++good;
        const double density = size < 1 ? 1000 : 10;
        const Reference expected = integrate_round(g, density);
        const MassProperties m = mass_properties(g, oracle::quantize<Real>(density));
        REQUIRE(check_round(m, expected, 1e-9) == "");
        MassProperties bad = m; // planted
        bad.gyration_squared.y.y = bad.gyration_squared.y.y + shift_right(bad.gyration_squared.y.y, 24);
        CHECK(check_round(bad, expected, 1e-9) == "along");
        bad = m;
        bad.mass += max(shift_right(bad.mass, 24), Real::step() * 3);
        CHECK(check_round(bad, expected, 1e-9) == "mass");
    }
}

TEST_CASE("boxes match their closed form") {
    oracle::Random random(37);
    for (int i = 0; i < 500; ++i) {
        const Geometry g = oracle::random_shape(random, ShapeKind::box, random.log_uniform(0.0125, 60));
        const MassProperties m = mass_properties(g, 50_r);
        const D3 h = to_double(g.half_extent);
        CHECK(to_double(m.mass) == test::about(50 * 8 * h.x * h.y * h.z, 1e-12 + 3e-10 / to_double(m.mass)));
        for (int k = 0; k < 3; ++k) {
            const double expected = (dot(h, h) - h[k] * h[k]) / 3;
            CHECK(std::abs(entry(m.gyration_squared, k, k) - expected) < 1e-13 + 1e-14 * expected);
            CHECK(entry(m.gyration_squared, k, (k + 1) % 3) == 0);
        }
    }
    CHECK(mass_properties(plane(), 50_r).mass == 0_r);
    CHECK(mass_properties(box(100_r, 100_r, 100_r), 1000_r).mass == Real::max()); // 8e9 kg
}

TEST_CASE("random sampling finds the same mass and inertia") {
    oracle::Random random(41);
    for (const Geometry& g : {sphere(0.7_r), capsule(0.3_r, 0.8_r), box(0.2_r, 0.5_r, 0.9_r)}) {
        oracle::Placed s = oracle::place_a(g);
        double inside = 0, sum[3] = {0, 0, 0};
        constexpr int samples = 400'000;
        for (int i = 0; i < samples; ++i) {
            const double x = random.uniform(-1.2, 1.2), y = random.uniform(-1.2, 1.2),
                         z = random.uniform(-1.2, 1.2);
            if (oracle::surface_distance(s, {x, y, z}) > 0) continue;
            inside += 1;
            sum[0] += y * y + z * z;
            sum[1] += x * x + z * z;
            sum[2] += x * x + y * y;
        }
        const MassProperties m = mass_properties(g, 2_r);
        // Three standard errors: of a share of all samples, and of a mean whose parts spread by no more than itself.
        const double share = inside / samples, off_share = 3 * std::sqrt((1 - share) / inside);
        CHECK(to_double(m.mass) == test::about(2 * share * 2.4 * 2.4 * 2.4, off_share));
        for (int k = 0; k < 3; ++k)
            CHECK(entry(m.gyration_squared, k, k) == test::about(sum[k] / inside, 3 / std::sqrt(inside)));
    }
}

namespace {

struct Body {
    double mass = 0;
    D3 center{0, 0, 0};
    double inertia[3][3] = {};
};

/// The parallel axis theorem in double, with masses instead of shares.
Body combine_double(const std::vector<MassPart>& parts) {
    Body body;
    std::vector<D3> at;
    for (const MassPart& part : parts) {
        const double m = to_double(part.properties.mass);
        at.push_back(to_double(part.local * part.properties.center));
        body.mass += m;
        body.center = body.center + at.back() * m;
    }
    body.center = body.center * (1 / body.mass);
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const Rotation rotation = to_rotation(parts[p].local.rotation);
        const D3 r[3] = {to_double(rotation.x), to_double(rotation.y), to_double(rotation.z)};
        const D3 d = at[p] - body.center;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                double k = (i == j ? dot(d, d) : 0) - d[i] * d[j];
                for (int a = 0; a < 3; ++a)
                    for (int b = 0; b < 3; ++b)
                        k += r[a][i] * entry(parts[p].properties.gyration_squared, a, b) * r[b][j];
                body.inertia[i][j] += k * to_double(parts[p].properties.mass) / body.mass;
            }
    }
    return body;
}

std::string check_body(const MassProperties& m, const Body& e, double relative) {
    if (std::abs(to_double(m.mass) - e.mass) > 1e-9 * e.mass + 1e-9) return "mass";
    const double size = e.inertia[0][0] + e.inertia[1][1] + e.inertia[2][2];
    if (norm(to_double(m.center) - e.center) > 1e-9 + relative * std::sqrt(size)) return "centre";
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(entry(m.gyration_squared, i, j) - e.inertia[i][j]) > relative * size)
                return "inertia";
    return {};
}

std::vector<MassPart> random_parts(oracle::Random& random) {
    std::vector<MassPart> parts;
    const double size = random.log_uniform(0.02, 20);
    for (std::uint32_t k = 0; k < 1 + random.below(6); ++k) {
        constexpr ShapeKind kinds[] = {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};
        const Geometry g = oracle::random_shape(random, kinds[random.below(3)], size);
        const auto place = [&] { return oracle::quantize<Real>(random.uniform(-size, size)); };
        const Real x = place(), y = place(), z = place();
        parts.push_back({mass_properties(g, 100_r), {{x, y, z}, random.rotation(0, 3)}});
    }
    return parts;
}

} // namespace

TEST_CASE("a body of several parts obeys the parallel axis theorem") {
    oracle::Random random(43);
    for (int i = 0; i < 500; ++i) {
        std::vector<MassPart> parts = random_parts(random);
        const Body expected = combine_double(parts);
        const MassProperties m = combine(parts);
        REQUIRE(check_body(m, expected, 2e-8) == "");
        CHECK(m.gyration_squared == transpose(m.gyration_squared));
        std::vector<MassPart> moved = parts; // planted
        moved[0].local.position.x += oracle::quantize<Real>(0.01 * std::sqrt(expected.inertia[0][0]));
        CHECK(check_body(combine(moved), expected, 2e-8) != "");
        std::reverse(parts.begin(), parts.end());
        CHECK(check_body(combine(parts), expected, 2e-8) == "");
    }
    CHECK(combine({}).mass == 0_r);
}

TEST_CASE("two halves of a box make the box") {
    const MassProperties whole = mass_properties(box(1_r, 0.5_r, 0.25_r), 8_r),
                         half = mass_properties(box(0.5_r, 0.5_r, 0.25_r), 8_r);
    const MassPart parts[] = {{half, {{-0.5_r, 0_r, 0_r}, Quat::identity()}},
                              {half, {{0.5_r, 0_r, 0_r}, Quat::identity()}}};
    const MassProperties m = combine(parts);
    CHECK(m.mass == whole.mass);
    CHECK(m.center == Vec3{});
    for (int k = 0; k < 3; ++k)
        CHECK(std::abs(entry(m.gyration_squared, k, k) - entry(whole.gyration_squared, k, k)) < 1e-12);
}

TEST_CASE("principal radii and axes put the gyration back together") {
    oracle::Random random(47);
    for (int i = 0; i < 200; ++i) {
        const MassProperties m = combine(random_parts(random));
        const PrincipalGyration p = principal_gyration(m);
        const Rotation rotation = to_rotation(p.axes);
        const D3 r[3] = {to_double(rotation.x), to_double(rotation.y), to_double(rotation.z)},
                 k = to_double(p.radii);
        const double size = dot(k, k);
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) {
                const double sum = r[0][a] * r[0][b] * k.x * k.x + r[1][a] * r[1][b] * k.y * k.y +
                                   r[2][a] * r[2][b] * k.z * k.z;
                REQUIRE(std::abs(sum - entry(m.gyration_squared, a, b)) <
                        2e-8 * size + 1e-9 * std::sqrt(size));
            }
    }
    const PrincipalGyration cube =
        principal_gyration(mass_properties(box(0.0025_r, 0.0025_r, 0.0025_r), 1000_r));
    CHECK(std::abs(to_double(cube.radii.x) - 0.0025 * std::sqrt(2.0 / 3)) <
          10 * std::ldexp(1, -32)); // ten steps of a Real
    CHECK(principal_gyration(MassProperties{}).radii == Vec3{});
}
