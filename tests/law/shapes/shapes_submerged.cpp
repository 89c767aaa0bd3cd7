// The part of a shape below a plane, and its projected area, against sums over a fine grid in double precision.
#include "shapes/shown_area.h"
#include "shapes/submerged.h"
#include "support/about.h"
#include "support/effort.h"
#include "support/random.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Returns whether a point is inside a primitive.
bool inside(const Geometry& g, D3 p) {
    const D3 h = to_double(to<Real>(g.half_extent));
    const double r = to_double(g.radius), rho = std::hypot(p[0], p[2]);
    switch (g.kind) {
    case ShapeKind::sphere:
        return length(p) <= r;
    case ShapeKind::capsule:
        return length({p[0], std::max(std::abs(p[1]) - h[1], 0.0), p[2]}) <= r;
    case ShapeKind::cylinder:
        return rho <= h[0] && std::abs(p[1]) <= h[1];
    case ShapeKind::cone:
        return std::abs(p[1]) <= h[1] && rho <= h[0] * (h[1] - p[1]) / (2 * h[1]);
    default:
        return std::abs(p[0]) <= h[0] && std::abs(p[1]) <= h[1] && std::abs(p[2]) <= h[2];
    }
}

struct Part {
    double fraction;
    D3 center;
};
/// The part below the plane, by a grid of n^3 points.
Part part_below(const Geometry& g, D3 normal, double offset, int n) {
    const D3 h = to_double(to<Real>(g.half_extent));
    const double r = to_double(g.radius);
    const D3 reach{std::max(h[0], r), h[1] + r, std::max(h[2], r)};
    double all = 0, below = 0;
    D3 sum{};
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            for (int k = 0; k < n; ++k) {
                const D3 p{reach[0] * ((2 * i + 1.0) / n - 1), reach[1] * ((2 * j + 1.0) / n - 1),
                           reach[2] * ((2 * k + 1.0) / n - 1)};
                if (!inside(g, p)) continue;
                ++all;
                if (dot(p, normal) < offset) ++below, sum = sum + p;
            }
    return {below / all, below > 0 ? (1 / below) * sum : D3{}};
}

/// The largest errors over random planes.
struct Worst {
    double fraction = 0, center = 0;
};
Worst worst_of(const Geometry& g, double lie = 0) {
    Worst worst;
    const shapes::Solid solid{.geometry = g};
    RandomPoint random(7);
    const int planes = samples(12, 200), n = 70;
    for (int i = 0; i < planes; ++i) {
        const auto roll = [&] { return random(-1, 1); };
        const UnitVec3 un =
            normalized_or(vec(roll(), i % 4 == 0 ? 1 : roll(), i % 4 == 1 ? 0 : roll() * 0.5), axis_y);
        const D3 normal = to_double(un);
        const double offset = roll() * 0.8;
        const Part exact = part_below(g, normal, offset + lie, n);
        const shapes::Submerged s = shapes::submerged(solid, un, real(offset));
        worst.fraction = std::max(worst.fraction, std::abs(to_double(s.fraction) - exact.fraction));
        if (exact.fraction > 0.02)
            worst.center = std::max(worst.center, length(to_double(s.center) - exact.center));
    }
    return worst;
}

const std::vector<Geometry> primitives{sphere(real(0.6)), box(real(0.7), real(0.3), real(0.5)),
                                       capsule(real(0.3), real(0.5)), cylinder(real(0.5), real(0.4)),
                                       cone(real(0.6), real(0.5))};

} // namespace

TEST_CASE("the submerged part of a shape agrees with a count over a fine grid") {
    for (const Geometry& g : primitives) {
        INFO(std::string(name_of(g.kind)));
        const Worst worst = worst_of(g);
        CHECK(worst.fraction < to_double(shapes::submerged_error) + 0.004); // plus the error of the grid
        CHECK(worst.center < 0.012);
    }
}

TEST_CASE("planted fault: the grid comparison detects a plane that is two centimetres higher") {
    for (const Geometry& g : primitives) CHECK(worst_of(g, 0.02).fraction > 0.012);
}

TEST_CASE("the submerged part of every shape in every pose grows without jumps from dry to under water") {
    RandomPoint random(3);
    for (const Geometry& g : primitives)
        for (int way = 0; way < 20; ++way) {
            const auto roll = [&] { return random(-1, 1); };
            const UnitVec3 n = normalized_or(vec(roll(), roll(), roll()), axis_y);
            const shapes::Solid solid{.geometry = g};
            double last = 0;
            for (int i = -130; i <= 130; ++i) {
                const double now = to_double(shapes::submerged(solid, n, real(i * 0.01)).fraction);
                CHECK(now >= last - 1e-6);
                CHECK(now - last < 0.04);
                last = now;
            }
            CHECK(last == 1);
        }
}

TEST_CASE("submerged() returns 0 for a rounded box above the water and 1 for one below it") {
    const shapes::Solid solid{.geometry = rounded(box(real(0.4), real(0.2), real(0.3)), real(0.1))};
    CHECK(shapes::submerged(solid, axis_y, real(-0.301)).fraction == Unit{});
    CHECK(to_double(shapes::submerged(solid, axis_y, real(-0.29)).fraction) > 0.01);
    CHECK(shapes::submerged(solid, axis_y, real(0.301)).fraction == unit_one);
    CHECK(to_double(shapes::submerged(solid, axis_y, real(0.29)).fraction) < 0.99);
    CHECK(to_double(shapes::submerged(solid, axis_y, Real{}).fraction) == test::about(0.5));
}

TEST_CASE("submerged() returns the right fraction of cubes with half sizes from 2.5 mm to 100 m") {
    for (double size : {0.0025, 1.0, 100.0})
        for (double d : {-0.5, 0.0, 0.9}) {
            const shapes::Solid cube{.geometry = box(real(size), real(size), real(size))};
            CHECK(to_double(shapes::submerged(cube, axis_x, real(d * size)).fraction) ==
                  test::about((1 + d) / 2, 1e-5));
        }
}

TEST_CASE("shown_area() agrees with the shadow of a fine grid" * doctest::skip(test::is_too_long_here())) {
    RandomPoint random(5);
    for (const Geometry& g : primitives)
        for (int way = 0; way < 6; ++way) {
            const auto roll = [&] { return random(-1, 1); };
            const UnitVec3 d = normalized_or(vec(roll(), roll(), roll()), axis_y);
            const UnitVec3 u = any_perpendicular(d), v = normalized(cross<Real>(d, u));
            const D3 du = to_double(u), dv = to_double(v), dd = to_double(d);
            const int n = 160;
            int hit = 0;
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) {
                    bool shade = false;
                    for (int k = 0; k < n && !shade; ++k)
                        shade = inside(g, (2.2 * i / n - 1.1) * du + (2.2 * j / n - 1.1) * dv +
                                              (2.2 * k / n - 1.1) * dd);
                    hit += shade;
                }
            INFO(std::string(name_of(g.kind)));
            const double area = hit * (2.2 / n) * (2.2 / n);
            CHECK(to_double(shapes::shown_area({.geometry = g}, d).area) == test::about(area, 0.03));
        }
}
