// A parked vehicle sleeps. It wakes when a player drives it, a body touches it, or its support disappears.
#include "support/rigs/vehicle_rig.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::vehicle;

namespace {

Setting drowsy() {
    Setting s;
    s.world.sleeping = 1;
    return s;
}
/// Ticks until it sleeps, at most 900. The input is set again in every tick, as by a game.
int ticks_to_sleep(Rig& rig, const VehicleInput& input) {
    int ticks = 0;
    for (; rig.w.is_awake(rig.chassis) && ticks < 900; ++ticks) rig.drive(input), rig.w.tick();
    return ticks;
}
bool parks(const VehicleInput& input, WheelCast cast = WheelCast::sphere) {
    Rig rig = make_car(drowsy(), [cast](VehicleDef& def) { def.cast = cast; });
    return ticks_to_sleep(rig, input) < 600;
}

} // namespace

TEST_CASE("a parked car comes to rest and sleeps with any input that does not drive it") {
    CHECK(parks({}));
    CHECK(parks({.gear = 0}));
    CHECK(parks({.brake = 1_r}));
    CHECK(parks({.steer = 0.5_r, .hand_brake = 1_r}));
    for (const WheelCast cast : {WheelCast::ray, WheelCast::cylinder}) {
        CHECK(parks({}, cast));
        CHECK(parks({.hand_brake = 1_r, .gear = 0}, cast));
        CHECK(parks({.brake = 1_r, .steer = 0.5_r}, cast));
    }
}

TEST_CASE("planted fault: a car with throttle stays awake in gear and in neutral") {
    CHECK_FALSE(parks({.throttle = 1_r}));
    CHECK_FALSE(parks({.throttle = 0.3_r, .gear = 0}));
}

TEST_CASE("a car sleeps without motion at the place where an awake car stays") {
    Rig rig = make_car(drowsy()), other = make_car();
    REQUIRE(ticks_to_sleep(rig, {}) < 600);
    CHECK(rig.w.awake_count() == 0);
    const Transform pose = rig.w.pose(rig.chassis);
    rig.run(300);
    CHECK(rig.w.pose(rig.chassis) == pose);
    other.run(900);
    CHECK(length(rig.at() - other.at()) < 0.002);
}

TEST_CASE("a sleeping car wakes for a new input or a hit or changed ground under a wheel and not for the "
          "same input") {
    for (int what = 0; what < 5; ++what) {
        Rig rig = make_car(drowsy());
        const BodyId plank = add(rig.w, {.kind = BodyKind::kinematic, .pose = at(0.75, -0.48, 1.4)},
                                 {.geometry = box(0.4_r, 0.5_r, 0.4_r)}); // 2 cm high, under a front wheel
        REQUIRE(ticks_to_sleep(rig, {}) < 600);
        rig.run(10);
        INFO("case ", what);
        if (what == 0) rig.drive({});
        if (what == 1) rig.drive({.throttle = 0.5_r});
        if (what == 2) done(rig.w.set_velocity(plank, vec(0, 0.1, 0), {}));
        if (what == 3) done(rig.w.destroy(plank));
        if (what == 4)
            add(rig.w, {.pose = at(0, 1, 5), .linear_velocity = vec(0, 0, -6)}, {.geometry = sphere(0.3_r)});
        bool woke = false;
        for (int t = 0; t < 60; ++t) rig.w.tick(), woke = woke || rig.w.is_awake(rig.chassis);
        CHECK(woke == (what != 0));
    }
}

TEST_CASE("a plate that slides under the wheel of a sleeping car lifts the car") {
    Rig rig = make_car(drowsy());
    REQUIRE(ticks_to_sleep(rig, {.hand_brake = 1_r}) < 600);
    const double before = rig.at()[1];
    add(rig.w, {.pose = at(2.2, 0.06, 1.4), .linear_velocity = vec(-3, 0, 0)},
        {.geometry = box(0.3_r, 0.05_r, 0.3_r), .density = 8000_r, .friction = {}});
    double highest = before;
    for (int t = 0; t < 90; ++t) rig.w.tick(), highest = std::max(highest, rig.at()[1]);
    CHECK(highest > before + 0.005);
}

TEST_CASE("a car and the raft under it sleep in the same tick and wake together") {
    WorldDef def = small_def();
    def.sleeping = 1;
    World w = made(World::create(def));
    add_floor(w);
    const BodyId slab = add(w, {.pose = at(0, 0.26, 0)}, {.geometry = box(3_r, 0.25_r, 4_r)});
    const BodyId chassis =
        add(w, {.pose = at(0, 1.3, 0), .mass = 1200_r}, {.geometry = box(0.8_r, 0.3_r, 2_r)});
    made(w.create_vehicle(four_wheels(chassis, {0.75_r, -0.3_r, 1.4_r})));
    int ticks = 0;
    for (; w.is_awake(chassis) && ticks < 900; ++ticks) {
        w.tick();
        CHECK(w.is_awake(chassis) == w.is_awake(slab));
    }
    REQUIRE(ticks < 900);
    done(w.add_impulse(slab, vec(0, 0, 3000)));
    CHECK(w.is_awake(chassis));
}
