// Poles whose end reaches the floor within a tick. For the tests and for the planted faults.
#pragma once

#include "law/zoo/passage.h"

namespace lockstone::zoo {

/// Turns a tilted pole upright, so that its lower end reaches a plane in the middle of the tick. Returns a sentence
/// unless there are contact points, none in the middle of its gap. Such a point gives friction an arm about
/// the long axis that the pole does not have.
inline std::string pole_point_fault(std::uint64_t seed) {
    test::SplitMix random(seed);
    WorldDef def{};
    def.tick_rate = random.below(2) == 0 ? 30 : 60;
    World w = scene::made(World::create(def));
    scene::add(w, {.kind = BodyKind::static_}, {.geometry = plane()});
    const auto part = [&] { return static_cast<double>(random.below(1001)) / 1000; };
    const double half = drawn_between(random, 0.5, 4), radius = drawn_between(random, 0.01, 0.04),
                 tilt = 0.7 + 0.6 * part(), turn = 0.2 + 0.3 * part(), // [rad]
        fall = half * (std::cos(tilt - turn) - std::cos(tilt));
    const Real h = quantize<Real>(half), r = quantize<Real>(radius);
    const Geometry shapes[] = {capsule(r, h), cylinder(r, h), box(r, h, r)};
    BodyDef pole{.pose = scene::at(0, half * std::cos(tilt) + 2 * radius + fall / 2, 0,
                                   scene::turned(scene::axis_z, tilt * 180 / 3.14159265358979)),
                 .angular_velocity = scene::vec(0, 0, -turn * def.tick_rate)};
    pole.mass = Real(1);
    scene::add(w, pole, {.geometry = shapes[random.below(3)]});
    w.tick();
    int points = 0;
    for (const ContactPoint& p : w.contacts()) {
        ++points;
        // The plane is at height 0. A point on the pole is as high as its separation; a corner that reaches the plane
        // later in the tick is lower.
        const double separation = to_double(p.separation), off = to_double(p.point.y) - separation / 2;
        if (std::abs(off) < separation / 16)
            return "seed " + std::to_string(seed) + ": a point is in the middle of a gap of " +
                   std::to_string(separation) + " m";
    }
    return points > 0 ? "" : "seed " + std::to_string(seed) + ": the pole has no contact";
}

} // namespace lockstone::zoo
