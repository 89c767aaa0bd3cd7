// Mass properties of bodies of several parts, and principal axes, against double precision.
#include "lockstone/math/math.h"
#include "lockstone/shape.h"
#include "oracle/double_shapes.h"
#include "support/about.h"

#include <doctest/doctest.h>

#include <vector>

using namespace lockstone;
using oracle::as_double;
using oracle::D3;

namespace {

double entry(const Matrix3<I20F44>& m, int row, int column) {
    const Vector3<I20F44>& c = column == 0 ? m.x : column == 1 ? m.y : m.z;
    return as_double(c[row]);
}

struct Body {
    double mass = 0;
    D3 center{0, 0, 0};
    double inertia[3][3] = {};
};

/// The parallel axis theorem in double precision, with masses instead of shares.
Body combine_double(const std::vector<MassPart>& parts) {
    Body body;
    std::vector<D3> at;
    for (const MassPart& part : parts) {
        const double m = as_double(part.properties.mass);
        at.push_back(as_double(part.local * part.properties.center));
        body.mass += m;
        body.center = body.center + at.back() * m;
    }
    body.center = body.center * (1 / body.mass);
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const Rotation rotation = to_rotation(parts[p].local.rotation);
        const D3 r[3] = {as_double(rotation.x), as_double(rotation.y), as_double(rotation.z)};
        const D3 d = at[p] - body.center;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                double k = (i == j ? dot(d, d) : 0) - d[i] * d[j];
                for (int a = 0; a < 3; ++a)
                    for (int b = 0; b < 3; ++b)
                        k += r[a][i] * entry(parts[p].properties.gyration_squared, a, b) * r[b][j];
                body.inertia[i][j] += k * as_double(parts[p].properties.mass) / body.mass;
            }
    }
    return body;
}

std::string check_body(const MassProperties& m, const Body& e, double relative) {
    if (std::abs(as_double(m.mass) - e.mass) > 1e-9 * e.mass + 1e-9) return "mass";
    const double size = e.inertia[0][0] + e.inertia[1][1] + e.inertia[2][2];
    if (norm(as_double(m.center) - e.center) > 1e-9 + relative * std::sqrt(size)) return "centre";
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(entry(m.gyration_squared, i, j) - e.inertia[i][j]) > relative * size)
                return "inertia";
    return {};
}

std::vector<MassPart> random_parts(oracle::RandomReal& random) {
    std::vector<MassPart> parts;
    const double size = random.log_uniform(0.02, 20);
    for (std::uint32_t k = 0; k < 1 + random.below(6); ++k) {
        constexpr ShapeKind kinds[] = {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};
        const Geometry g = oracle::random_shape(random, kinds[random.below(3)], size);
        const auto place = [&] { return oracle::as_fixed<Real>(random.uniform(-size, size)); };
        const Real x = place(), y = place(), z = place();
        parts.push_back({mass_properties(g, 100_r), {{x, y, z}, random.rotation(0, 3)}});
    }
    return parts;
}

} // namespace

TEST_CASE("a body of several parts obeys the parallel axis theorem") {
    oracle::RandomReal random(43);
    for (int i = 0; i < 500; ++i) {
        std::vector<MassPart> parts = random_parts(random);
        const Body expected = combine_double(parts);
        const MassProperties m = combine(parts);
        REQUIRE(check_body(m, expected, 2e-8) == "");
        CHECK(m.gyration_squared == transpose(m.gyration_squared));
        std::vector<MassPart> moved = parts; // planted
        moved[0].local.position.x += oracle::as_fixed<Real>(0.01 * std::sqrt(expected.inertia[0][0]));
        CHECK(check_body(combine(moved), expected, 2e-8) != "");
        std::reverse(parts.begin(), parts.end());
        CHECK(check_body(combine(parts), expected, 2e-8) == "");
    }
    CHECK(combine({}).mass == 0_r);
    CHECK(mass_properties(plane(), 50_r).mass == 0_r);
}

TEST_CASE("a body of one part has the bits of a body with a second part of no mass") {
    oracle::RandomReal random(53);
    for (int i = 0; i < 500; ++i) {
        std::vector<MassPart> parts = random_parts(random);
        parts.resize(1);
        if (i % 3 == 0) parts[0].local.rotation = Quat::identity();
        if (i % 5 == 0) parts[0].local.position = {};
        const MassProperties alone = combine(parts);
        parts.push_back({{}, {{3_r, 4_r, 5_r}, random.rotation(0, 3)}});
        const MassProperties both = combine(parts);
        CHECK(alone.mass == both.mass);
        CHECK(alone.center == both.center);
        CHECK(alone.gyration_squared == both.gyration_squared);
    }
}

TEST_CASE("two halves of a box combine to the mass properties of the box") {
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

TEST_CASE("the principal radii and axes reproduce the gyration") {
    oracle::RandomReal random(47);
    for (int i = 0; i < 200; ++i) {
        const MassProperties m = combine(random_parts(random));
        const PrincipalGyration p = principal_gyration(m);
        const Rotation rotation = to_rotation(p.axes);
        const D3 r[3] = {as_double(rotation.x), as_double(rotation.y), as_double(rotation.z)},
                 k = as_double(p.radii);
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
    CHECK(std::abs(as_double(cube.radii.x) - 0.0025 * std::sqrt(2.0 / 3)) <
          10 * std::ldexp(1, -32)); // ten steps of a Real
    CHECK(principal_gyration(MassProperties{}).radii == Vec3{});
}
