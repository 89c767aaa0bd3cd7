// Bounds contain the shape and its margin, and little more.
#include "collide/bounds.h"
#include "oracle/double_shapes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::collide;
using oracle::D3;
using oracle::to_double;

namespace {

/// Empty when the bounds hold the shape grown by `margin`, and are at most two steps and 2 um wider.
std::string check_bounds(const Bounds& bounds, const Geometry& g, const Transform& pose, double margin,
                         int shift) {
    oracle::Placed s = oracle::place_a(g);
    const Rotation r = to_rotation(pose.rotation);
    s.axes = {to_double(r.x), to_double(r.y), to_double(r.z)};
    const double step = std::ldexp(1.0, shift - 16), slack = 2 * step + 2e-6;
    const D3 at = to_double(pose.position);
    for (int i = 0; i < 3; ++i) {
        D3 axis{0, 0, 0};
        axis[i] = 1;
        const double reach = oracle::support(s, axis) + margin;
        const double over_high = std::ldexp(to_double(bounds.upper[i]), shift) - (at[i] + reach);
        const double over_low = (at[i] - reach) - std::ldexp(to_double(bounds.lower[i]), shift);
        if (over_high < 0 || over_low < 0) return "too small on axis " + std::to_string(i);
        if (over_high > slack || over_low > slack) return "too large on axis " + std::to_string(i);
    }
    return {};
}

} // namespace

TEST_CASE("bounds are rounded outward by at most two steps, and a wrong one is reported") {
    constexpr ShapeKind kinds[] = {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};
    oracle::Random random(21);
    for (int i = 0; i < 20000; ++i) {
        const Geometry g = oracle::random_shape(random, kinds[i % 3], random.log_uniform(0.0125, 60));
        const int shift = i % 5 == 0 ? static_cast<int>(random.below(9)) : 0;
        const auto place = [&] { return oracle::quantize<Real>(random.uniform(-30000, 30000)); };
        const Real x = place(), y = place(), z = place();
        const Transform pose{{x, y, z}, random.rotation(0, 3)};
        const Length margin = oracle::quantize<Length>(random.uniform(0, 0.1));
        const Bounds good = bounds_of({g}, pose, margin, shift);
        const auto verdict = [&](const Bounds& b) {
            return check_bounds(b, g, pose, to_double(margin), shift);
        };
        REQUIRE(verdict(good) == "");
        if (g.kind == ShapeKind::sphere) {
            CHECK(bounds_of_ball(g, pose.position, margin, shift) == good);
            Geometry larger = g; // planted
            larger.radius += decimal<Length>("0.01");
            CHECK(bounds_of_ball(larger, pose.position, margin, shift) != good);
        }
        Bounds bad = good; // planted
        bad.upper.x = Bound::from_raw(bad.upper.x.raw - 3);
        CHECK(verdict(bad) != "");
        bad = good;
        bad.lower.z = Bound::from_raw(bad.lower.z.raw - 3);
        CHECK(verdict(bad) != "");
    }
}

TEST_CASE("bounds beyond the range are clamped to the border and still meet there") {
    const Transform far{{10'000'000_r, 0_r, 0_r}, Quat::identity()},
        further{{20'000'000_r, 0_r, 0_r}, Quat::identity()};
    const Bounds a = bounds_of({sphere(1_r)}, far, Length{}), b = bounds_of({sphere(1_r)}, further, Length{});
    CHECK(a.upper.x == Bound::max());
    CHECK(overlap(a, b));
    CHECK(!overlap(a, bounds_of({sphere(1_r)}, Transform::identity(), Length{})));
    const Bounds wide =
        bounds_of({sphere(1_r)}, {{8'000'000_r, 0_r, 0_r}, Quat::identity()}, Length{}, bounds_shift_max);
    CHECK(wide.upper.x < Bound::max());
}

TEST_CASE("a plane fills all space") {
    const Bounds everything = bounds_of({plane()}, Transform::identity(), Length{});
    CHECK(
        contains(everything, bounds_of({sphere(1_r)}, {{-90'000_r, 9_r, 0_r}, Quat::identity()}, Length{})));
    CHECK(half_area(everything) > 0);
}

TEST_CASE("closed bounds touch at a shared border") {
    const auto at = [](std::int32_t low, std::int32_t high) {
        const Bound l = Bound::from_raw(low), h = Bound::from_raw(high);
        return Bounds{{l, l, l}, {h, h, h}};
    };
    CHECK(overlap(at(0, 10), at(10, 20)));
    CHECK(!overlap(at(0, 10), at(11, 20)));
    CHECK(merge(at(0, 10), at(15, 20)) == at(0, 20));
    CHECK(contains(at(0, 10), at(0, 10)));
    CHECK(!contains(at(0, 10), at(0, 11)));
    CHECK(half_area(at(0, 40)) == 3 * 10 * 10);
}
