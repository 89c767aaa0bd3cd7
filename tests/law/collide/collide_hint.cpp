// A hint of a separating direction makes the search faster and never changes its result.
#include "collide/convex/convex.h"
#include "lockstone/math/math.h"
#include "oracle/double_shapes.h"
#include "solve/kernels/kernels.h"
#include "support/rigs/scale_field.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <vector>

using namespace lockstone;
using namespace lockstone::collide;
using oracle::as_fixed;
using oracle::D3;

namespace {

shapes::Solid ball_hull(AssetLibrary& library, oracle::RandomReal& random, double size) {
    std::vector<LengthVec3> points;
    for (int i = 0; i < 30; ++i) {
        const D3 d = random.direction();
        points.push_back(
            {as_fixed<Length>(size * d.x), as_fixed<Length>(size * d.y), as_fixed<Length>(size * d.z)});
    }
    const AssetId id = library.add(bake_hull(points)).value();
    return {library.geometry(id).value(), library.find(id)->hull.get()};
}

bool same(const Manifolds& a, const Manifolds& b) {
    return a.count == b.count && std::memcmp(a.items, b.items, a.count * sizeof(Manifold)) == 0;
}

} // namespace

TEST_CASE("the manifolds are the same with any hint and without one") {
    AssetLibrary library;
    oracle::RandomReal random(11);
    const shapes::Solid all[] = {ball_hull(library, random, 0.5),
                                 ball_hull(library, random, 0.1),
                                 {cylinder(0.3_r, 0.4_r)},
                                 {cone(0.3_r, 0.4_r)},
                                 {rounded(box(0.3_r, 0.2_r, 0.4_r), 0.05_r)},
                                 {capsule(0.2_r, 0.3_r)}};
    const Length margin = decimal<Length>("0.02");
    NarrowScratch scratch;
    Manifolds plain, hinted, again;
    int apart = 0, near = 0, parted = 0;
    for (int i = 0; i < 20000; ++i) {
        const shapes::Solid &a = all[random.below(6)], &b = all[random.below(6)];
        if (a.geometry.kind < b.geometry.kind) continue;
        const D3 way = random.direction(), guess = random.direction();
        const double distance = random.uniform(0.05, 1.1);
        const RelativePose pose{to_rotation(random.rotation(0, 3)),
                                {as_fixed<Coordinate>(way.x * distance),
                                 as_fixed<Coordinate>(way.y * distance),
                                 as_fixed<Coordinate>(way.z * distance)}};
        collide::collide(a, b, pose, margin, scratch, plain);
        const UnitVec3 hint{as_fixed<Unit>(guess.x), as_fixed<Unit>(guess.y), as_fixed<Unit>(guess.z)};
        collide::collide(a, b, pose, margin, {hint, {}, 0}, scratch, hinted);
        REQUIRE(same(plain, hinted));
        if (plain.count != 0) {
            ++near;
            continue;
        }
        ++apart;
        collide::collide(a, b, pose, margin, {plain.apart, {}, 0}, scratch, again);
        REQUIRE(same(plain, again));
        // A direction that separated them is accepted at once.
        if (plain.apart == UnitVec3{}) continue;
        CHECK(again.apart != UnitVec3{});
        ++parted;
    }
    CHECK(parted > 1000);
    CHECK(apart > 2000);
    CHECK(near > 2000);
}

namespace {

/// Pairs of spheres, capsules, boxes and hulls of 4 cm to 10 m, with the direction that separated them before they
/// moved by up to 4 cm and turned by up to a hundredth.
struct PartedPairs {
    oracle::RandomReal random{13};
    AssetLibrary library;
    std::vector<shapes::Solid> stones;
    NarrowScratch scratch;
    int parted = 0, touched = 0, wrong = 0;

