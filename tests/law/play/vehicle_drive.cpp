// Vehicles that drive, brake and turn, against textbook formulas.
#include "support/about.h"
#include "support/rigs/vehicle_rig.h"

#include <doctest/doctest.h>

#include <vector>

using namespace lockstone;
using namespace lockstone::test::vehicle;

namespace {

/// A rear-driven car with high grip and an engine of constant torque.
Rig strong_car(double torque) {
    Rig rig = make_car({}, [&](VehicleDef& def) {
        set_engine(def, torque);
        set_grip(def, 4);
    });
    rig.run(60);
    return rig;
}

/// The acceleration from one speed to the other [m/s^2]; backwards in gear -1.
double acceleration(double torque, double from, double to, std::int32_t gear = 1) {
    Rig rig = strong_car(torque);
    rig.drive({.throttle = 1_r, .gear = gear});
    int begin = 0, tick = 0;
    for (; tick < 1200 && rig.speed() * gear < to; ++tick) {
        if (rig.speed() * gear < from) begin = tick;
        rig.run(1);
    }
    return (to - from) * 60 / (tick - begin);
}

/// The mass including the inertia of turning parts; see strong_car.
double mass_with_turning(double ratio) {
    const double r = 0.35;
    return 1200 + (0.3 * ratio * ratio + 4 * 0.9) / (r * r);
}

struct Stop {
    double begin, way; ///< [m/s], [m]
};
/// The stopping distance, after half a second of free rolling.
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

/// The radius of the rear axle's path at walking speed [m].
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
        // The speed of the point 1.4 m behind the centre.
        const D3 back = -1.4 * rig.ahead();
        way += length(v + D3{w[1] * back[2], 0, -w[1] * back[0]});
    }
    return way / yaw;
}

} // namespace

TEST_CASE(
    "a car accelerates by the force at its wheels over its mass with the inertia of its turning parts") {
    struct Drive {
        std::int32_t gear;
        double ratio;
    };
    for (const Drive& d : {Drive{1, 3.6 * 3.7}, Drive{-1, 3.2 * 3.7}})
        for (double torque : {100.0, 200.0}) {
            const double force = torque * d.ratio / 0.35, mass = mass_with_turning(d.ratio),
                         expected = force / mass;
            const double found = acceleration(torque, 5, 14, d.gear);
            // Both ends are known to a tick. The turning parts run faster than the road by the slip that gives the
            // force, 0.05 at a grip of 4; the error is their share of the mass.
            const double slip = 0.05 * force / (4 * 1200 * g / 2);
            const double bound = 2 * expected / 60 / (14 - 5) + slip * (1 - 1200 / mass);
            INFO("gear ", d.gear, ", ", torque, " N m: ", found, " m/s^2 for ", expected);
            CHECK(off(found, expected) < bound);
            CHECK_FALSE(off(found, force / 1200) < bound); // planted: without the inertia of turning parts
        }
}

TEST_CASE("the top speed of each gear is that of the engine's limit") {
    const double ratios[] = {3.6, 2.1, 1.4};
    for (std::int32_t gear = 1; gear <= 3; ++gear) {
        Rig rig = strong_car(400);
        rig.drive({.throttle = 1_r, .gear = gear});
        rig.run(1500);
        const double ratio = ratios[gear - 1] * 3.7, top = 6500 * 2 * pi_double / 60 / ratio * 0.35;
        INFO("gear ", gear, ": ", rig.speed(), " m/s for ", top);
        CHECK(off(rig.speed(), top) < 0.01); // the limiter reduces the fuel over the last hundredth
    }
}

TEST_CASE("a car with locked wheels stops within v^2 / (2 mu g)") {
    for (double speed : {10.0, 20.0, 30.0})
        for (double grip : {0.5, 0.9}) {
            const Stop s = stop_from(speed, grip, 100);
            const double expected = s.begin * s.begin / (2 * grip * g);
            INFO(speed, " m/s, grip ", grip, ": ", s.way, " m for ", expected);
            const double bound = 2 * s.begin / 480 / expected; // wheels lock within one or two substeps
            CHECK(off(s.way, expected) < bound);
            CHECK_FALSE(off(stop_from(speed, grip * 0.98, 100).way, expected) <
                        bound); // planted: a worse tyre
        }
}

TEST_CASE("brakes that do not lock the wheels stop a car by their torque") {
    const Stop s = stop_from(20, 2, 0.5);
    const double force = 0.5 * (2 * 1500 + 2 * 600) / 0.35, mass = 1200 + 4 * 0.9 / (0.35 * 0.35);
    const double expected = s.begin * s.begin / 2 / (force / mass);
    // Before they brake, wheels must turn slower than the road, by the slip of this force; the rest is as above.
    const double slip = 0.05 * force / (2 * 1200 * g);
    CHECK(off(s.way, expected) < 2 * s.begin / 480 / expected + 2 * slip * (mass / 1200 - 1));
}

