// Vehicles that drive, brake and turn, against the formulas of a textbook.
#include "support/rigs/vehicle_rig.h"

#include <doctest/doctest.h>

#include <vector>

using namespace lockstone;
using namespace lockstone::test::vehicle;

namespace {

/// A rear-driven car with plenty of grip and an engine of constant torque.
Rig strong_car(double torque) {
    Rig rig = make_car({}, [&](VehicleDef& def) {
        set_engine(def, torque);
        set_grip(def, 4);
    });
    rig.run(60);
    return rig;
}

/// From one speed to the other [m/s^2], in first gear.
double acceleration(double torque, double from, double to) {
    Rig rig = strong_car(torque);
    rig.drive({.throttle = 1_r});
    int begin = 0, tick = 0;
    for (; tick < 1200 && rig.speed() < to; ++tick) {
        if (rig.speed() < from) begin = tick;
        rig.run(1);
    }
    return (to - from) * 60 / (tick - begin);
}

/// Mass with what turns in first gear; see strong_car.
double mass_with_turning(double ratio) {
    const double r = 0.35;
    return 1200 + (0.3 * ratio * ratio + 4 * 0.9) / (r * r);
}

struct Stop {
    double begin, way; ///< [m/s], [m]
};
/// After half a second of rolling free.
Stop stop_from(double speed, double grip, double torque_scale) {
    Rig rig = make_car({}, [&](VehicleDef& def) {
        set_grip(def, grip);
        for (WheelDef& wheel : def.wheel) wheel.brake_torque = wheel.brake_torque * real(torque_scale);
    });
    rig.run(120);
    done(rig.w.set_velocity(rig.chassis, vec(0, 0, speed), {}));
    rig.drive({.gear = 0});
    rig.run(30);
    const double begin = rig.speed();
    rig.drive({.brake = 1_r, .gear = 0});
    const D3 from = rig.at();
    int ticks = 0;
    while (rig.speed() > 1e-3 && ticks++ < 1200) rig.run(1);
    return {begin, length(rig.at() - from)};
}

/// Radius of the way of the rear axle at walking speed [m].
double turning_radius(double steer) {
    Rig rig = make_car({}, [](VehicleDef& def) { set_grip(def, 2); });
    rig.run(120);
    done(rig.w.set_velocity(rig.chassis, vec(0, 0, 3), {}));
    rig.drive({.steer = real(steer), .gear = 0});
    rig.run(120);
    double yaw = 0, way = 0;
    for (int i = 0; i < 60; ++i) {
        rig.run(1);
        const D3 v = velocity(rig.w, rig.chassis), w = spin(rig.w, rig.chassis);
        yaw += std::abs(w[1]);
        // Of the point 1.4 m behind the centre.
        const D3 back = -1.4 * rig.ahead();
        way += length(v + D3{w[1] * back[2], 0, -w[1] * back[0]});
    }
    return way / yaw;
}

} // namespace

TEST_CASE("a car accelerates by the torque at its wheels over its mass and what turns with it") {
    const double ratio = 3.6 * 3.7;
    for (double torque : {100.0, 200.0}) {
        const double expected = torque * ratio / 0.35 / mass_with_turning(ratio);
        const double found = acceleration(torque, 5, 14);
        INFO(torque, " N m: ", found, " m/s^2 for ", expected);
        CHECK(off(found, expected) < 0.02);
        CHECK_FALSE(off(found, torque * ratio / 0.35 / 1200) < 0.02); // planted: what turns was forgotten
    }
}

TEST_CASE("each gear ends at the engine's limit") {
    const double ratios[] = {3.6, 2.1, 1.4};
    for (std::int32_t gear = 1; gear <= 3; ++gear) {
        Rig rig = strong_car(400);
        rig.drive({.throttle = 1_r, .gear = gear});
        rig.run(1500);
        const double top = 6500 * 2 * pi_double / 60 / (ratios[gear - 1] * 3.7) * 0.35;
        INFO("gear ", gear, ": ", rig.speed(), " m/s for ", top);
        CHECK(off(rig.speed(), top) < 0.015);
    }
}

TEST_CASE("reverse drives backwards, neutral does not drive") {
    Rig rig = strong_car(200);
    rig.drive({.throttle = 1_r, .gear = 0});
    rig.run(120);
    CHECK(std::abs(rig.speed()) < 0.01);
    rig.drive({.throttle = 1_r, .gear = -1});
    rig.run(120);
    CHECK(rig.speed() < -3);
}

TEST_CASE("locked wheels stop in v^2 / (2 mu g)") {
    for (double speed : {10.0, 20.0, 30.0})
        for (double grip : {0.5, 0.9}) {
            const Stop s = stop_from(speed, grip, 100);
            const double expected = s.begin * s.begin / (2 * grip * g);
            INFO(speed, " m/s, grip ", grip, ": ", s.way, " m for ", expected);
            CHECK(off(s.way, expected) < 0.02);
            CHECK_FALSE(off(stop_from(speed, grip * 0.9, 100).way, expected) < 0.02); // planted: a worse tyre
        }
}

TEST_CASE("brakes that do not lock stop by their torque") {
    const Stop s = stop_from(20, 2, 0.5);
    const double force = 0.5 * (2 * 1500 + 2 * 600) / 0.35, mass = 1200 + 4 * 0.9 / (0.35 * 0.35);
    CHECK(off(s.way, s.begin * s.begin / 2 / (force / mass)) < 0.03);
}

