// Bullets that pass through sensors, or beside them. For the tests and for the planted faults.
#pragma once

#include "lockstone/math/convert.h"
#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace lockstone::zoo {

namespace scene = test::scene;

/// A shape and the radius of the ball about its origin that contains it [m].
struct Passer {
    Geometry geometry;
    double reach;
};

inline double drawn_between(test::SplitMix& random, double low, double high) {
    return low * std::pow(high / low, static_cast<double>(random.below(1u << 20)) / (1u << 20));
}

inline Passer draw_passer(test::SplitMix& random, double size) {
    const auto extent = [&] { return quantize<Real>(drawn_between(random, size / 20, size)); };
    const Real a = extent(), b = extent(), c = extent();
    const double x = to_double(a), y = to_double(b), z = to_double(c);
    switch (random.below(4)) {
    case 0:
        return {sphere(a), x};
    case 1:
        return {capsule(a, b), x + y};
    case 2:
        return {cylinder(a, b), std::hypot(x, y)};
    default:
        return {box(a, b, c), std::hypot(x, y, z)};
    }
}

/// Shoots a bullet along a straight line through the centre of a shape, or beside it. One of the two is a sensor.
/// Returns a sentence unless the events are one begin and then one end (or none beside it).
inline std::string passage_fault(std::uint64_t seed) {
    test::SplitMix random(seed);
    constexpr std::uint32_t rates[] = {30, 60, 120, 240};
    WorldDef def = scene::weightless();
    def.tick_rate = rates[random.below(4)];
    World w = scene::made(World::create(def));
    const Passer still = draw_passer(random, 1), shot = draw_passer(random, 0.3);
    const bool is_hit = random.below(4) != 0, carries_sensor = random.below(3) == 0,
               is_driven = random.below(3) == 0;
    const auto part = [&] { return static_cast<double>(random.below(2001)) / 1000 - 1; };
    const auto turn = [&] {
        return normalized(scene::turned(scene::axis_z, 180 * part()) *
                          scene::turned(scene::axis_x, 180 * part()));
    };
    const double speed = drawn_between(random, 20, 400), begin = 4 + part(),
                 beside = is_hit ? 0 : still.reach + shot.reach + 0.05;
    const double drift_x = is_driven ? 3 * part() : 0, drift_z = is_driven ? 3 * part() : 0;
    const Vec3 drift = scene::vec(drift_x, 0, drift_z),
               spin = is_driven ? scene::vec(6 * part(), 6 * part(), 0) : Vec3{};
    ShapeDef of_still{.geometry = still.geometry}, of_shot{.geometry = shot.geometry};
    (carries_sensor ? of_shot : of_still).sensor = 1;
    // Both bodies may be bullets: then each sweeps against the other.
    const bool are_both_bullets = random.below(3) == 0;
    BodyDef other{.kind = is_driven ? BodyKind::kinematic : BodyKind::static_,
                  .pose = scene::at(0, 0, 0, turn()),
                  .linear_velocity = drift,
                  .angular_velocity = spin};
    if (are_both_bullets) other.kind = BodyKind::dynamic, other.mass = Real(1), other.bullet = 1;
    scene::add(w, other, of_still);
    BodyDef bullet{.pose = scene::at(-begin, beside, 0, turn()),
                   .linear_velocity = scene::vec(speed + drift_x, 0, drift_z),
                   .angular_velocity = scene::vec(9 * part(), 9 * part(), 9 * part())};
    bullet.mass = Real(1), bullet.bullet = 1;
    scene::add(w, bullet, of_shot);
    std::string order;
    const int ticks = static_cast<int>(2 * begin / speed * def.tick_rate) + 4;
    for (int t = 0; t < ticks; ++t) {
        w.tick();
        for (const Event& e : w.events()) {
            if (e.kind == EventKind::sensor_begin) order += "begin ";
            if (e.kind == EventKind::sensor_end) order += "end ";
        }
    }
    const std::string expected = is_hit ? "begin end " : "";
    return order == expected
               ? ""
               : "seed " + std::to_string(seed) + ": events '" + order + "' where '" + expected + "' are due";
}

} // namespace lockstone::zoo
