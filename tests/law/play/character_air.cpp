// Characters in the air: jumps, falls, steep slopes, fast ones, one-way platforms.
#include "support/about.h"
#include "support/character_course.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::character;

namespace {

constexpr double skin = 0.004, tick_time = 1.0 / 60;

} // namespace

TEST_CASE("a jump has a height of v^2 / 2g and takes a time of 2v / g") {
    for (const double speed : {3.0, 5.0, 9.0})
        for (const double gravity : {9.81, 20.0}) {
            World w = made(World::create(small_def()));
            add_floor(w);
            CharacterDef def;
            def.jump_speed = real(speed), def.gravity = real(gravity);
            const CharacterId c = add_character(w, 0, 0.01, 0, def);
            run(w, 30);
            drive(w, c, 0, 0, true);
            double highest = 0;
            int ticks = 0;
            do {
                w.tick();
                highest = std::max(highest, feet(w, c)[1]);
                ++ticks;
            } while (!stands(w, c) && ticks < 600);
            INFO("speed ", speed, ", gravity ", gravity);
            CHECK(highest - skin == test::about(speed * speed / (2 * gravity), 0.005));
            CHECK(std::abs(ticks * tick_time - 2 * speed / gravity) <= 1.01 * tick_time);
        }
}

TEST_CASE("one press causes one jump even shortly before a landing or shortly after an edge") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_wall(w, at(-2, 0.5, 0), vec(2, 0.5, 2)); // its edge at x = 0
    const CharacterId c = add_character(w, -1, 1.01, 0);
    run(w, 30);
    int jumps = 0;
    const auto count = [&](int ticks) {
        for (int i = 0; i < ticks; ++i) {
            const bool rose = w.character_state(c).velocity.y > 0_r;
            w.tick();
            jumps += !rose && w.character_state(c).velocity.y > 1_r;
        }
    };
    drive(w, c, 0, 0, true); // held for two seconds
    count(120);
    CHECK(jumps == 1);
    drive(w, c, 0, 0, false);
    count(2);
    drive(w, c, 0, 0, true);
    count(50);
    drive(w, c, 0, 0, false);
    count(8);
    drive(w, c, 0, 0, true); // a few ticks before it lands: 2 v / g is 61
    count(30);
    CHECK(jumps == 3);
    drive(w, c, 0, 0, false);
    count(2);
    drive(w, c, 0, 0, true); // much too early
    count(90);
    CHECK(jumps == 3);
    drive(w, c, 3, 0, false);
    run(w, 60);
    for (const int late : {3, 20}) { // ticks after the edge
        done(w.set_pose(w.body_of(c), at(-1, 1.004, 0)));
        drive(w, c, 0, 0);
        run(w, 60);
        drive(w, c, 3, 0);
        while (stands(w, c)) w.tick();
        run(w, late);
        jumps = 0;
        drive(w, c, 3, 0, true);
        count(4);
        INFO("ticks late: ", late);
        CHECK(jumps == (late == 3 ? 1 : 0));
    }
}

TEST_CASE("a character on a slope that is too steep slides down and cannot climb and cannot jump") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_ramp(w, 60);
    const CharacterId c = add_character(w, 2, 6, 0);
    run(w, 30);
    double before = feet(w, c)[1];
    drive(w, c, 4, 0); // uphill
    run(w, 20);
    for (int i = 0; i < 30 && !stands(w, c); ++i) {
        w.tick();
        CHECK(feet(w, c)[1] <= before);
        before = feet(w, c)[1];
        CHECK(overlap(w, c) == 0);
    }
    run(w, 120);
    CHECK(feet(w, c)[1] == test::about(skin, 0.2));
    // Running and jumping at the slope does not help either.
    for (int i = 0; i < 10; ++i) {
        drive(w, c, 8, 0, i % 2 == 0);
        run(w, 30);
    }
    CHECK(feet(w, c)[1] < 1.5);
}

TEST_CASE("a character passes through no thin wall at up to 90 m/s and falls through no thin floor") {
    for (const double speed : {10.0, 50.0, 90.0}) {
        World w = made(World::create(small_def()));
        add_floor(w);
        add_wall(w, at(5, 5, 0), vec(0.005, 5, 40));
        CharacterDef def;
        def.acceleration = real(100000), def.air_acceleration = real(100000);
        const CharacterId c = add_character(w, 0, 0.01, 0, def);
        drive(w, c, speed, speed / 5);
        for (int i = 0; i < 60; ++i) {
            w.tick();
            INFO("speed ", speed, ", tick ", i);
            CHECK(feet(w, c)[0] < 5 - 0.3);
            CHECK(overlap(w, c) == 0);
        }
        CHECK(feet(w, c)[0] > 4.6);
    }
    // A fall onto a thin floor.
    World w = made(World::create(small_def()));
    add_wall(w, at(0, 0, 0), vec(5, 0.005, 5));
    CharacterDef def;
    def.fall_speed_max = real(300), def.gravity = real(300);
    const CharacterId c = add_character(w, 0, 90, 0, def);
    run(w, 120);
    CHECK(feet(w, c)[1] == test::about(0.005 + skin, 0.1));
}

