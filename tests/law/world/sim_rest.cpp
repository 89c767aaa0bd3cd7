// Things that should come to rest do, where they were put.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

World piles_world() {
    WorldDef def;
    def.bodies_max = def.shapes_max = 1024;
    return made(World::create(def));
}

Rest print(const char* what, const Rest& r) {
    std::printf("  %s: drift %.2f mm, penetration %.2f mm, kinetic energy %.3g J\n", what, r.drift * 1e3,
                r.penetration * 1e3, r.kinetic);
    return r;
}

bool long_run() { return std::getenv("LOCKSTONE_LONG") != nullptr; }

} // namespace

TEST_CASE("a stack of 10 boxes stands for 1,200 ticks") {
    World w = piles_world();
    add_floor(w);
    const Rest r = print("stack of 10", rest_after(w, add_stack(w, 10), 1200));
    CHECK(r.drift < 0.005);
    CHECK(r.penetration < 0.006);
    CHECK(r.kinetic < 1);
}

TEST_CASE("a pyramid of base 20 stands for 1,200 ticks") {
    World w = piles_world();
    add_floor(w);
    const Rest r = print("pyramid of base 20", rest_after(w, add_pyramid(w, 20), 1200));
    CHECK(r.drift < 0.008);
    CHECK(r.penetration < 0.006);
    CHECK(r.kinetic < 1);
}

TEST_CASE("a pyramid of base 40 stands for 1,200 ticks" * doctest::skip(!long_run())) {
    World w = piles_world();
    add_floor(w);
    const Rest r = print("pyramid of base 40", rest_after(w, add_pyramid(w, 40), 1200));
    CHECK(r.drift < 0.1);
    CHECK(r.penetration < 0.012);
}

TEST_CASE("a single ball, capsule and box rest without jitter") {
    const Geometry shapes[] = {sphere(real(0.5)), capsule(real(0.3), real(0.5)),
                               box(real(0.5), real(0.25), real(0.4))};
    for (const Geometry& shape : shapes) {
        World w = made(World::create(small_def()));
        add_floor(w);
        const Quat lying = shape.kind == ShapeKind::capsule ? turned(axis_z, 90) : Quat::identity();
        const BodyId b = add(w, {.pose = at(0, 0.6, 0, lying)}, {.geometry = shape});
        for (int t = 0; t < 300; ++t) w.tick();
        const double per_mass = to_double(w.kinetic_energy()) / to_double(w.mass(b));
        const Transform before = w.pose(b);
        for (int t = 0; t < 300; ++t) w.tick();
        std::printf("  kind %u at rest: %.2g J/kg, moves %.2g m in 300 ticks\n",
                    static_cast<unsigned>(shape.kind), per_mass,
                    length(to_double(w.pose(b).position) - to_double(before.position)));
        CHECK(per_mass < 1e-9);
        CHECK(length(to_double(w.pose(b).position) - to_double(before.position)) < 1e-4);
    }
}

TEST_CASE("a box that lands flat stays where it landed, from 0.1 m to 20 m") {
    const D3 halves[] = {{0.5, 0.5, 0.5}, {1, 0.1, 0.5}, {0.1, 1, 0.1}, {1, 0.1, 0.1}};
    for (const D3& half : halves)
        for (double height : {0.1, 1.0, 5.0, 20.0})
            for (double yaw : {0.0, 30.0}) {
                World w = made(World::create(small_def()));
                add_floor(w);
                const BodyId b = add(w, {.pose = at(0, half[1] + height, 0, turned(axis_y, yaw))},
                                     {.geometry = box(quantize<Real>(half))});
                const Rest r = rest_after(w, {b}, 240);
                INFO("half extents ", half[0], " ", half[1], " ", half[2], ", from ", height, " m, yaw ",
                     yaw);
                CHECK(r.drift < 0.005);
                CHECK(to_double(w.pose(b).position.y) == doctest::Approx(half[1]).epsilon(0.01));
            }
}

TEST_CASE("a box that bounces flat does not tumble") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId b = add(w, {.pose = at(0, 4, 0)},
                         {.geometry = box(real(0.5), real(0.5), real(0.5)), .restitution = real(0.6)});
    const Rest r = print("bouncing box", rest_after(w, {b}, 600));
    CHECK(r.drift < 0.5); // each bounce magnifies the tilt that the one before left
    CHECK(r.kinetic == 0);
    CHECK(to_double(to_rotation(w.pose(b).rotation).y.y) > 0.9999);
    CHECK(position(w, b)[1] == doctest::Approx(0.5).epsilon(0.01));
}

TEST_CASE("a box that lands flat on another stays on it") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId lower = add_crate(w, at(0, 0.5, 0)), upper = add_crate(w, at(0, 4, 0));
    const Rest r = print("box on box", rest_after(w, {lower, upper}, 600));
    CHECK(r.drift < 0.02);
    CHECK(position(w, upper)[1] == doctest::Approx(1.5).epsilon(0.01));
}

TEST_CASE("a heavy ball rests on a light one without crushing it") {
    for (double ratio : {10.0, 100.0}) {
        World w = made(World::create(small_def()));
        add_floor(w);
        // In a shaft, or it would roll off.
        for (double x : {-1.0, 1.0}) add_wall(w, at(x, 2, 0), vec(0.498, 3, 2));
        for (double z : {-1.0, 1.0}) add_wall(w, at(0, 2, z), vec(2, 3, 0.498));
        add(w, {.pose = at(0, 0.5, 0), .mass = Real(1)}, {.geometry = sphere(real(0.5))});
        const BodyId heavy =
            add(w, {.pose = at(0, 1.5, 0), .mass = real(ratio)}, {.geometry = sphere(real(0.5))});
        for (int t = 0; t < 600; ++t) w.tick();
        std::printf("  %.0f kg on 1 kg: sinks %.2f mm\n", ratio, 1e3 * (1.5 - position(w, heavy)[1]));
        CHECK(position(w, heavy)[1] > (ratio < 50 ? 1.49 : 1.4));
    }
}

TEST_CASE("balls in a box settle and stay inside") {
    World w = made(World::create(small_def()));
    add_floor(w);
    for (double x : {-2.0, 2.0}) add_wall(w, at(x, 2, 0), vec(0.5, 3, 3));
    for (double z : {-2.0, 2.0}) add_wall(w, at(0, 2, z), vec(3, 3, 0.5));
    std::vector<BodyId> balls;
    for (int i = 0; i < 50; ++i)
        balls.push_back(add_ball(w, at(i % 3 - 1 + 0.002 * i, 1 + 0.7 * (i / 3), (i / 3) % 3 - 1), 0.35));
    const Rest r = print("50 balls in a box", rest_after(w, balls, 900));
    CHECK(r.kinetic / (50 * to_double(w.mass(balls[0]))) < 1e-4);
    CHECK(r.penetration < 0.01);
    for (BodyId b : balls) {
        CHECK(std::abs(position(w, b)[0]) < 1.5);
        CHECK(std::abs(position(w, b)[2]) < 1.5);
        CHECK(position(w, b)[1] > 0.3);
    }
}
