// Shapes of every kind at rest, rolling and stacked.
#include "support/sim_shapes.h"
#include "support/about.h"

#include <doctest/doctest.h>

#include <string>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// The motion of a body laid on a floor, over five seconds: sideways [m], in height [m], and its last spin [rad/s].
struct Stray {
    double way, height_change, spin;
};
Stray stray_of(const Geometry& geometry, const Transform& pose,
               const std::shared_ptr<const AssetLibrary>& library, const Geometry& floor = plane()) {
    World w = made(World::create(small_def(), {}, library));
    add(w, {.kind = BodyKind::static_, .pose = floor.kind == ShapeKind::box ? at(0, -0.5, 0) : at(0, 0, 0)},
        {.geometry = floor});
    const BodyId b = add(w, {.pose = pose}, {.geometry = geometry});
    const D3 start = position(w, b);
    for (int t = 0; t < 300; ++t) w.tick();
    const D3 way = position(w, b) - start;
    return {std::hypot(way[0], way[2]), way[1], length(spin(w, b))};
}

} // namespace

TEST_CASE("shapes on a flat side stay still on a plane and on a box") {
    const Zoo zoo = make_zoo();
    const std::tuple<const char*, Geometry, Transform> standing[] = {
        {"cylinder upright", cylinder(0.4_r, 0.5_r), at(0, 0.5, 0)},
        {"cylinder on its side", cylinder(0.4_r, 0.5_r), at(0, 0.4, 0, turned(axis_x, 90))},
        {"cone on its base", cone(0.5_r, 0.4_r), at(0, 0.4, 0)},
        {"rounded box", rounded(box(0.3_r, 0.2_r, 0.4_r), 0.1_r), at(0, 0.3, 0)},
        {"rounded cylinder", rounded(cylinder(0.3_r, 0.2_r), 0.1_r), at(0, 0.3, 0)},
        {"hull on a face", instance(ShapeKind::hull, zoo.hull), at(0, 0.5, 0)},
        {"scaled hull",
         instance(ShapeKind::hull, zoo.hull, {to<Length>(2_r), to<Length>(1_r), to<Length>(1_r)}),
         at(0, 0.5, 0)},
        {"capsule lying", capsule(0.3_r, 0.5_r), at(0, 0.3, 0, turned(axis_x, 90))}};
    for (const Geometry& floor : {plane(), box(20_r, 0.5_r, 20_r)})
        for (const auto& [name, geometry, pose] : standing) {
            const std::string which = name; // clang 14: a lambda cannot capture a structured binding
            CAPTURE(which);
            const Stray stray = stray_of(geometry, pose, zoo.library, floor);
            CHECK(stray.way < 0.002);
            CHECK(std::abs(stray.height_change) < 0.003);
            CHECK(stray.spin < 0.002);
        }
}

TEST_CASE("a cylinder rolls smoothly down a slope at 2/3 of g sin(angle)") {
    World w = made(World::create(small_def()));
    add(w, {.kind = BodyKind::static_, .pose = at(0, 0, 0, turned(axis_z, -10))},
        {.geometry = box(60_r, 0.5_r, 5_r)});
    const double angle = 10 * 3.14159265358979 / 180, radius = 0.5;
    const double up = 0.5 + radius;
    const BodyId b = add(w, {.pose = at(up * std::sin(angle), up * std::cos(angle), 0, turned(axis_x, 90))},
                         {.geometry = cylinder(real(radius), 0.6_r)});
    double fastest_change = 0, before = 0;
    for (int t = 0; t < 120; ++t) {
        w.tick();
        const double speed = length(velocity(w, b));
        if (t > 10) fastest_change = std::max(fastest_change, std::abs(speed - before));
        before = speed;
    }
    const double acceleration = 2.0 / 3 * 9.81 * std::sin(angle);
    CHECK(length(velocity(w, b)) == test::about(acceleration * 2, 0.01));
    CHECK(fastest_change < 2 * acceleration / 60); // no bumps
    CHECK(std::abs(position(w, b)[2]) < 0.005);    // straight
}

TEST_CASE("towers of cylinders and of hulls and of rounded boxes stay up") {
    const Zoo zoo = make_zoo();
    const Geometry flat_hull = instance(ShapeKind::hull, zoo.hull);
    for (const auto& [name, geometry, half] :
         {std::tuple("cylinders", cylinder(0.5_r, 0.25_r), 0.25),
          {"hulls", flat_hull, 0.5},
          {"rounded boxes", rounded(box(0.4_r, 0.2_r, 0.4_r), 0.05_r), 0.25}}) {
        const std::string which = name;
        CAPTURE(which);
        World w = made(World::create(small_def(), {}, zoo.library));
        add_floor(w);
        std::vector<BodyId> tower;
        for (int i = 0; i < 6; ++i)
            tower.push_back(add(w, {.pose = at(0, half * (2 * i + 1), 0)}, {.geometry = geometry}));
        const Rest rest = rest_after(w, tower, 600);
        CHECK(rest.drift < 0.01);
        CHECK(rest.penetration < 0.005);
    }
}

TEST_CASE("bodies of every shape come to rest on waves and on a step and on a plane and none falls through") {
    const Zoo zoo = make_zoo();
    World w = zoo_world(zoo, 2);
    for (int t = 0; t < 2700; ++t) w.tick(); // the ball rolls to and fro in the waves for most of that time
    for (BodyId b : w.bodies())
        if (w.kind(b) == BodyKind::dynamic) CHECK(position(w, b)[1] > -1.05);
    CHECK(to_double(w.kinetic_energy()) < 1);
    CHECK(w.faults() == Faults{});
}

TEST_CASE("shapes rest on a static box and cylinder of a kilometre far from its middle") {
    const Zoo zoo = make_zoo();
    const std::pair<Geometry, double> grounds[] = {{scaled(box(62.5_r, 1_r, 62.5_r), 8_r), 8},
                                                   {scaled(cylinder(62.5_r, 1_r), 8_r), 8}};
    for (const auto& [ground, top] : grounds)
        for (const Geometry& geometry : {box(0.5_r, 0.5_r, 0.5_r), cylinder(0.5_r, 0.5_r), cone(0.5_r, 0.5_r),
                                         instance(ShapeKind::hull, zoo.hull)}) {
            const std::string below = name_of(ground.kind);
            CAPTURE(below);
            INFO(std::string(name_of(geometry.kind)));
            World w = made(World::create(small_def(), {}, zoo.library));
            add(w, {.kind = BodyKind::static_, .pose = at(0, -top, 0)}, {.geometry = ground});
            const BodyId b = add(w, {.pose = at(300, 0.5, -250)}, {.geometry = geometry});
            const Rest rest = rest_after(w, {b}, 240);
            CHECK(rest.drift < 0.005);
            CHECK(position(w, b)[1] == test::about(geometry.kind == ShapeKind::cone ? 0.25 : 0.5, 0.01));
        }
}
