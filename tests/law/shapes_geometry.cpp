// Building shapes and refusing bad ones with a sentence that helps.
#include "lockstone/shape.h"

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

TEST_CASE("good shapes pass") {
    for (const Geometry& g : {sphere(0.0025_r), sphere(100_r), capsule(0.01_r, 0_r), capsule(50_r, 50_r),
                              box(100_r, 0.0025_r, 1_r), plane()})
        CHECK(validate(g) == "");
}

TEST_CASE("bad shapes are refused with the field, its value and its range") {
    CHECK(validate(sphere(0.001_r)) == "sphere radius is 0.001 m, it must be in 0.0025 m .. 100 m");
    CHECK(mentions(validate(sphere(-1_r)), "sphere radius is -1 m"));
    CHECK(mentions(validate(sphere(1'000'000_r)), "sphere radius is 128 m"));
    CHECK(mentions(validate(capsule(1_r, -0.5_r)), "capsule half_extent.y is -0.5 m"));
    CHECK(mentions(validate(capsule(60_r, 60_r)), "capsule half_extent.y + radius is 120 m"));
    CHECK(mentions(validate(box(1_r, 0_r, 1_r)), "box half_extent.y is 0 m"));
    CHECK(mentions(validate(box(1_r, 1_r, 101_r)), "box half_extent.z"));
    Geometry odd = sphere(1_r);
    odd.kind = static_cast<ShapeKind>(9);
    CHECK(mentions(validate(odd), "shape kind is 9"));
}
