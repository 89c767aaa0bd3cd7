// Functions that make shapes: they refuse invalid ones with a helpful sentence.
#include "lockstone/shape.h"
#include "support/rigs/scale_field.h"

#include <doctest/doctest.h>

using namespace lockstone;

namespace {

bool mentions(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

} // namespace

TEST_CASE("shapes are built at compile time from exact sizes") {
    constexpr Geometry ball = sphere(0.5_r), pill = capsule(0.25_r, 1_r), crate = box(1_r, 2_r, 3_r);
    static_assert(ball.radius == decimal<Length>("0.5"));
    static_assert(pill.half_extent.y == Length(1) && pill.radius == decimal<Length>("0.25"));
    static_assert(crate.half_extent == LengthVec3{Length(1), Length(2), Length(3)});
    static_assert(box(Vec3{1_r, 2_r, 3_r}) == crate && plane().kind == ShapeKind::plane);
    CHECK(ball != pill);
}

TEST_CASE("validate() accepts shapes within their ranges") {
    for (const Geometry& g : {sphere(0.0025_r), sphere(100_r), capsule(0.01_r, 0_r), capsule(50_r, 50_r),
                              box(100_r, 0.0025_r, 1_r), plane()})
        CHECK(validate(g) == "");
}

TEST_CASE("validate() rejects a bad shape and reports the field with its value and range") {
    CHECK(validate(sphere(0.001_r)) == "sphere radius is 0.001 m, it must be in 0.0025 m .. 100 m");
    CHECK(mentions(validate(sphere(-1_r)), "sphere radius is -1 m"));
    CHECK(mentions(validate(sphere(1'000'000_r)), "sphere radius is 128 m"));
    CHECK(mentions(validate(capsule(1_r, -0.5_r)), "capsule half_extent.y is -0.5 m"));
    CHECK(mentions(validate(capsule(60_r, 60_r)), "capsule half_extent.y + radius is 120 m"));
    CHECK(mentions(validate(box(1_r, 0_r, 1_r)), "box half_extent.y is 0 m"));
    CHECK(mentions(validate(box(1_r, 1_r, 101_r)), "box half_extent.z"));
    Geometry odd = sphere(1_r);
    odd.kind = static_cast<ShapeKind>(17);
    CHECK(mentions(validate(odd), "shape kind is 17, it must be in 0 .. 9"));
}

TEST_CASE("validate() accepts cylinders and cones and rounded shapes within their ranges and reports why "
          "others fail") {
    for (const Geometry& g :
         {cylinder(0.0025_r, 100_r), cone(100_r, 0.0025_r), rounded(cylinder(1_r, 1_r), 99_r),
          rounded(cone(1_r, 2_r), 0.5_r), rounded(box(1_r, 2_r, 3_r), 97_r)})
        CHECK(validate(g) == "");
    CHECK(mentions(validate(cylinder(0.001_r, 1_r)), "cylinder half_extent.x is 0.001 m"));
    CHECK(mentions(validate(cone(1_r, 101_r)), "cone half_extent.y is 101 m"));
    CHECK(mentions(validate(rounded(box(1_r, 2_r, 3_r), -0.5_r)), "box radius is -0.5 m"));
    CHECK(mentions(validate(rounded(cone(1_r, 2_r), 99_r)), "cone half_extent + radius is 101 m"));
    Geometry oval = cylinder(1_r, 1_r);
    oval.half_extent.z = Length(2);
    CHECK(validate(oval) == "cylinder half_extent.x is 1 m and half_extent.z is 2 m, they must be equal");
}

TEST_CASE("validate() accepts scales and assets only for the kinds that may have them") {
    for (const Real factor : {1_r, 2_r, 4_r, 8_r})
        CHECK(validate(test::with_scale(box(1_r, 1_r, 1_r), factor)) == "");
    for (const Real factor : {0_r, 3_r, 16_r, 0.5_r})
        CHECK(
            mentions(validate(test::with_scale(sphere(1_r), factor)), "it must be 1, 2, 4 or 8 on all axes"));
    Geometry uneven = box(1_r, 1_r, 1_r);
    uneven.scale.y = Length(2);
    CHECK(validate(uneven) == "box scale is (1, 2, 1), it must be 1, 2, 4 or 8 on all axes");
    CHECK(mentions(validate(scaled(plane(), 2_r)), "it must be (1, 1, 1)"));
    const AssetId id{5};
    for (ShapeKind kind : {ShapeKind::hull, ShapeKind::compound, ShapeKind::height_field, ShapeKind::mesh}) {
        CHECK(validate(instance(kind, id)) == "");
        CHECK(mentions(validate(instance(kind, {})), " names no asset"));
        CHECK((validate(scaled(instance(kind, id), 100_r)) == "") == (kind != ShapeKind::compound));
        CHECK(mentions(validate(scaled(instance(kind, id), 101_r)), " scale"));
        CHECK((validate(rounded(instance(kind, id), 0.5_r)) == "") == (kind == ShapeKind::hull));
    }
    Geometry odd = sphere(1_r);
    odd.asset = id;
    CHECK(validate(odd) == "sphere names an asset, it can have none");
    CHECK(std::string(name_of(ShapeKind::height_field)) == "height_field");
    CHECK(std::string(name_of(static_cast<ShapeKind>(10))) == "unknown");
}

TEST_CASE("a scale of 2 or 4 or 8 multiplies the mass by its cube and the gyration by its square") {
    for (const Geometry& g : {sphere(1_r), capsule(0.5_r, 1_r), cylinder(1_r, 0.5_r), cone(1_r, 2_r),
                              rounded(box(1_r, 2_r, 3_r), 0.5_r)})
        for (const int factor : {2, 4, 8}) {
            const MassProperties one = mass_properties(g, 1_r),
                                 large = mass_properties(test::with_scale(g, Real(factor)), 1_r);
            CHECK(large.mass == one.mass * (factor * factor * factor));
            CHECK(large.center == one.center * Real(factor));
            CHECK(large.gyration_squared.x.x == one.gyration_squared.x.x * (factor * factor));
            CHECK(large.mass != one.mass * (factor * factor)); // planted
        }
}
