// Shapes at rest on a floor: the number and places of their contact points, and features that stay the same under small
// motions.
#include "lockstone/math/math.h"
#include "oracle/double_shapes.h"

#include <doctest/doctest.h>

#include <set>

using namespace lockstone;
using namespace lockstone::collide;
using oracle::as_double;
using oracle::D3;

namespace {

const Length margin = decimal<Length>("0.02");
constexpr double quarter = 1.5707963267948966;

/// An octagonal prism of radius 0.5 m, half height 0.3 m, about y.
shapes::Solid prism(AssetLibrary& library) {
    std::vector<LengthVec3> points;
    for (int k = 0; k < 16; ++k) {
        const double angle = quarter / 2 * (k / 2 + 0.5);
        points.push_back({oracle::as_fixed<Length>(0.5 * std::cos(angle)),
                          oracle::as_fixed<Length>(k % 2 ? 0.3 : -0.3),
                          oracle::as_fixed<Length>(0.5 * std::sin(angle))});
    }
    const AssetId id = library.add(bake_hull(points)).value();
    return {library.geometry(id).value(), library.find(id)->hull.get()};
}

Manifold manifold_of(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose) {
    NarrowScratch scratch;
    Manifolds all;
    collide::collide(a, b, pose, margin, scratch, all);
    return all.count == 0 ? Manifold{} : all.items[0];
}

std::set<std::uint32_t> features(const Manifold& m) {
    std::set<std::uint32_t> out;
    for (std::uint32_t k = 0; k < m.count; ++k) out.insert(m.points[k].feature);
    return out;
}

/// Returns whether the points surround the foot of the centre at this distance, so that they hold the shape up.
bool holds(const Manifold& m, double reach) {
    for (int k = 0; k < 16; ++k) { // in each direction some point is beyond the centre
        const double angle = k * quarter / 4;
        double most = -1;
        for (std::uint32_t i = 0; i < m.count; ++i)
            most = std::max(most, std::cos(angle) * as_double(m.points[i].position.x) +
                                      std::sin(angle) * as_double(m.points[i].position.z));
        if (most < reach) return false;
    }
    return true;
}

/// A shape on a floor, rotated by `turn`, with its origin `height` above the floor and this number of contact points.
struct Rest {
    const char* what;
    shapes::Solid solid;
    Quat turn;
    double height;
    std::uint32_t points;
    double hold; ///< how far the points reach beyond the centre in every direction; 0 for a line or a point
};

std::vector<Rest> all_rests(AssetLibrary& library) {
    const Quat lying = oracle::quat_of({0, 0, 1}, quarter), upright = Quat::identity();
    const Geometry can = cylinder(0.4_r, 0.25_r), hat = cone(0.4_r, 0.25_r);
    // A cone on its side: the normal of its side, (2 h, r) / |.|, points down; the middle of its axis is r h / |.|
    // above it.
    const double slant = std::hypot(0.5, 0.4), lean_angle = std::atan2(0.4, 0.5);
    return {{"a cylinder on its cap", {can}, upright, 0.25, 4, 0.2},
            {"a cylinder on its side", {can}, lying, 0.4, 2, 0},
            {"a cone on its base", {hat}, upright, 0.25, 4, 0.2},
            {"a cone on its side",
             {hat},
             oracle::quat_of({0, 0, 1}, -quarter - lean_angle),
             0.4 * 0.25 / slant,
             2,
             0},
            {"a hull on a face", prism(library), upright, 0.3, 4, 0.2},
            {"a hull on its side", prism(library), oracle::quat_of({1, 0, 0}, quarter),
             0.5 * std::cos(quarter / 4), 4, 0.1},
            {"a box", {box(0.5_r, 0.4_r, 0.3_r)}, upright, 0.4, 4, 0.2},
            {"a rounded box", {rounded(box(0.3_r, 0.2_r, 0.3_r), 0.1_r)}, upright, 0.3, 4, 0.2},
            {"a rounded cylinder on its cap", {rounded(can, 0.05_r)}, upright, 0.3, 4, 0.2},
            {"a rounded cylinder on its side", {rounded(can, 0.05_r)}, lying, 0.45, 2, 0},
            {"a capsule", {capsule(0.2_r, 0.5_r)}, lying, 0.2, 2, 0},
            {"a sphere", {sphere(0.2_r)}, upright, 0.2, 1, 0}};
}

} // namespace

TEST_CASE("shapes at rest have as many contact points as they need and the points surround the centre") {
    AssetLibrary library;
    oracle::RandomReal random(31);
    const shapes::Solid floors[] = {{box(4_r, 0.5_r, 4_r)}, {plane()}};
    const double tops[] = {0.5, 0};
    for (const Rest& rest : all_rests(library))
        for (int f = 0; f < 2; ++f)
            for (const double gap : {-0.002, -1e-5, 1e-7, 0.01}) {
                INFO(std::string(rest.what), " on floor ", f, ", gap ", gap);
                const Quat yaw = oracle::quat_of({0, 1, 0}, random.uniform(0, 6));
                const RelativePose pose =
                    oracle::pose_of(normalized(yaw * rest.turn), {0, tops[f] + rest.height + gap, 0});
                // The floor is A, so a solid of a greater kind than the floor's is skipped.
                if (floors[f].geometry.kind < rest.solid.geometry.kind) continue;
                const Manifold m = manifold_of(floors[f], rest.solid, pose);
                CHECK(m.count == rest.points);
                CHECK(features(m).size() == m.count);
                CHECK(as_double(m.normal.y) > 1 - 1e-8);
                for (std::uint32_t k = 0; k < m.count; ++k) {
                    CHECK(std::abs(as_double(m.points[k].separation) - gap) < 2e-7);
                    CHECK(std::abs(as_double(m.points[k].position.y) - (-rest.height - gap / 2)) < 2e-7);
                }
                if (rest.hold > 0) CHECK(holds(m, rest.hold));
                Manifold wrong = m; // planted: a lost point
                if (rest.hold > 0) {
                    wrong.count = 2;
                    CHECK(!holds(wrong, rest.hold));
                }
            }
}

