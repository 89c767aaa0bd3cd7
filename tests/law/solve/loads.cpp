// A resting load is no impact, at any force and any length of a substep: static friction holds it.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double held_max = 0.001; // [m] in some seconds, where friction exceeds the pull

void run(World& w, std::uint32_t ticks) {
    for (std::uint32_t i = 0; i < ticks; ++i) w.tick();
}

/// Returns how far a box slips in five seconds on a slope of 20 degrees, after two seconds. tan 20 degrees is 0.364,
/// friction 0.6.
double slip_on_slope(std::uint32_t tick_rate, std::uint32_t substeps, double gravity) {
    WorldDef def = small_def();
    def.tick_rate = tick_rate, def.substeps = substeps, def.gravity = vec(0, -gravity, 0);
    World w = made(World::create(def));
    const Quat slope = turned(axis_z, 20);
    add(w, {.kind = BodyKind::static_, .pose = at(0, 0, 0, slope)}, {.geometry = plane(), .friction = 0.6_r});
    const double turn = 20 * 3.14159265358979323846 / 180;
    const BodyId box_on_it = add(w, {.pose = at(-0.5 * std::sin(turn), 0.5 * std::cos(turn), 0, slope)},
                                 {.geometry = box(0.5_r, 0.5_r, 0.5_r), .friction = 0.6_r});
    run(w, 2 * tick_rate);
    const D3 before = position(w, box_on_it);
    run(w, 5 * tick_rate);
    return length(position(w, box_on_it) - before);
}

} // namespace

TEST_CASE("a box stays on a slope at any speed that its weight adds in a substep") {
    for (const std::uint32_t rate : {60u, 30u, 20u})
        for (const std::uint32_t substeps : {1u, 2u, 4u})
            for (const double gravity : {1.6, 9.81, 20.0, 100.0}) {
                if (gravity / (rate * substeps) > 2) continue; // speeds of more than 2 m/s in a substep
                INFO(rate, " ticks a second, ", substeps, " substeps, gravity ", gravity);
                CHECK(slip_on_slope(rate, substeps, gravity) < held_max);
            }
}

TEST_CASE("a crate that is pressed against a wall does not slip down") {
    for (const double force : {20.0, 55.0, 65.0, 300.0, 2000.0}) {
        World w = made(World::create(small_def()));
        add_wall(w, at(-1, 0, 0), vec(0.5, 5, 5));
        const BodyId crate = add(w, {.pose = at(0, 0, 0), .mass = 1_r},
                                 {.geometry = box(0.5_r, 0.5_r, 0.5_r), .friction = 1_r});
        double before = 0;
        for (int t = 0; t < 240; ++t) {
            done(w.add_force(crate, vec(-force, 0, 0)));
            if (t == 60) before = position(w, crate)[1];
            w.tick();
        }
        INFO(force, " N");
        CHECK(std::abs(position(w, crate)[1] - before) < held_max);
    }
}

TEST_CASE("a joint that presses a crate down holds it in place") {
    // A slider presses down with 300 N, and a force from the side has half of the value that friction can hold.
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId crate = add(w, {.pose = at(0, 0.5, 0), .mass = 1_r},
                             {.geometry = box(0.5_r, 0.5_r, 0.5_r), .friction = 0.6_r});
    JointDef press = six_dof_joint();
    press.axis[along_y].motor_speed = -1_r, press.axis[along_y].motor_force = 300_r;
    const BodyId frame = made(w.create_body({.kind = BodyKind::static_}));
    made(w.create_joint(press, frame, crate, at(0, 0.5, 0)));
    run(w, 60);
    const D3 before = position(w, crate);
    for (int t = 0; t < 240; ++t) {
        done(w.add_force(crate, vec(0.6 * 309.81 / 2, 0, 0)));
        w.tick();
    }
    CHECK(length(position(w, crate) - before) < held_max);
}

TEST_CASE("a tower stays upright at twenty times the earth's gravity") {
    WorldDef def = small_def();
    def.gravity = vec(0, -200, 0);
    World w = made(World::create(def));
    add_floor(w);
    const std::vector<BodyId> tower = add_stack(w, 5);
    CHECK(rest_after(w, tower, 600).drift < 0.1);
    CHECK(position(w, tower.back())[1] > 4.3);
}