    PartedPairs() {
        for (const double size : {0.05, 0.2, 0.5, 1.0, 4.0}) {
            stones.push_back(ball_hull(library, random, size));
            stones.push_back(stones.back());
            stones.back().kernel = solve::kernels_of(best_simd())->hulls;
        }
    }
    shapes::Solid shape() {
        if (random.below(3) == 0) return stones[random.below(static_cast<std::uint32_t>(stones.size()))];
        return {primitive()};
    }
    Geometry primitive() {
        const double size = std::pow(10.0, random.uniform(-1.4, 0.7));
        const auto length = [&] { return as_fixed<Real>(size * random.uniform(0.3, 1)); };
        switch (random.below(3)) {
        case 0:
            return sphere(length());
        case 1:
            return capsule(length(), length());
        default:
            return box(length(), length(), length());
        }
    }
    /// `margin`: the gap that the direction must show. `reach`: collide() returns points up to this gap.
    void look(Length margin, Length reach) {
        shapes::Solid a = shape(), b = shape();
        if (a.geometry.kind < b.geometry.kind) std::swap(a, b);
        const D3 d = random.direction();
        const double size = oracle::as_double(collide_reach(a)) + oracle::as_double(collide_reach(b)),
                     way = size * random.uniform(0.3, 1.1);
        Transform at_a{{1000_r, -7_r, 3_r}, random.rotation(0, 3)},
            at_b{at_a.position, random.rotation(0, 3)};
        at_b.position +=
            Vec3{as_fixed<Real>(way * d.x), as_fixed<Real>(way * d.y), as_fixed<Real>(way * d.z)};
        Manifolds before, after;
        collide::collide(a, b, relative_pose(at_a, at_b), reach, scratch, before);
        if (before.count != 0 || before.apart == UnitVec3{}) return;
        const D3 step = random.direction();
        const double moved = random.uniform(0, 0.04);
        at_b.position +=
            {as_fixed<Real>(moved * step.x), as_fixed<Real>(moved * step.y), as_fixed<Real>(moved * step.z)};
        at_b.rotation = integrate_rotation(at_b.rotation, Vec3{as_fixed<Real>(random.uniform(-0.01, 0.01)),
                                                               {},
                                                               as_fixed<Real>(random.uniform(-0.01, 0.01))});
        const Rotation axes_a = to_rotation(at_a.rotation), axes_b = to_rotation(at_b.rotation);
        const bool is_parted =
            are_parted({a, axes_a, at_a.position}, {b, axes_b, at_b.position}, before.apart, margin);
        collide::collide(a, b, relative_pose(at_a, at_b), reach, scratch, after);
        ++(is_parted ? parted : touched);
        wrong += is_parted && after.count != 0;
    }
    static Real collide_reach(const shapes::Solid& s) {
        if (s.hull != nullptr) return to<Real>(shapes::reach_of(s));
        return to<Real>(s.geometry.radius) + length(to<Real>(s.geometry.half_extent));
    }
};

} // namespace

TEST_CASE("two shapes that a cached direction separates have no contact points") {
    PartedPairs pairs;
    for (int i = 0; i < 60000; ++i) pairs.look(decimal<Length>("0.02"), decimal<Length>("0.02"));
    MESSAGE(pairs.parted, " pairs parted, ", pairs.touched, " not");
    CHECK(pairs.parted > 20000);
    CHECK(pairs.touched > 500);
    CHECK(pairs.wrong == 0);
}

TEST_CASE("planted fault: the check reports a separation test with a margin that is 4 mm too small") {
    PartedPairs pairs;
    for (int i = 0; i < 60000; ++i)
        pairs.look(decimal<Length>("0.016"), decimal<Length>("0.02")); // planted: 4 mm short
    CHECK(pairs.wrong > 0);
}

TEST_CASE("are_parted() returns false for shapes within the margin for margins up to the longest Length") {
    const Rotation axes = Rotation::identity();
    const shapes::Solid ball{sphere(0.1_r)};
    const auto parts = [&](Real way, Length margin) {
        return are_parted({ball, axes, {}}, {ball, axes, {Real{}, way, Real{}}},
                          UnitVec3{Unit{}, unit_one, Unit{}}, margin);
    };
    CHECK_FALSE(parts(64_r, Length::max()));
    CHECK_FALSE(parts(64_r, Length::max() - decimal<Length>("0.001")));
    CHECK_FALSE(parts(64_r, Length(64)));
    CHECK(parts(64_r, Length(63)));
}

