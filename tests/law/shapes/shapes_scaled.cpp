// scaled(): primitives of any size times any factor.
#include "lockstone/shape.h"
#include "support/random.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// A primitive with sizes of 2.5 mm to 90 m, some of them close to the limits.
Geometry any_primitive(RandomPoint& random) {
    const auto size = [&] { return real(std::exp(random(std::log(0.0025), std::log(90)))); };
    const auto kind = static_cast<std::uint32_t>(random(0, 8));
    switch (kind) {
    case 0:
        return sphere(size());
    case 1:
        return capsule(size(), random(0, 1) < 0.2 ? 0_r : size());
    case 2:
        return cylinder(size(), size());
    case 3:
        return cone(size(), size());
    case 4:
        return box(size(), size(), size());
    case 5:
        return rounded(cylinder(size(), size()), size());
    case 6:
        return rounded(cone(size(), size()), size());
    default:
        return rounded(box(size(), size(), size()), size());
    }
}

/// The rounded product of a size and a factor, in double precision: exact below 2^53 steps of the product.
bool is_product(Length result, Length size, Real factor) {
    const double exact = to_double(size) * to_double(factor) * 0x1p24;
    return std::abs(static_cast<double>(result.raw) - exact) <= 0.5 + 1e-6;
}

/// Returns what is wrong with scaled(), or an empty string. `wrong`: an error that is added to the factor.
std::string fault_of(const Geometry& g, Real factor, Real wrong = {}) {
    const Geometry made = scaled(g, factor + wrong);
    const bool is_one = made.scale == scale_one;
    if (is_one && !is_product(made.radius, g.radius, factor)) return "radius";
    for (int i = 0; i < 3; ++i)
        if (is_one && !is_product(made.half_extent[i], g.half_extent[i], factor)) return "half_extent";
    if (is_one) return validate(made);
    if (made.half_extent != g.half_extent || made.radius != g.radius) return "both are scaled";
    if (made.scale.x != to<Length>(factor)) return "scale";
    // The sizes alone must be out of range.
    Geometry sized = g;
    sized.radius = mul<Length>(g.radius, factor);
    sized.half_extent = scale<Length>(g.half_extent, factor);
    return validate(sized).empty() ? "sizes within their range are not multiplied" : "";
}

} // namespace

TEST_CASE(
    "scaled() multiplies the sizes of a primitive by any factor if the results are within their ranges") {
    RandomPoint random(3);
    int sized = 0, planted = 0;
    for (int i = 0; i < 20000; ++i) {
        const Geometry g = any_primitive(random);
        if (!validate(g).empty()) continue;
        const Real factor = real(std::exp(random(std::log(0.001), std::log(1000))));
        const std::string fault = fault_of(g, factor);
        INFO(std::string(name_of(g.kind)), " times ", to_double(factor));
        CHECK(fault == "");
        if (scaled(g, factor).scale != scale_one) continue;
        ++sized;
        planted += fault_of(g, factor, factor / 1000_r).empty() ? 0 : 1;
    }
    CHECK(sized > 5000);
    CHECK(planted > sized * 9 / 10); // the smallest sizes change by less than a step
}

TEST_CASE("is_sized() is true for the primitives that validate() accepts") {
    RandomPoint random(4);
    int good = 0, bad = 0;
    for (int i = 0; i < 20000; ++i) {
        Geometry g = any_primitive(random);
        if (i % 3 == 0) g.half_extent.y = real(random(-1, 120)) > 0_r ? Length(101) : Length::from_raw(-i);
        if (i % 5 == 0) g.half_extent.z = g.half_extent.x + Length::step();
        if (i % 7 == 0) g.radius = shape_size_max - g.half_extent.y + Length::step() * (i % 2);
        CHECK(is_sized(g) == validate(g).empty());
        ++(is_sized(g) ? good : bad);
    }
    CHECK(good > 1000);
    CHECK(bad > 1000);
    CHECK_FALSE(is_sized(instance(ShapeKind::hull, AssetId{5})));
}

TEST_CASE("scaled() is usable at compile time and keeps the scale 1 and reaches 800 m by the scale") {
    static_assert(scaled(sphere(1_r), 3_r) == sphere(3_r));
    static_assert(scaled(box(1_r, 2_r, 3_r), 0.5_r) == box(0.5_r, 1_r, 1.5_r));
    static_assert(scaled(capsule(0.5_r, 0_r), 1.5_r) == capsule(0.75_r, 0_r));
    static_assert(scaled(rounded(cone(1_r, 2_r), 0.5_r), 10_r) == rounded(cone(10_r, 20_r), 5_r));
    for (const int factor : {2, 4, 8}) {
        const Geometry huge = scaled(cylinder(100_r, 1_r), Real(factor));
        CHECK(validate(huge) == "");
        CHECK(huge.scale.x == Length(factor));
        Geometry half_as_large = cylinder(50_r, 0.5_r);
        half_as_large.scale = huge.scale;
        CHECK(scaled(huge, 0.5_r) == half_as_large);
    }
    CHECK(scaled(scaled(sphere(100_r), 2_r), 4_r) == scaled(sphere(100_r), 8_r));
    CHECK(scaled(instance(ShapeKind::mesh, AssetId{5}), 3_r).scale.y == Length(3));
    CHECK(validate(scaled(sphere(60_r), 3_r)) != "");
    CHECK(validate(scaled(sphere(1_r), 0_r)) != "");
    CHECK(validate(scaled(sphere(1_r), -2_r)) != "");
}

TEST_CASE("a scaled primitive is good for a dynamic body and falls like one of its sizes") {
    World w = made(World::create(small_def()));
    const BodyId ball = add(w, {.pose = at(0, 5, 0)}, {.geometry = scaled(sphere(0.125_r), 4_r)});
    const BodyId other = add(w, {.pose = at(9, 5, 0)}, {.geometry = sphere(0.5_r)});
    for (int t = 0; t < 30; ++t) w.tick();
    CHECK(w.mass(ball) == w.mass(other));
    CHECK(w.pose(ball).position.y == w.pose(other).position.y);
}