TEST_CASE("a character jumps through a one-way platform from below and lands on it from above") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add(w, {.kind = BodyKind::static_, .pose = at(0, 1, 0)},
        {.geometry = box(2_r, 0.05_r, 2_r), .one_way = 1});
    CharacterDef def;
    def.jump_speed = real(6);
    const CharacterId c = add_character(w, 0, 0.01, 0, def);
    run(w, 30);
    CHECK(feet(w, c)[1] < 0.01);
    drive(w, c, 0, 0, true);
    run(w, 120);
    CHECK(stands(w, c));
    CHECK(feet(w, c)[1] == test::about(1.05 + skin, 0.001));

    // negative control: a box that is not one-way is a ceiling
    World solid = made(World::create(small_def()));
    add_floor(solid);
    add_wall(solid, at(0, 2.2, 0), vec(2, 0.05, 2));
    const CharacterId below = add_character(solid, 0, 0.01, 0, def);
    run(solid, 30);
    drive(solid, below, 0, 0, true);
    for (int i = 0; i < 60; ++i) {
        solid.tick();
        CHECK(feet(solid, below)[1] < 0.36);
        CHECK(overlap(solid, below) == 0);
    }
}

TEST_CASE("a character that is created inside a body moves out of it") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_wall(w, at(0, 0.5, 0), vec(1, 0.5, 1));
    const CharacterId c = add_character(w, 0.2, 0.7, 0.1);
    run(w, 10);
    CHECK(overlap(w, c) == 0);
    CHECK(w.character_state(c).squeezed == 0);
    const CharacterId deep = add_character(w, 5, -0.5, 0);
    run(w, 10);
    CHECK(overlap(w, deep) == 0);
    CHECK(feet(w, deep)[1] == test::about(skin, 0.1));
}

// ---- landing ---------------------------------------------------------------------------------------------------

namespace {

/// The number of landings, by events, of a character that is dropped from `height`, within three seconds, and their
/// speed.
struct Landings {
    int count = 0;
    double speed = 0;
    BodyId ground{};
};
Landings drop_from(double height, bool onto_lift = false) {
    World w = made(World::create(small_def()));
    const BodyId ground =
        onto_lift
            ? add(w, {.kind = BodyKind::kinematic, .pose = at(0, -1, 0), .linear_velocity = vec(0, 1, 0)},
                  {.geometry = box(Real(3), real(0.5), Real(3))})
            : add_floor(w);
    const CharacterId c = add_character(w, 0, height, 0);
    Landings out;
    for (int t = 0; t < 180; ++t) {
        w.tick();
        for (const Event& e : w.events()) {
            if (e.kind != EventKind::character_landed) continue;
            CHECK(e.body_a == w.body_of(c));
            CHECK(e.tick == w.tick_count() - 1);
            ++out.count, out.speed = to_double(e.approach_speed), out.ground = e.body_b;
        }
    }
    CHECK(out.ground == ground);
    return out;
}

} // namespace

TEST_CASE("a character that lands reports one landing with its ground and the speed relative to its ground") {
    for (const double height : {0.5, 2.0, 5.0}) {
        const Landings l = drop_from(height);
        CHECK(l.count == 1);
        CHECK(l.speed == test::about(std::sqrt(2 * 9.81 * height), 0.05));
    }
    CHECK(drop_from(2, true).speed > drop_from(2).speed + 0.8); // onto a rising lift
}

TEST_CASE("planted fault: the check rejects the landing speed of a fall from another height") {
    CHECK(drop_from(2).speed != test::about(std::sqrt(2 * 9.81 * 2.5), 0.05));
}

TEST_CASE("a character reports no landing when it walks or climbs stairs or stands and one landing after "
          "each jump") {
    World w = made(World::create(small_def()));
    add_floor(w);
    for (int i = 0; i < 4; ++i) add_wall(w, at(3 + 0.5 * i, 0.1 * (i + 1), 0), vec(0.25, 0.1 * (i + 1), 2));
    const CharacterId c = add_character(w, 0, 0.01, 0);
    run(w, 30);
    int landings = 0;
    const auto count = [&](int ticks) {
        for (int t = 0; t < ticks; ++t) {
            w.tick();
            for (const Event& e : w.events()) landings += e.kind == EventKind::character_landed;
        }
    };
    drive(w, c, 2, 0);
    count(110);
    drive(w, c, 0, 0);
    count(30);
    CHECK(landings == 0);
    for (int i = 1; i <= 3; ++i) {
        drive(w, c, 0, 0, true);
        count(5);
        drive(w, c, 0, 0);
        count(90);
        CHECK(landings == i);
    }
}
