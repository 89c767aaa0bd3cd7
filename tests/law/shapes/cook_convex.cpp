// Hulls, their reduction, and the decomposition into convex parts.
#include "cook/decompose.h"
#include "support/about.h"
#include "support/cook_models.h"
#include "support/effort.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::cook;
using namespace cook_models;

namespace {

double volume_of(const std::vector<Convex>& parts) {
    double sum = 0;
    for (const Convex& part : parts) sum += part.volume;
    return sum;
}

Result<std::vector<Convex>> parts_of(const Soup& model, double deviation, std::uint32_t parts_max) {
    const Soup soup = compacted(welded(model));
    return decompose(soup, Surface(soup), {deviation, parts_max, 0.01});
}

} // namespace

TEST_CASE("the hull of a box's corners and inner points is the box") {
    std::vector<Point> points = box({-1, -2, -3}, {4, 5, 6}).vertices;
    for (std::uint64_t i = 0; i < 100; ++i) points.push_back(even_point(i));
    const Result<Convex> hull = convex_hull(points);
    REQUIRE(hull.ok());
    CHECK(hull->surface.vertices.size() == 8);
    CHECK(hull->surface.triangles.size() == 12);
    CHECK(hull->volume == test::about(5 * 7 * 9));
    CHECK(hull->beyond({0, 0, 0}) == test::about(-1));
    CHECK(hull->beyond({0, 8, 0}) == test::about(3));
}

TEST_CASE("convex_hull() returns an error for points in one plane or on one line and for too few points") {
    const std::vector<Point> square{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}};
    REQUIRE_FALSE(convex_hull(square).ok());
    CHECK(convex_hull(square).error().message.find("plane") != std::string::npos);
    CHECK_FALSE(convex_hull(std::vector<Point>(10, {1, 2, 3})).ok());
    CHECK_FALSE(convex_hull(std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}).ok());
    CHECK_FALSE(convex_hull(std::vector<Point>(3)).ok());
}

TEST_CASE("a reduced hull keeps its corner limit and lies inside the hull and is closer with more corners") {
    const Result<Convex> ball_hull = convex_hull(ball(1, 600));
    REQUIRE(ball_hull.ok());
    CHECK(ball_hull->surface.vertices.size() == 600);
    double before = 1;
    for (const std::uint32_t corners : {4u, 12u, 30u, 64u, 255u}) {
        const Result<Convex> few = reduced(*ball_hull, corners);
        REQUIRE(few.ok());
        CHECK(few->surface.vertices.size() <= corners);
        double most = 0;
        for (const Point& p : ball_hull->surface.vertices) most = std::max(most, distance(*few, p));
        CHECK(most < before);
        before = most;
        for (const Point& p : few->surface.vertices) CHECK(ball_hull->beyond(p) < 1e-9);
    }
    CHECK(before < 0.02); // a ball of 255 caps
}

TEST_CASE("the distance to a hull is that to its nearest face or edge or corner and libccd agrees") {
    const Result<Convex> cube = convex_hull(box({-1, -1, -1}, {1, 1, 1}).vertices);
    REQUIRE(cube.ok());
    for (const auto& [p, expected] : {std::pair<Point, double>{{3, 0.2, 0.1}, 2},
                                      {{4, 5, 0}, 5},
                                      {{3, 3, 2}, 3},
                                      {{0.5, -0.5, 0.5}, 0}}) {
        CHECK(distance(*cube, p) == test::about(expected));
        CHECK(ball_meets(*cube, p, expected + 1e-3));
        if (expected > 0) CHECK_FALSE(ball_meets(*cube, p, expected - 1e-3));
    }
}

TEST_CASE(
    "decompose() keeps a convex solid as one part and splits an L into two and a hollow box into six walls") {
    const auto cube = parts_of(box({0, 0, 0}, {1, 2, 3}), 0.01, 16);
    REQUIRE(cube.ok());
    CHECK(cube->size() == 1);
    const auto el = parts_of(bracket(), 0.01, 16);
    REQUIRE(el.ok());
    CHECK(el->size() == 2);
    CHECK(volume_of(*el) == test::about(4));
    const auto walls = parts_of(hollow_box(), 0.01, 16);
    REQUIRE(walls.ok());
    CHECK(walls->size() == 6);
    CHECK(volume_of(*walls) == test::about(64 - 8));
}

TEST_CASE("decompose() puts separate solids into separate parts") {
    Soup two = box({0, 0, 0}, {1, 1, 1});
    two.append(box({3, 0, 0}, {4, 1, 1}));
    const auto parts = parts_of(two, 0.01, 16);
    REQUIRE(parts.ok());
    CHECK(parts->size() == 2);
    CHECK(volume_of(*parts) == test::about(2));
}

TEST_CASE(
    "convex parts cover the solid and keep their number limit and exceed the solid less if there are more" *
    doctest::skip(test::is_too_long_here())) {
    const Soup ring = compacted(welded(torus(1, 0.3, 24, 8)));
    const Surface surface(ring);
    double before = 1e300;
    for (const std::uint32_t count : {2u, 8u, 24u}) {
        const auto parts = decompose(ring, surface, {0.01, count, 0.01});
        REQUIRE(parts.ok());
        CHECK(parts->size() <= count);
        CHECK(volume_of(*parts) < before);
        before = volume_of(*parts);
        for (const Point& p : ring.vertices) {
            double nearest = 1e300;
            for (const Convex& part : *parts) nearest = std::min(nearest, part.beyond(p));
            CHECK(nearest < 1e-9);
        }
    }
}

TEST_CASE("a surface with missing triangles still separates inside from outside") {
    Soup soup = hollow_box();
    soup.triangles.erase(soup.triangles.begin()); // removes half of one outer side
    const Surface surface(soup);
    CHECK(surface.contains({1.5, 0.3, 0.2}));
    CHECK_FALSE(surface.contains({0.1, 0.3, 0.2}));
    CHECK_FALSE(surface.contains({2.5, 0.3, 0.2}));
    double height = 0;
    CHECK(surface.top(0.1, 0.2, height));
    CHECK(height == test::about(2));
    CHECK_FALSE(surface.top(2.1, 0.2, height));
}
