// Characters on the ground: slopes, steps, walls, corners, tunnels, terrain.
#include "support/about.h"
#include "support/character_course.h"
#include "support/sim_shapes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::character;

namespace {

constexpr double skin = 0.004; ///< [m], as in play/character/character_space.h

/// Returns the height that a character reaches on a slope in two seconds at 4 m/s.
double climbed(double degrees, double slope_max_degrees) {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_ramp(w, degrees);
    CharacterDef def;
    def.slope_max = real(slope_max_degrees * 3.14159265358979323846 / 180);
    const CharacterId c = add_character(w, -1, 0.01, 0, def);
    drive(w, c, 4, 0);
    run(w, 120);
    return feet(w, c)[1];
}

/// Returns whether a character gets onto a block of this height.
bool steps_onto(double block, double step_height, double speed = 3) {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_wall(w, at(12, block / 2, 0), vec(10, block / 2, 3));
    CharacterDef def;
    def.step_height = real(step_height);
    const CharacterId c = add_character(w, 0, 0.01, 0, def);
    drive(w, c, speed, 0);
    run(w, static_cast<int>(3 / speed * 60) + 20);
    return feet(w, c)[1] > block;
}

/// The greatest distance from the character's place at the start, over some ticks.
double wander(World& w, CharacterId c, int ticks) {
    const D3 from = feet(w, c);
    double most = 0;
    for (int i = 0; i < ticks; ++i) {
        w.tick();
        most = std::max(most, length(feet(w, c) - from));
    }
    return most;
}

} // namespace

TEST_CASE("a character that stands does not move on flat ground or on a slope") {
    for (const double degrees : {0.0, 17.0, 40.0}) {
        World w = made(World::create(small_def()));
        add_floor(w);
        add_ramp(w, degrees);
        const CharacterId c = add_character(w, 3, 4, 0);
        run(w, 120);
        REQUIRE(stands(w, c));
        INFO("slope ", degrees);
        const Transform before = w.pose(w.body_of(c));
        run(w, 300);
        CHECK(w.pose(w.body_of(c)) == before);
        CHECK(overlap(w, c) == 0);
    }
}

TEST_CASE("a character climbs slopes up to slope_max and no steeper slopes") {
    for (const double limit : {30.0, 50.0, 65.0}) {
        INFO("slope_max ", limit);
        CHECK(climbed(limit - 1, limit) > 2);
        CHECK(climbed(limit + 1, limit) < 0.05);
    }
    CHECK(climbed(51, 52) > 2); // negative control: with a higher limit it climbs
}

TEST_CASE("a character keeps its horizontal speed up and down a slope") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_ramp(w, 30);
    const CharacterId c = add_character(w, 2, 3, 0);
    run(w, 60);
    for (const double speed : {3.0, -3.0}) {
        drive(w, c, speed, 0);
        run(w, 10);
        const double from = feet(w, c)[0], height = feet(w, c)[1];
        run(w, 60);
        CHECK(feet(w, c)[0] - from == test::about(speed, 0.001));
        CHECK(feet(w, c)[1] - height == test::about(speed * std::tan(3.14159265358979 / 6), 0.002));
        CHECK(stands(w, c));
    }
}

TEST_CASE("a character walks onto blocks up to step_height and onto no higher blocks") {
    for (const double height : {0.2, 0.35, 0.5}) {
        INFO("step_height ", height);
        CHECK(steps_onto(height - 0.01, height));
        CHECK_FALSE(steps_onto(height + 0.02, height));
    }
    CHECK(steps_onto(0.3, 0.35, 0.5)); // slowly too
    CHECK(steps_onto(0.3, 0.35, 10));
    CHECK_FALSE(steps_onto(0.3, 0)); // negative control: without a step height the block is a wall
}

TEST_CASE("a character walks up and down stairs at the same horizontal speed") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_stairs(w, 10, 0.2, 0.3);
    const CharacterId c = add_character(w, 0, 0.01, 0);
    drive(w, c, 2, 0);
    run(w, 20);
    for (const double speed : {2.0, -2.0}) {
        drive(w, c, speed, 0);
        run(w, 10);
        double before = feet(w, c)[0], slowest = 1e9, fastest = 0;
        for (int i = 0; i < 100; ++i) {
            w.tick();
            const double x = feet(w, c)[0];
            slowest = std::min(slowest, (x - before) * 60 / speed),
            fastest = std::max(fastest, (x - before) * 60 / speed);
            before = x;
            CHECK(stands(w, c));
            CHECK(overlap(w, c) == 0);
        }
        INFO("speed ", speed);
        CHECK(slowest > 0.9);
        CHECK(fastest < 1.1);
        CHECK(feet(w, c)[1] > (speed > 0 ? 1.99 : -0.01));
        if (speed > 0) run(w, 20);
    }
}

TEST_CASE("a character walks down to ground within step_down and falls to deeper ground") {
    for (const double depth : {0.3, 0.6}) {
        World w = made(World::create(small_def()));
        add_floor(w);
        add_wall(w, at(-2, depth / 2, 0), vec(2, depth / 2, 2));
        const CharacterId c = add_character(w, -1, depth + 0.01, 0);
        drive(w, c, 3, 0);
        bool flew = false;
        run(w, 2);
        for (int i = 0; i < 60; ++i) {
            w.tick();
            flew |= !stands(w, c);
        }
        INFO("depth ", depth);
        CHECK(flew == (depth > 0.35));
        CHECK(feet(w, c)[1] == test::about(skin, 0.1));
    }
}

