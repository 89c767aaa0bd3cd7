// Bodies that should come to rest do so, where they were placed.
#include "support/about.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double g = 9.81;

World piles_world() {
    WorldDef def;
    def.bodies_max = def.shapes_max = 1024;
    def.sleeping = 0; // sleeping bodies report no contacts
    return made(World::create(def));
}

/// At rest: twenty steps of a speed [J/kg]. A single body keeps less than one step along and about each axis.
constexpr double at_rest = 400 * speed_step * speed_step / 2, alone_at_rest = 6 * speed_step * speed_step / 2;
/// A body without a sideways push stays in place: the bound of symmetry, as in contact_block.cpp [m].
constexpr double stays = 1e-5;

/// The sinking of a pyramid of equal boxes of 1 m under its own weight, where each box rests by halves on two below:
/// the depth of the deepest contact, and how far a centre moves aside because one support sinks more than the other and
/// tilts the box [m].
struct Settled {
    double deepest = 0, aside = 0;
};
Settled settled(std::size_t base, double give) {
    std::vector<std::vector<double>> load{{1}}; // by row from the top, in weights of a box
    for (std::size_t row = 1; row < base; ++row) {
        load.emplace_back(row + 1, 1.0);
        for (std::size_t i = 0; i < load[row - 1].size(); ++i)
            load[row][i] += load[row - 1][i] / 2, load[row][i + 1] += load[row - 1][i] / 2;
    }
    Settled out;
    std::vector<double> sunk, aside(load.back().size(), 0.0);
    for (const double weights : load.back()) sunk.push_back(weights * g * give / 4);
    for (std::size_t row = base - 1; row-- > 0;)
        for (std::size_t i = 0; i < load[row].size(); ++i) {
            const double contact =
                load[row][i] * g * give; // half of it on each of two contacts of half the mass
            const double tilt = (sunk[i] - sunk[i + 1]) / 1.02;
            sunk[i] = (sunk[i] + sunk[i + 1]) / 2 + contact;
            aside[i] = (aside[i] + aside[i + 1]) / 2 - tilt / 2;
            out.deepest = std::max(out.deepest, contact), out.aside = std::max(out.aside, std::abs(aside[i]));
        }
    return out;
}

Rest print(const char* what, const Rest& r) {
    std::printf("  %s: drift %.2f mm, penetration %.2f mm, kinetic energy %.3g J\n", what, r.drift * 1e3,
                r.penetration * 1e3, r.kinetic);
    return r;
}

bool long_run() { return std::getenv("LOCKSTONE_LONG") != nullptr; }

} // namespace

TEST_CASE("a stack of 10 boxes stays up for 1200 ticks") {
    World w = piles_world();
    add_floor(w);
    const Rest r = print("stack of 10", rest_after(w, add_stack(w, 10), 1200));
    CHECK(r.drift < stays);
    // Nine boxes on a contact of half the mass.
    CHECK(r.penetration == test::about(2 * 9 * g * give(w.def()), 0.02));
    CHECK(r.kinetic / 10'000 < at_rest);
}

TEST_CASE("planted fault: a stack of 11 boxes sinks in deeper than one of 10") {
    World w = piles_world();
    add_floor(w);
    CHECK(rest_after(w, add_stack(w, 11), 1200).penetration != test::about(2 * 9 * g * give(w.def()), 0.02));
}

TEST_CASE("pyramids of base 20 and 40 stay up for 1200 ticks") {
    for (const int base : {20, 40}) {
        if (base == 40 && !long_run()) continue;
        World w = piles_world();
        add_floor(w);
        const Rest r = print("pyramid", rest_after(w, add_pyramid(w, base), 1200));
        const Settled closed = settled(static_cast<std::size_t>(base), give(w.def()));
        INFO("base ", base, ": at most ", closed.aside * 1e3, " mm aside, ", closed.deepest * 1e3,
             " mm deep");
        CHECK(r.drift < closed.aside);
        CHECK(r.penetration < closed.deepest);
        // the larger pyramid still settles
        if (base == 20) CHECK(r.kinetic / (500.0 * base * (base + 1)) < at_rest);
    }
}

TEST_CASE("a single ball or capsule or box rests without jitter") {
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
        CHECK(per_mass < alone_at_rest);
        CHECK(length(to_double(w.pose(b).position) - to_double(before.position)) < 5 * speed_step * 2);
    }
}

