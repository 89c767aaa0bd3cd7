// Masses of hulls over the whole documented range, against MPFR.
#include "lockstone/asset.h"
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "oracle/big.h"
#include "shapes/hull/hull.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

using namespace lockstone;
using oracle::Big;
using shapes::Hull;

namespace {

using Big3 = std::array<Big, 3>;

Big3 operator-(const Big3& a, const Big3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Big3 cross(const Big3& a, const Big3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Big dot(const Big3& a, const Big3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Big length(const Big3& a) { return sqrt(dot(a, a)); }
Big3 big(const LengthVec3& v) { return {Big(v.x), Big(v.y), Big(v.z)}; }

/// Volume [m^3], centre [m] and gyration [m^2] about the origin of the coordinates, by the divergence theorem.
struct Exact {
    Big volume;
    Big3 center;
    std::array<Big3, 3> gyration;
};

Exact exact(const Hull& hull) {
    Exact e;
    std::array<Big3, 3> second;
    for (const auto& t : hull.triangles) {
        const Big3 p[3] = {big(hull.vertices[t[0]]), big(hull.vertices[t[1]]), big(hull.vertices[t[2]])};
        const Big d = dot(p[0], cross(p[1], p[2]));
        const Big3 s = {p[0][0] + p[1][0] + p[2][0], p[0][1] + p[1][1] + p[2][1],
                        p[0][2] + p[1][2] + p[2][2]};
        e.volume = e.volume + d / Big(6);
        for (std::size_t i = 0; i < 3; ++i) {
            e.center[i] = e.center[i] + d * s[i] / Big(24);
            for (std::size_t j = 0; j < 3; ++j)
                second[i][j] =
                    second[i][j] +
                    d / Big(120) * (s[i] * s[j] + p[0][i] * p[0][j] + p[1][i] * p[1][j] + p[2][i] * p[2][j]);
        }
    }
    for (Big& c : e.center) c = c / e.volume;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            second[i][j] = second[i][j] / e.volume - e.center[i] * e.center[j];
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            e.gyration[i][j] = i == j ? second[(i + 1) % 3][(i + 1) % 3] + second[(i + 2) % 3][(i + 2) % 3]
                                      : Big(0) - second[i][j];
    return e;
}

/// Steiner's formula [m^3]: volume + area r + edges times the angles between their faces r^2 / 2 + ball.
Big exact_rounded_volume(const Hull& hull, const Big& r) {
    std::map<std::pair<int, int>, std::vector<Big3>> normals; // of the triangles at an edge
    Big area, wedges;
    for (const auto& t : hull.triangles) {
        const Big3 a = big(hull.vertices[t[0]]), b = big(hull.vertices[t[1]]), c = big(hull.vertices[t[2]]);
        const Big3 n = cross(b - a, c - a);
        area = area + length(n) / Big(2);
        for (std::size_t k = 0; k < 3; ++k) normals[std::minmax<int>(t[k], t[(k + 1) % 3])].push_back(n);
    }
    for (const auto& [edge, n] : normals) {
        REQUIRE(n.size() == 2);
        // tan(x / 2) = |m x n| / (|m| |n| + m . n), which is precise at small angles.
        const Big angle =
            Big(2) * atan(length(cross(n[0], n[1])) / (length(n[0]) * length(n[1]) + dot(n[0], n[1])));
        const Big3 along = big(hull.vertices[static_cast<std::size_t>(edge.second)]) -
                           big(hull.vertices[static_cast<std::size_t>(edge.first)]);
        wedges = wedges + angle * length(along);
    }
    return exact(hull).volume + area * r + wedges * r * r / Big(2) + Big(4) / Big(3) * Big::pi() * r * r * r;
}

/// Sums of at most 506 triangles in 62 bits, about a point within the hull: 2^-50 of the summed value, and half a step
/// of the format. A gyration adds two such sums.
constexpr double relative = 0x1p-50;

template <FixedPoint T> bool is_off(T found, const Big& wanted, double steps, double scale) {
    const double step = 1.0 / static_cast<double>(std::uint64_t{1} << T::fraction_bits);
    return abs(Big(found) - wanted).to_double() > steps * step + relative * scale;
}

/// Returns an error sentence unless mass at 1 kg/m^3, centre and gyration are right.
std::string complaint(const Hull& hull, const MassProperties& found) {
    const Exact e = exact(hull);
    double size = 0; // of the hull, not its distance from the origin
    for (const LengthVec3& v : hull.vertices) size = std::max(size, length(big(v) - e.center).to_double());
    if (is_off(found.mass, e.volume, 0.501, e.volume.to_double())) return "mass";
    for (int i = 0; i < 3; ++i)
        if (is_off(found.center[i], e.center[static_cast<std::size_t>(i)], 0.501, size)) return "centre";
    const Vector3<I20F44> columns[3] = {found.gyration_squared.x, found.gyration_squared.y,
                                        found.gyration_squared.z};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            if (is_off(columns[j][static_cast<int>(i)], e.gyration[i][j], 0.501, 4 * size * size))
                return "gyration";
    return {};
}

Length coordinate(Random& random, Real middle, Real half_width) {
    return to<Length>(random.below(4) == 0
                          ? (random.below(2) == 0 ? middle - half_width : middle + half_width)
                          : random.range(middle - half_width, middle + half_width));
}

/// Hulls from the smallest to the largest, flat, long or round, anywhere within 100 m of the origin.
Result<Hull> any_hull(Random& random) {
    const Real least = to<Real>(shape_size_min), most = to<Real>(shape_size_max);
    Real half_width[3], middle[3];
    for (int i = 0; i < 3; ++i) {
        half_width[i] = random.below(4) == 0
                            ? (random.below(2) == 0 ? least : most)
                            : max(least, shift_right(most, static_cast<int>(random.below(16))));
        const Real room = most - half_width[i];
        middle[i] = random.below(3) == 0 ? room : random.below(2) == 0 ? -room : Real{};
    }
    std::vector<LengthVec3> points;
    for (std::uint32_t k = 4 + random.below(60); k > 0; --k)
        points.push_back({coordinate(random, middle[0], half_width[0]),
                          coordinate(random, middle[1], half_width[1]),
                          coordinate(random, middle[2], half_width[2])});
    return shapes::make_hull(points);
}

} // namespace

TEST_CASE("mass and centre and inertia of flat and long and far hulls of 5 mm to 200 m are right to the last "
          "bits") {
    Random random = Random::seeded(11);
    const int wanted = std::getenv("LOCKSTONE_LONG") != nullptr ? 20000 : 400;
    int made = 0;
    for (int i = 0; i < 20 * wanted && made < wanted; ++i) {
        const Result<Hull> hull = any_hull(random);
        if (!hull) continue; // too thin
        ++made;
        INFO("hull ", i, " of ", hull->vertices.size(), " corners");
        CHECK(complaint(*hull, hull->properties) == "");
    }
    CHECK(made == wanted);
}

TEST_CASE("volumes of rounded hulls are right to a relative error of 4e-9") {
    // Angles between faces have 32 fraction bits; the normals have 30.
    Random random = Random::seeded(12);
    for (int i = 0; i < 400; ++i) {
        const Result<Hull> hull = any_hull(random);
        if (!hull) continue;
        const Length radius =
            to<Length>(shift_right(to<Real>(shape_size_max), static_cast<int>(random.below(16))));
        const Big expected = exact_rounded_volume(*hull, Big(radius));
        const Real found = shapes::unscaled<Real>(shapes::rounded_volume(*hull, shapes::scaled(radius)));
        INFO("hull ", i, ", radius ", to_string(to<Real>(radius)));
        CHECK(abs(Big(found) - expected).to_double() <= 0x1p-32 + 4e-9 * expected.to_double());
    }
}

TEST_CASE("planted fault: the test detects a mass or a centre or an inertia that is slightly off") {
    Random random = Random::seeded(13);
    for (int i = 0; i < 40; ++i) {
        const Result<Hull> hull = any_hull(random);
        if (!hull) continue;
        MassProperties bad = hull->properties;
        bad.mass += Real::step() * 2 + shift_right(bad.mass, 48);
        CHECK(complaint(*hull, bad) == "mass");
        bad = hull->properties;
        bad.center.y += Real::step() * 2;
        CHECK(complaint(*hull, bad) == "centre");
        bad = hull->properties;
        const Matrix3<I20F44>& k = hull->properties.gyration_squared;
        bad.gyration_squared.x.x = k.x.x + I20F44::step() * 2 + shift_right(k.x.x + k.y.y + k.z.z, 44);
        CHECK(complaint(*hull, bad) == "gyration");
    }
}