TEST_CASE("the feature keys of shapes at rest stay the same under small motions") {
    AssetLibrary library;
    oracle::RandomReal random(37);
    const shapes::Solid floors[] = {{box(4_r, 0.5_r, 4_r)}, {box(0.45_r, 0.5_r, 0.45_r)}};
    int scenes = 0, changed = 0;
    for (const Rest& rest : all_rests(library))
        for (int i = 0; i < 60; ++i) {
            const shapes::Solid& floor = floors[i % 2];
            if (floor.geometry.kind < rest.solid.geometry.kind) continue;
            const double yaw = random.uniform(0, 6);
            const auto pose = [&](double jitter) {
                const Quat turned = oracle::quat_of({0, 1, 0}, yaw + random.uniform(-jitter, jitter));
                const Quat tilted = random.rotation(-jitter, jitter);
                const double x = random.uniform(-jitter, jitter), y = random.uniform(-jitter, jitter);
                return oracle::pose_of(normalized(tilted * turned * rest.turn),
                                       {0.1 + x, 0.5 + rest.height - 0.0005 + y, 0.05});
            };
            const Manifold first = manifold_of(floor, rest.solid, pose(0));
            for (int k = 0; k < 10; ++k) {
                const Manifold again = manifold_of(floor, rest.solid, pose(2e-6));
                ++scenes;
                changed += features(again) != features(first) ? 1 : 0;
            }
            Manifold wrong = first; // planted: a feature that depends on the order
            wrong.points[0].feature ^= 1;
            CHECK(features(wrong) != features(first));
        }
    CHECK(scenes > 1000);
    CHECK(changed * 50 < scenes);
}

TEST_CASE("a cylinder rolls on a circle and not on a polygon") {
    const shapes::Solid floors[] = {{box(4_r, 0.5_r, 4_r)}, {plane()}};
    const double tops[] = {0.5, 0};
    for (int f = 0; f < 2; ++f)
        for (int step = 0; step < 500; ++step) {
            const Quat roll = oracle::quat_of({0, 1, 0}, step * 0.0131),
                       lying = oracle::quat_of({0, 0, 1}, quarter);
            const Manifold wheel =
                manifold_of(floors[f], {cylinder(0.4_r, 0.25_r)},
                            oracle::pose_of(normalized(lying * roll), {0, tops[f] + 0.3995, 0}));
            REQUIRE(wheel.count == 2);
            for (std::uint32_t k = 0; k < 2; ++k) {
                CHECK(std::abs(as_double(wheel.points[k].separation) + 0.0005) < 1e-7);
                CHECK(std::abs(as_double(wheel.points[k].position.z)) < 2e-7);
            }
            // A coin on its rim, tilted by 0.4 rad: its lowest point is r sin + h cos below its middle.
            const double lean = 0.4, low = 0.4 * std::sin(lean) + 0.02 * std::cos(lean);
            const Manifold coin =
                manifold_of(floors[f], {cylinder(0.4_r, 0.02_r)},
                            oracle::pose_of(normalized(oracle::quat_of({0, 0, 1}, lean) * roll),
                                            {0, tops[f] + low - 0.0005, 0}));
            REQUIRE(coin.count > 0);
            double deepest = 1;
            for (std::uint32_t k = 0; k < coin.count; ++k)
                deepest = std::min(deepest, as_double(coin.points[k].separation));
            CHECK(std::abs(deepest + 0.0005) < 1e-7);
        }
}

TEST_CASE("two cylinders side by side touch along a line whose normal is exact") {
    oracle::RandomReal random(41);
    for (int i = 0; i < 300; ++i) {
        const double angle = random.uniform(0, 6.28), gap = random.uniform(-0.002, 0.01),
                     along = random.uniform(-0.3, 0.3);
        const D3 n{std::cos(angle), 0, std::sin(angle)};
        const Quat roll = oracle::quat_of({0, 1, 0}, random.uniform(0, 6));
        const Manifold m = manifold_of({cylinder(0.3_r, 0.5_r)}, {cylinder(0.2_r, 0.4_r)},
                                       oracle::pose_of(roll, n * (0.5 + gap) + D3{0, along, 0}));
        REQUIRE(m.count == 2);
        CHECK(norm(as_double(m.normal) - n) < 4e-7);
        for (std::uint32_t k = 0; k < 2; ++k) CHECK(std::abs(as_double(m.points[k].separation) - gap) < 2e-7);
    }
}