TEST_CASE("a box that lands flat from 0.1 m to 20 m stays where it landed") {
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
                CHECK(r.drift < stays);
                // The box sinks by the compression of its weight, 8 micrometres, plus the rounding of a gap.
                CHECK(std::abs(position(w, b)[1] - (half[1] - g * give(w.def()) / 4)) < stays);
            }
}

TEST_CASE("a box that bounces flat does not tumble") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId b = add(w, {.pose = at(0, 4, 0)},
                         {.geometry = box(real(0.5), real(0.5), real(0.5)), .restitution = real(0.6)});
    const Rest r = print("bouncing box", rest_after(w, {b}, 600));
    CHECK(r.drift < stays); // it lands on all four corners at once, each time
    CHECK(r.kinetic / 1000 < alone_at_rest);
    CHECK(to_double(to_rotation(w.pose(b).rotation).y.y) > 1 - 1e-9);
    CHECK(std::abs(position(w, b)[1] - (0.5 - g * give(w.def()) / 4)) < stays);
}

TEST_CASE("a box that lands flat on another box stays on it") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId lower = add_crate(w, at(0, 0.5, 0)), upper = add_crate(w, at(0, 4, 0));
    const Rest r = print("box on box", rest_after(w, {lower, upper}, 600));
    CHECK(r.drift < stays);
    // One weight on half the mass, and both on the floor.
    CHECK(std::abs(position(w, upper)[1] - (1.5 - (2 + 2.0 / 4) * g * give(w.def()))) < stays);
}

TEST_CASE("a heavy ball rests on a light one without crushing it") {
    for (double ratio : {2.0, 4.0, 10.0, 100.0, 1000.0}) {
        World w = made(World::create(small_def()));
        add_floor(w);
        // A shaft keeps the ball from rolling off.
        for (double x : {-1.0, 1.0}) add_wall(w, at(x, 2, 0), vec(0.498, 3, 2));
        for (double z : {-1.0, 1.0}) add_wall(w, at(0, 2, z), vec(2, 3, 0.498));
        add(w, {.pose = at(0, 0.5, 0), .mass = Real(1)}, {.geometry = sphere(real(0.5))});
        const BodyId heavy =
            add(w, {.pose = at(0, 1.5, 0), .mass = real(ratio)}, {.geometry = sphere(real(0.5))});
        for (int t = 0; t < 600; ++t) w.tick();
        std::printf("  %.0f kg on 1 kg: sinks %.2f mm\n", ratio, 1e3 * (1.5 - position(w, heavy)[1]));
        // The light ball counts as a quarter of the heavy one: a ratio of 4 on a reduced mass of 4 / (1 + 4), and 1 + 4
        // of the light one's weights on the floor.
        const double counted = std::min(ratio, 4.0);
        CHECK(1.5 - position(w, heavy)[1] == test::about((1 + counted) * 1.25 * g * give(w.def()), 0.02));
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
    // Some balls may still creep: below 1.5 cm/s, a quarter of a millimetre per tick.
    CHECK(r.kinetic / (50 * to_double(w.mass(balls[0]))) < 0.015 * 0.015 / 2);
    const double deepest = 2 * 50 * g * give(w.def()); // if one contact carried all of them
    CHECK(r.penetration < deepest);
    for (BodyId b : balls) {
        CHECK(std::abs(position(w, b)[0]) < 1.5 - 0.35 + deepest);
        CHECK(std::abs(position(w, b)[2]) < 1.5 - 0.35 + deepest);
        CHECK(position(w, b)[1] > 0.35 - deepest);
    }
}
