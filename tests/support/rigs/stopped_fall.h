// Balls that the sweep stops above a floor. For the tests and for the planted faults.
#pragma once

#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <cmath>
#include <string>

namespace lockstone::test {

/// A ball falls at 60 to 200 m/s, and the sweep stops it above a plane. Returns a sentence unless gravity has increased
/// its speed for the part of the tick's way that it moved.
inline std::string stopped_fall_fault(std::uint64_t seed) {
    SplitMix random(seed);
    constexpr std::uint32_t rates[] = {30, 60, 120};
    WorldDef def = scene::small_def();
    def.tick_rate = rates[random.below(3)];
    const double speed = drawn(random, 60, 200), time = 1.0 / def.tick_rate, radius = 0.1,
                 start = radius + speed * time * drawn(random, 0.4, 0.9);
    World w = scene::made(World::create(def));
    scene::add_floor(w);
    const BodyId ball = scene::add(
        w, {.pose = scene::at(0, start, 0), .linear_velocity = scene::vec(0, -speed, 0), .bullet = 1},
        {.geometry = sphere(scene::real(radius))});
    w.tick();
    const double fall = 9.81, whole = speed * time, gone = start - scene::position(w, ball)[1],
                 wanted = speed + fall * time * gone / whole, now = -scene::velocity(w, ball)[1];
    // The way of a tick includes gravity's part: a share of g t^2 / whole.
    if (std::abs(now - wanted) <= fall * time * (fall * time * time / whole) + 1e-4) return {};
    return "seed " + std::to_string(seed) + ": a stopped ball falls at " + std::to_string(now) +
           " m/s in place of " + std::to_string(wanted) + " m/s";
}

} // namespace lockstone::test
