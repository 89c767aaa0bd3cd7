// Vehicles at rest, and vehicles that fall.
#include "support/about.h"
#include "support/rigs/vehicle_rig.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::vehicle;

namespace {

double mean_length(const Rig& rig) {
    const VehicleState s = rig.state();
    double sum = 0;
    for (std::uint32_t i = 0; i < s.wheel_count; ++i) sum += to_double(s.wheel[i].length);
    return sum / s.wheel_count;
}

/// Impulses are rounded to a step of a speed, of the g / 480 that a substep removes: that is the precision of the
/// springs' forces and deflections.
constexpr double rounding = speed_step / (g / 480);

double sag(double hertz) { return g / std::pow(2 * pi_double * hertz, 2); }

/// The difference of the suspension's deflection from g / (2 pi f)^2 [m]. `hertz_said` is the expected frequency,
/// `hertz_true` that of the car.
double sag_error(double hertz_said, double hertz_true) {
    Rig rig = make_car({}, [&](VehicleDef& def) { set_frequency(def, hertz_true); });
    rig.run(600);
    return std::abs(0.5 - mean_length(rig) - sag(hertz_said));
}

/// The distance in 600 ticks, after 300 to settle [m], with gravity tilted as on a slope that rises ahead, or sideways.
double creep(double degrees, bool sideways, const VehicleInput& input, double mass = 1200) {
    Setting s;
    s.mass = mass;
    const double down = g * std::cos(degrees * pi_double / 180),
                 along = g * std::sin(degrees * pi_double / 180);
    s.world.gravity = sideways ? vec(-along, -down, 0) : vec(0, -down, -along);
    Rig rig = make_car(s, [&](VehicleDef& def) {
        for (WheelDef& wheel : def.wheel)
            wheel.hand_brake_torque = wheel.hand_brake_torque * real(mass / 1200);
    });
    rig.drive(input);
    rig.run(300);
    const D3 from = rig.at();
    rig.run(600);
    return length(rig.at() - from);
}

struct Landing {
    double highest; ///< after the first contact [m]
    double error;   ///< of the height at the end [m]
    double speed;   ///< at the end [m/s]
};
Landing land(double mass) {
    Setting s;
    s.mass = mass;
    s.pose = at(0, 2.74, 0);
    Rig rig = make_car(s);
    Landing out{};
    bool touched = false;
    for (int i = 0; i < 600; ++i) {
        rig.w.tick();
        touched = touched || rig.state().wheel[0].load > 0_r;
        if (touched) out.highest = std::max(out.highest, rig.at()[1]);
    }
    out.error = std::abs(rig.at()[1] - (0.35 + 0.5 - sag(1.5)));
    out.speed = length(velocity(rig.w, rig.chassis));
    CHECK(rig.w.faults() == Faults{});
    return out;
}

} // namespace

TEST_CASE("a car's suspension is compressed by g / (2 pi f)^2 at rest") {
    for (double hertz : {1.2, 1.5, 2.0, 4.0}) CHECK(sag_error(hertz, hertz) < sag(hertz) * rounding);
    CHECK_FALSE(sag_error(1.5, 1.5005) < sag(1.5) * rounding); // planted: a spring 0.07 % off
}

TEST_CASE("wheels bear the weight above them with the centre of mass away from the middle") {
    Rig rig = make_car({}, [](VehicleDef& def) {
        for (std::size_t i = 0; i < 2; ++i)
            def.wheel[i].attachment.z = 1_r; // moves the centre of mass towards the front
    });
    rig.run(600);
    const VehicleState s = rig.state();
    const double front = to_double(s.wheel[0].load + s.wheel[1].load),
                 rear = to_double(s.wheel[2].load + s.wheel[3].load);
    CHECK(front + rear == test::about(1200 * g, rounding));
    // A wheel carries about a quarter.
    CHECK(front * 1.0 == test::about(rear * 1.4, 4 * rounding));
    CHECK(std::abs(to_double(s.wheel[0].length - s.wheel[2].length)) < 4 * rounding * sag(1.5)); // level
}