TEST_CASE("are_parted() returns false without a direction that is known to separate the shapes") {
    AssetLibrary library;
    oracle::RandomReal random(14);
    const shapes::Solid stone = ball_hull(library, random, 0.1), ball{sphere(0.1_r)},
                        post{cylinder(0.1_r, 0.1_r)}, spike{cone(0.1_r, 0.1_r)},
                        large{test::with_scale(box(1_r, 1_r, 1_r), 2_r)};
    const Rotation axes = Rotation::identity();
    const UnitVec3 up{Unit{}, unit_one, Unit{}};
    const auto parts = [&](const shapes::Solid& a, const shapes::Solid& b, Real height, UnitVec3 axis) {
        return are_parted({a, axes, {}}, {b, axes, {Real{}, height, Real{}}}, axis, Length{});
    };
    CHECK(parts(ball, ball, 1_r, up));
    CHECK(parts(ball, ball, 64_r, up));
    CHECK_FALSE(parts(ball, ball, 1_r, UnitVec3{}));
    CHECK_FALSE(parts(ball, ball, 1_r, -up));
    CHECK_FALSE(parts(ball, ball, 65_r, up)); // beyond the range of the numbers
    CHECK(parts(stone, ball, 1_r, up));
    CHECK(parts(ball, stone, 1_r, up));
    CHECK_FALSE(parts(stone, ball, 0.19_r, up));
    CHECK(parts(post, ball, 1_r, up));
    CHECK(parts(post, ball, 0.202_r, up));
    CHECK_FALSE(parts(post, ball, 0.2_r, up));
    CHECK_FALSE(parts(spike, ball, 1_r, up));
    CHECK_FALSE(parts(large, ball, 9_r, up));
}

TEST_CASE("a hint does not separate a ball from the box of 1240 m that contains it") {
    // The box reaches 1074 m along its diagonal. With 54 fraction bits 1024 m wrap around 64 bits, so the box would
    // seem to reach 50 m.
    const shapes::Solid ball{sphere(1_r)}, cliff{test::with_scale(box(77.5_r, 77.5_r, 77.5_r), 8_r)};
    const Unit third = decimal<Unit>("0.577350269");
    const auto points_at = [&](double metres) {
        const Coordinate along = as_fixed<Coordinate>(metres * 0.577350269);
        NarrowScratch scratch;
        Manifolds out;
        collide::collide(cliff, ball, {Rotation::identity(), {along, along, along}}, decimal<Length>("0.02"),
                         {{third, third, third}, {}, 0}, scratch, out);
        return out.count;
    };
    for (const double metres : {40.0, 60.0, 100.0, 200.0, 1000.0, 1074.0}) CHECK(points_at(metres) == 1);
    for (const double metres : {1077.0, 1500.0}) CHECK(points_at(metres) == 0);
}

TEST_CASE("planted fault: a hint whose sign is ignored separates shapes that touch") {
    AssetLibrary library;
    oracle::RandomReal random(12);
    const shapes::Solid stone = ball_hull(library, random, 0.5);
    const RelativePose touching{Rotation::identity(),
                                {as_fixed<Coordinate>(0.8), Coordinate{}, Coordinate{}}};
    const Convex a = convex_of(stone, Rotation::identity(), CoordinateVec3{}),
                 b = convex_of(stone, touching.rotation, touching.position);
    int wrong = 0;
    for (int i = 0; i < 100; ++i) {
        const D3 d = random.direction();
        // Planted: a hint whose sign is ignored.
        const std::int64_t along = separation_along_30(
            a, b, {as_fixed<Unit>(d.x).raw, as_fixed<Unit>(d.y).raw, as_fixed<Unit>(d.z).raw});
        wrong += (along < 0 ? -along : along) > std::int64_t{1} << 28;
    }
    CHECK(wrong > 0);
}