TEST_CASE("at walking speed a car rolls about the point where the axles meet") {
    for (double steer : {0.2, 0.5, -0.5, 1.0}) {
        const double angle = std::abs(steer) * 0.6, expected = 2.8 / std::tan(angle);
        const double found = turning_radius(steer);
        INFO("steer ", steer, ": radius ", found, " m for ", expected);
        CHECK(off(found, expected) < 0.03);
    }
}

TEST_CASE("the inner wheel steers more, as Ackermann has it") {
    Rig rig = make_car();
    rig.drive({.steer = 0.5_r}); // to the right
    rig.run(1);
    const VehicleState s = rig.state();
    const double left = to_double(s.wheel[0].steer), right = to_double(s.wheel[1].steer);
    CHECK(right < left);
    CHECK(left < 0);
    CHECK(1 / std::tan(-left) - 1 / std::tan(-right) == doctest::Approx(1.5 / 2.8).epsilon(1e-6));
    CHECK(to_double(s.wheel[2].steer) == 0);
}

TEST_CASE("a car cannot turn with more than its grip, and turns with most of it") {
    Rig rig = make_car({}, [](VehicleDef& def) {
        set_grip(def, 0.8);
        def.anti_roll[0] = {0, 1, 20000_r};
        def.anti_roll[1] = {2, 3, 20000_r};
    });
    rig.run(60);
    done(rig.w.set_velocity(rig.chassis, vec(0, 0, 20), {}));
    rig.drive({.steer = 0.4_r, .gear = 0});
    rig.run(30);
    double strongest = 0;
    for (int i = 0; i < 60; ++i) {
        const D3 before = velocity(rig.w, rig.chassis);
        rig.run(6);
        const D3 change = velocity(rig.w, rig.chassis) - before;
        strongest = std::max(strongest, std::hypot(change[0], change[2]) * 10);
    }
    INFO("strongest ", strongest / g, " g");
    CHECK(strongest < 0.8 * g * 1.03);
    CHECK(strongest > 0.8 * g * 0.8);
}

TEST_CASE("an automatic box shifts up and down at its speeds") {
    Rig rig = make_car({}, [](VehicleDef& def) {
        set_grip(def, 2);
        set_engine(def, 300);
        def.engine.brake_torque = 40_r;
        def.gearbox.mode = GearboxMode::automatic;
    });
    rig.run(60);
    rig.drive({.throttle = 1_r});
    std::vector<double> ups, downs;
    VehicleState before = rig.state();
    for (int i = 0; i < 2400; ++i) {
        if (i == 1500) rig.drive({.brake = 0.8_r});
        rig.run(1);
        const VehicleState now = rig.state();
        if (now.shifting != 0 && before.shifting == 0)
            (i < 1500 ? ups : downs).push_back(to_double(before.rpm));
        before = now;
    }
    REQUIRE(ups.size() == 4);
    for (double rpm : ups) {
        CHECK(rpm > 5500 * 0.99);
        CHECK(rpm < 5500 * 1.04);
    }
    REQUIRE(downs.size() == 4);
    for (double rpm : downs) CHECK(rpm < 2200 * 1.01);
    CHECK(before.gear == 1);
}

TEST_CASE("a limited slip differential drives the wheel that has grip") {
    const auto way = [](DifferentialKind kind) {
        Rig rig = make_car({}, [&](VehicleDef& def) {
            set_engine(def, 150);
            set_grip(def, 1);
            def.tyre[1].along =
                def.tyre[1].across = {{{0_r, 0_r}, {0.05_r, 0.05_r}, {1_r, 0.05_r}, {2_r, 0.05_r}}};
            def.wheel[2].tyre = 1; // the left rear wheel is on ice
            def.differential[0] = {kind, 4, 8, 0, 500_r, 1_r};
        });
        rig.run(60);
        rig.drive({.throttle = 1_r});
        rig.run(180);
        return length(rig.at());
    };
    const double open = way(DifferentialKind::open), limited = way(DifferentialKind::limited),
                 locked = way(DifferentialKind::locked);
    INFO("open ", open, ", limited ", limited, ", locked ", locked, " m");
    CHECK(limited > 2 * open);
    CHECK(locked > 0.95 * limited);
}

TEST_CASE("a tracked vehicle turns on the spot, and drives straight on") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId body =
        add(w, {.pose = at(0, 1.5, 0), .mass = 20000_r}, {.geometry = box(1.4_r, 0.5_r, 2.8_r)});
    const VehicleId id = made(w.create_vehicle(two_tracks(body, {1.5_r, -0.5_r, 2.4_r}, 4)));
    Rig rig{std::move(w), body, id};
    rig.run(120);
    const D3 from = rig.at();
    rig.drive({.throttle = 1_r, .steer = 1_r, .gear = 0});
    double turned = 0;
    for (int i = 0; i < 300; ++i) {
        rig.run(1);
        turned += spin(rig.w, body)[1] / 60;
    }
    INFO("turned ", turned, " rad, went ", length(rig.at() - from), " m");
    CHECK(turned < -2); // to the right
    CHECK(length(rig.at() - from) < 0.2);
    const VehicleState s = rig.state();
    CHECK(s.wheel[0].spin > 0_r);
    CHECK(s.wheel[1].spin < 0_r);

    rig.drive({.brake = 1_r, .gear = 0});
    rig.run(120);
    const D3 begin = rig.at(), ahead = rig.ahead();
    rig.drive({.throttle = 1_r});
    rig.run(300);
    const D3 way = rig.at() - begin;
    CHECK(dot(way, ahead) > 10);
    CHECK(length(way) < 1.001 * dot(way, ahead));
}
