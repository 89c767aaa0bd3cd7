// Bounds contain the shape and its margin, and are only a little larger. Every instruction set computes the same bounds
// for many shapes at once.
#include "collide/bounds.h"
#include "oracle/double_shapes.h"
#include "solve/kernels/kernels.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::collide;
using oracle::as_double;
using oracle::D3;

namespace {

/// Returns an error sentence unless the bounds contain the shape grown by `margin` and are at most two steps and 2 um
/// wider.
std::string check_bounds(const Bounds& bounds, const Geometry& g, const Transform& pose, double margin,
                         int shift) {
    oracle::Placed s = oracle::place_a(g);
    const Rotation r = to_rotation(pose.rotation);
    s.axes = {as_double(r.x), as_double(r.y), as_double(r.z)};
    const double step = std::ldexp(1.0, shift - 16), slack = 2 * step + 2e-6;
    const D3 at = as_double(pose.position);
    for (int i = 0; i < 3; ++i) {
        D3 axis{0, 0, 0};
        axis[i] = 1;
        const double reach = oracle::support(s, axis) + margin;
        const double over_high = std::ldexp(as_double(bounds.upper[i]), shift) - (at[i] + reach);
        const double over_low = (at[i] - reach) - std::ldexp(as_double(bounds.lower[i]), shift);
        if (over_high < 0 || over_low < 0) return "too small on axis " + std::to_string(i);
        if (over_high > slack || over_low > slack) return "too large on axis " + std::to_string(i);
    }
    return {};
}

} // namespace

TEST_CASE("bounds are rounded outward by at most two steps and the check reports wrong bounds") {
    constexpr ShapeKind kinds[] = {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};
    oracle::RandomReal random(21);
    for (int i = 0; i < 20000; ++i) {
        const Geometry g = oracle::random_shape(random, kinds[i % 3], random.log_uniform(0.0125, 60));
        const int shift = i % 5 == 0 ? static_cast<int>(random.below(9)) : 0;
        const auto place = [&] { return oracle::as_fixed<Real>(random.uniform(-30000, 30000)); };
        const Real x = place(), y = place(), z = place();
        const Transform pose{{x, y, z}, random.rotation(0, 3)};
        const Length margin = oracle::as_fixed<Length>(random.uniform(0, 0.1));
        const Bounds good = bounds_of({g}, pose, margin, shift);
        const auto verdict = [&](const Bounds& b) {
            return check_bounds(b, g, pose, as_double(margin), shift);
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

namespace {

/// The input of a kernel for one shape, and the axes and bounds that it returns.
struct Entry {
    Geometry geometry;
    Transform pose;
    Length margin;
    Rotation axes;
    Bounds bounds;
};

void put(RoundBoxes& boxes, std::uint32_t at, Entry& e) {
    boxes.rotation[at] = &e.pose.rotation.x.raw;
    boxes.axes[at] = &e.axes.x.x.raw, boxes.bounds[at] = &e.bounds.lower.x.raw;
    for (int i = 0; i < 3; ++i) {
        const bool has_extent = e.geometry.kind == ShapeKind::box || i == 1;
        boxes.position[i][at] = e.pose.position[i].raw;
        boxes.half[i][at] = has_extent ? e.geometry.half_extent[i].raw : 0;
    }
    boxes.margin[at] = e.margin.raw + bounds_guard, boxes.radius[at] = e.geometry.radius.raw;
}

/// A random entry. Six of seven are within 16 km. One of thirteen has a rotation that is not a unit quaternion.
Entry random_entry(oracle::RandomReal& random, int i) {
    Entry e{};
    const double far = i % 7 == 0 ? 60000 : 16300;
    e.geometry = oracle::random_shape(random, i % 2 == 0 ? ShapeKind::capsule : ShapeKind::box,
                                      random.log_uniform(0.0125, 60));
    for (int k = 0; k < 3; ++k)
        e.pose.position[k] =
            oracle::as_fixed<Real>(i % 3 == 0 ? random.uniform(-2, 2) : random.uniform(-far, far));
    e.pose.rotation = i % 13 == 0 ? Quat{Unit{}, unit_one, unit_one, unit_one} : random.rotation(0, 3);
    e.margin = oracle::as_fixed<Length>(random.uniform(0, 3));
    return e;
}

} // namespace

TEST_CASE(
    "every instruction set computes the same bounds and axes for many capsules and boxes as for each alone") {
    for (const Simd level :
         {Simd::scalar, Simd::sse41, Simd::avx2, Simd::avx512, Simd::neon, Simd::wasm128}) {
        const solve::Kernels* kernels = solve::kernels_of(level);
        if (kernels == nullptr) continue;
        oracle::RandomReal random(22);
        int done = 0, left_over = 0;
        for (int round = 0; round < 2000; ++round) {
            constexpr std::uint32_t lanes = RoundBoxes::lanes_max, count = 2 * lanes;
            const int shift = round % 9;
            Entry entries[count];
            RoundBoxes boxes;
            for (std::uint32_t i = 0; i < count; ++i) {
                entries[i] = random_entry(random, static_cast<int>(count) * round + static_cast<int>(i));
                put(boxes, i, entries[i]);
            }
            const std::uint32_t left = kernels->bounds->place(boxes, count, bounds_drop(shift));
            for (std::uint32_t i = 0; i < count; ++i) {
                const Entry& e = entries[i];
                const Rotation axes = to_rotation(e.pose.rotation);
                const Bounds bounds = bounds_of({e.geometry}, e.pose.position, axes, e.margin, shift);
                bool is_far = false;
                for (int k = 0; k < 3; ++k) is_far = is_far || abs(e.pose.position[k]) > 17'000_r;
                if (((left >> i) & 1u) != 0) {
                    ++left_over;
                    CHECK((is_far || abs(e.pose.position.x) > 16'000_r || abs(e.pose.position.y) > 16'000_r ||
                           abs(e.pose.position.z) > 16'000_r || e.pose.rotation.x == Unit{}));
                    continue;
                }
                ++done;
                REQUIRE(!is_far);
                REQUIRE(e.axes == axes);
                REQUIRE(e.bounds == bounds);
                const Length more = e.margin + decimal<Length>("0.001"); // planted
                CHECK(bounds_of({e.geometry}, e.pose.position, axes, more, 0) !=
                      bounds_of({e.geometry}, e.pose.position, axes, e.margin, 0));
            }
        }
        CHECK(done > 10000);
        CHECK(left_over > 1000);
    }
}

TEST_CASE("bounds beyond the range are clamped to the border and still overlap there") {
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

TEST_CASE("the bounds of a plane contain all space") {
    const Bounds everything = bounds_of({plane()}, Transform::identity(), Length{});
    CHECK(
        contains(everything, bounds_of({sphere(1_r)}, {{-90'000_r, 9_r, 0_r}, Quat::identity()}, Length{})));
    CHECK(half_area(everything) > 0);
}

TEST_CASE("two closed bounds that share a border overlap") {
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
