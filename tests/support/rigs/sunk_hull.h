// Hulls that begin inside a floor. For the tests and for the planted faults.
#pragma once

#include "law/zoo/object.h"
#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <algorithm>
#include <string>

namespace lockstone::test {

/// A prism of 3 to 8 m whose sides are flat to 0.3 to 1 mm begins a tick 1 to 5 cm deep in a box, nearly level. Returns
/// a sentence if no contact point is at least half as deep as the lowest corner.
inline std::string sunk_hull_fault(std::uint64_t seed) {
    SplitMix random(seed);
    const double large = drawn(random, 3, 8), small = drawn(random, 0.2, 0.6), middle = drawn(random, 1, 3),
                 flatness = drawn(random, 0.0003, 0.001);
    const zoo::Object prism = zoo::draw_prism(random, large, small, middle, flatness);
    const double yaw = drawn(random, 0, 360), tilt = drawn(random, -5, 5), depth = drawn(random, 0.01, 0.05);
    const Quat turn = normalized(scene::turned(scene::axis_z, tilt) * scene::turned(scene::axis_y, yaw));
    double lowest = 1e9;
    for (const auto& corner : prism.corners)
        lowest = std::min(lowest, to_double(rotate(turn, scene::vec(corner[0], corner[1], corner[2])).y) -
                                      prism.radius);
    World w = scene::made(World::create(WorldDef{}, {}, prism.assets));
    scene::add_wall(w, scene::at(0, -2, 0), scene::vec(40, 2, 40));
    scene::add(w, {.pose = scene::at(0, -lowest - depth, 0, turn)}, {.geometry = prism.geometry});
    w.tick();
    double deepest = 0;
    for (const ContactPoint& point : w.contacts()) deepest = std::max(deepest, -to_double(point.separation));
    if (deepest >= depth / 2) return {};
    return "seed " + std::to_string(seed) + ": a hull is " + std::to_string(depth) +
           " m deep in a box, its deepest contact point " + std::to_string(deepest) + " m";
}

} // namespace lockstone::test