TEST_CASE("a car at walking speed turns about the point where its axles meet") {
    for (double steer : {0.2, 0.5, -0.5, 1.0}) {
        const double angle = std::abs(steer) * 0.6, expected = 2.8 / std::tan(angle);
        const double found = turning_radius(steer);
        INFO("steer ", steer, ": radius ", found, " m for ", expected);
        // Tyres drift sideways by the slip of the turn's force, at a grip of 2: v^2 / R over g. At most one axle's
        // angle is off by that.
        const double slip = 0.05 * 3 * 3 / (expected * g) / 2;
        CHECK(off(found, expected) < slip / (std::sin(angle) * std::cos(angle)));
        CHECK_FALSE(off(found, 2.8 / std::tan(angle * 1.04)) <
                    slip / (std::sin(angle) * std::cos(angle))); // planted fault: 4 % more steering
    }
}

TEST_CASE("the inner wheel steers more than the outer one by Ackermann's formula") {
    Rig rig = make_car();
    rig.drive({.steer = 0.5_r}); // to the right
    rig.run(1);
    const VehicleState s = rig.state();
    const double left = to_double(s.wheel[0].steer), right = to_double(s.wheel[1].steer);
    CHECK(right < left);
    CHECK(left < 0);
    CHECK(1 / std::tan(-left) - 1 / std::tan(-right) == test::about(1.5 / 2.8, 1e-6));
    CHECK(to_double(s.wheel[2].steer) == 0);
}

TEST_CASE("the lateral acceleration of a car is at most its grip and nearly reaches it") {
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
        double load = 0; // of all wheels, in six ticks, over the weight
        for (int t = 0; t < 6; ++t) {
            rig.run(1);
            const VehicleState s = rig.state();
            for (std::uint32_t wheel = 0; wheel < 4; ++wheel)
                load += to_double(s.wheel[wheel].load) / (6 * 1200 * g);
        }
        const D3 change = velocity(rig.w, rig.chassis) - before;
        strongest = std::max(strongest, std::hypot(change[0], change[2]) * 10 / load);
    }
    INFO("strongest ", strongest / g, " g");
    CHECK(strongest < 0.8 * g * 1.005); // loads are those of the last of eight substeps
    // The front wheels, at 0.24 rad, push with all their grip; so do the rear ones, or the car would turn ever faster.
    CHECK(strongest > 0.8 * g * std::cos(0.24));
}

TEST_CASE("an automatic gearbox shifts up and down at its defined engine speeds") {
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
    // The report is at most a tick old: in a tick the engine gains at most the speed of first gear, and loses at most
    // the speed that its brakes remove in second gear: 0.8 of 12,000 N.
    const double per_speed = 3.7 / 0.35 * 60 / (2 * pi_double), first = 3.6, second = 2.1;
    const double gain = 300 * first * 3.7 / 0.35 / mass_with_turning(first * 3.7) / 60 * first * per_speed;
    const double loss = 0.8 * 12000 / 1200 / 60 * second * per_speed;
    REQUIRE(ups.size() == 4);
    for (double rpm : ups) CHECK(std::abs(rpm - 5500) < gain);
    REQUIRE(downs.size() == 4);
    for (double rpm : downs) CHECK(rpm - 2200 < loss); // lower while the gearbox pauses between two changes
    CHECK(before.gear == 1);
}

TEST_CASE("a limited slip differential drives the wheel with grip like a locked one") {
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
    // A bias of 1 brakes the difference of the wheels by the whole input torque: as if locked. Both wheels then carry
    // their limits, 0.05 and 1 of a quarter of the weight; this force bounds the distance, and the clutch takes some
    // time. With an open differential the wheel on the road has the torque of the wheel on ice: 0.05 of a quarter, and
    // the torque that accelerates that wheel.
    const double most = 1.05 * (g / 4) * 3 * 3 / 2;
    CHECK(off(limited, locked) < 0.01);
    CHECK(locked < most);
    CHECK(locked > 0.8 * most);
    CHECK(limited > 2 * open);
}

TEST_CASE("a tracked vehicle turns on the spot and drives straight ahead") {
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
    // The need of a game: a third of a turn in five seconds, to the right, moving by less than a hand's breadth.
    CHECK(turned < -2 * pi_double / 3);
    CHECK(length(rig.at() - from) < 0.1);
    const VehicleState s = rig.state();
    CHECK(s.wheel[0].spin > 0_r);
    CHECK(s.wheel[1].spin < 0_r);

    rig.drive({.brake = 1_r, .gear = 0});
    rig.run(120);
    const D3 begin = rig.at(), ahead = rig.ahead();
    rig.drive({.throttle = 1_r});
    rig.run(300);
    const D3 way = rig.at() - begin;
    CHECK(dot(way, ahead) > 10); // the need of a game: a running man's pace
    CHECK(std::sqrt(std::max(0.0, dot(way, way) - dot(way, ahead) * dot(way, ahead))) <
          0.01 * dot(way, ahead));
}