TEST_CASE("a character that walks along a wall loses only the part of its velocity into the wall") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_wall(w, at(0, 1, 1), vec(20, 1, 0.5));
    const CharacterId c = add_character(w, -5, 0.01, 0);
    drive(w, c, 3, 4);
    run(w, 30);
    const D3 from = feet(w, c);
    run(w, 60);
    const D3 way = feet(w, c) - from;
    CHECK(way[0] == test::about(3, 0.01));
    CHECK(std::abs(way[2]) < 1e-5);
    CHECK(feet(w, c)[2] == test::about(0.5 - 0.3 - skin, 0.001));
}

TEST_CASE("a character stays within a millimetre in a corner of any angle") {
    for (const double degrees : {30.0, 60.0, 90.0, 120.0}) {
        World w = made(World::create(small_def()));
        add_floor(w);
        // Two walls that meet at (3, 0), symmetrical about the x axis.
        for (const double side : {1.0, -1.0}) {
            const double a = degrees / 2 * 3.14159265358979323846 / 180;
            const double x = 3 - 4.7 * std::cos(a) + 0.5 * std::sin(a);
            const double z = side * (4.7 * std::sin(a) + 0.5 * std::cos(a));
            add_wall(w, at(x, 1, z, turned(axis_y, side * degrees / 2)), vec(5, 1, 0.5));
        }
        const CharacterId c = add_character(w, -2, 0.01, 0);
        drive(w, c, 3, 0.4);
        run(w, 240);
        INFO("corner of ", degrees);
        CHECK(wander(w, c, 600) < 0.001);
        CHECK(overlap(w, c) == 0);
        drive(w, c, -3, 0.4); // negative control: not pressed into the corner, it moves
        CHECK(wander(w, c, 30) > 0.5);
    }
}

TEST_CASE("a character stays crouched under a low ceiling and rises behind it") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_wall(w, at(4, 2.2, 0), vec(2, 1, 2)); // its underside at 1.2 m
    const CharacterId c = add_character(w, 0, 0.01, 0);
    drive(w, c, 3, 0);
    run(w, 60);
    CHECK(feet(w, c)[0] < 1.75); // too tall for the gap
    drive(w, c, 3, 0, false, true);
    run(w, 30);
    CHECK(feet(w, c)[0] > 2.2);
    drive(w, c, 0, 0);
    run(w, 60);
    CHECK(w.character_state(c).crouched == 1); // no room to stand
    CHECK(overlap(w, c) == 0);
    drive(w, c, 3, 0);
    for (int i = 0; i < 120; ++i) {
        w.tick();
        CHECK(overlap(w, c) == 0);
    }
    CHECK(w.character_state(c).crouched == 0);
    CHECK(feet(w, c)[0] > 6.3);
}

TEST_CASE("a character keeps its speed on terrain of triangles and never sinks in") {
    for (const bool is_mesh : {true, false}) {
        AssetLibrary library;
        AssetId id{};
        constexpr std::uint32_t side = 33;
        const auto height = [](double x, double z) { return 0.5 * std::sin(0.7 * x) * std::cos(0.6 * z); };
        if (is_mesh) {
            std::vector<Vec3> v;
            std::vector<std::array<std::uint32_t, 3>> t;
            for (std::uint32_t z = 0; z < side; ++z)
                for (std::uint32_t x = 0; x < side; ++x) v.push_back(vec(x, height(x, z), z));
            for (std::uint32_t z = 0; z + 1 < side; ++z)
                for (std::uint32_t x = 0; x + 1 < side; ++x) {
                    const std::uint32_t i = z * side + x;
                    t.push_back({i, i + side, i + side + 1});
                    t.push_back({i, i + side + 1, i + 1});
                }
            id = made(library.add(bake_mesh({.vertices = v, .triangles = t})));
        } else {
            std::vector<Length> h;
            for (std::uint32_t z = 0; z < side; ++z)
                for (std::uint32_t x = 0; x < side; ++x) h.push_back(to<Length>(real(height(x, z))));
            id = made(library.add(bake_height_field({side, side, to<Length>(1_r), h})));
        }
        World w =
            made(World::create(small_def(), {}, std::make_shared<const AssetLibrary>(std::move(library))));
        add(w, {.kind = BodyKind::static_},
            {.geometry = instance(is_mesh ? ShapeKind::mesh : ShapeKind::height_field, id)});
        const CharacterId c = add_character(w, 4, 2, 4);
        run(w, 60);
        drive(w, c, 2.4, 1.8);
        run(w, 10);
        const D3 from = feet(w, c);
        for (int i = 0; i < 360; ++i) {
            w.tick();
            INFO("mesh ", is_mesh, ", tick ", i);
            CHECK(stands(w, c));
            CHECK(overlap(w, c) == 0);
        }
        const D3 way = feet(w, c) - from;
        CHECK(way[0] == test::about(2.4 * 6, 0.005));
        CHECK(way[2] == test::about(1.8 * 6, 0.005));
    }
}

TEST_CASE("a character walks on a wall if its definition sets the up direction to the wall's normal") {
    World w = made(World::create(small_def()));
    add_wall(w, at(-0.5, 0, 0), vec(0.5, 10, 10)); // a wall at x = 0 is the ground
    CharacterDef def;
    def.up = axis_x;
    const CharacterId c = add_character(w, 0.5, 0, 0, def);
    done(w.set_character_input(c, {.velocity = vec(0, 2, 0)}));
    run(w, 90);
    CHECK(stands(w, c));
    CHECK(feet(w, c)[0] == test::about(skin, 0.1));
    CHECK(feet(w, c)[1] > 2.5);
}