/// Two steps of a velocity, 3.8e-6 m/s, for ten seconds, and a margin of that size.
constexpr double creep_max = 8e-5;

TEST_CASE("a parked car does not creep on level ground or across or along a slope of 20 degrees") {
    CHECK(creep(0, false, {.gear = 0}) < creep_max);
    CHECK(creep(20, false, {.hand_brake = 1_r}) < creep_max);
    CHECK(creep(20, true, {.hand_brake = 1_r}) < creep_max);
    CHECK(creep(20, false, {.brake = 1_r}) < creep_max);
    CHECK(creep(20, false, {.hand_brake = 1_r}, 200) < creep_max);
    CHECK(creep(20, false, {.hand_brake = 1_r}, 40000) < creep_max);
    CHECK_FALSE(creep(20, false, {.gear = 0}) < creep_max); // planted: without a brake it rolls
}

TEST_CASE("a braked car slides down a slope that is steeper than its grip at the computed acceleration") {
    // The car slides backwards. The front wheels lock, at a grip of 0.9. The rear ones, onto which the brake's own
    // force presses the car, turn against 600 N m each. Rolling resistance, 0.01, is neglected: 2 % of the 0.3 g that
    // remain.
    const double angle = 50 * pi_double / 180, weight = 1200 * g * std::cos(angle);
    const double height = 0.35 + 0.5 - sag(1.5) * std::cos(angle);
    const double brake = (0.9 * weight / 2 + 2 * 600 / 0.35) / (1 + 0.9 * height / 2.8);
    const double way = (g * std::sin(angle) - brake / 1200) / 2 * (15 * 15 - 5 * 5); // from 5 s to 15 s
    const double found = creep(50, false, {.brake = 1_r});
    INFO(found, " m for ", way);
    CHECK(off(found, way) < 0.03);
}

TEST_CASE("cars of 200 kg and 40 t land from 2 m and come to rest") {
    for (double mass : {200.0, 1200.0, 40000.0}) {
        const Landing l = land(mass);
        INFO(mass, " kg: highest ", l.highest, " m, error ", l.error, " m, speed ", l.speed, " m/s");
        // From the stop, 0.1 + 0.35 m up, at most as far as the undamped spring lifts it from there, 0.72 m.
        const double pressed = 0.4 * 2 * pi_double * 1.5;
        CHECK(l.highest < 0.45 + pressed * pressed / (2 * g));
        CHECK(l.error < sag(1.5) * rounding);
        CHECK(l.speed < 4 * speed_step);
    }
}

TEST_CASE("anti-roll bars reduce the roll of a car by their stiffness") {
    const auto roll = [](double stiffness) {
        Setting s;
        const double tilt = 10 * pi_double / 180;
        s.world.gravity = vec(-g * std::sin(tilt), -g * std::cos(tilt), 0);
        Rig rig = make_car(s, [&](VehicleDef& def) {
            def.anti_roll[0] = {0, 1, real(stiffness)};
            def.anti_roll[1] = {2, 3, real(stiffness)};
        });
        rig.drive({.hand_brake = 1_r, .gear = 0});
        rig.run(600);
        return std::abs(rig.roll());
    };
    const double omega = 2 * pi_double * 1.5, height = 0.35 + 0.5 - g * std::cos(0.1745) / (omega * omega);
    const double weight = 1200 * g, springs = 1200 * omega * omega * 0.75 * 0.75;
    const auto expected = [&](double stiffness) {
        const double bars = 2 * stiffness * 1.5 * 1.5;
        return weight * std::sin(0.1745) * height / (springs + bars - weight * height);
    };
    CHECK(off(roll(0), expected(0)) < 0.08);
    CHECK(off(roll(20000), expected(20000)) < 0.08);
    CHECK(roll(20000) < 0.5 * roll(0));
    CHECK_FALSE(off(roll(0), expected(20000)) < 0.08); // planted: a car without bars
}
