// The scenes that are timed: bodies, what a script does to them, and what they have to cost.
//
// One thread, sleeping off, 1/60 s, gravity -9.81 m/s^2, 1000 kg/m^3, friction 0.6, each engine at its default quality. The
// scenes are what engines of this kind are measured with: a wall of boxes, heaps, ragdolls, a terrain, a game.
#pragma once

#include "engines/scene.h"

#include <functional>

namespace lockstone::bench {

/// What a scene is to cost, and how good it is to be; 0: nothing is asked.
struct Target {
    double ratio_must = 0, ratio_goal = 0;               ///< time of Bullet / ours
    double p99_ratio_must = 0;                           ///< the same ratio of the 99th percentiles
    double instructions_must = 0, instructions_goal = 0; ///< a tick [millions]
    double overlap_mm = 0;                               ///< the worst at the end
    bool overlap_with_static = false; ///< of that, what is asked is the overlap with what stands still
    double sway_mm = 0;               ///< and nothing falls
    double joint_mm = 0;              ///< the widest joint in the whole run
    double heap_mb = 0;               ///< at the end
    double p99_per_mean = 2;          ///< of the ticks once bodies have landed
    double near_points = 0;           ///< contact points that do not touch, in any tick
};

struct BenchScene {
    std::string name;  ///< "S1"
    std::string about; ///< "pyramid of 820 boxes"
    engines::Scene scene = {};
    int ticks = 600;        ///< timed
    int judged_after = 600; ///< ticks: then its quality is measured; what is beyond `ticks` is not timed
    int landed_after = 150; ///< ticks
    int counted_from = 300; ///< the tick from which instructions are counted
    int settle = 0;         ///< ticks before those that are timed
    int warm = 10;          ///< ticks before those that are counted; after a restore caches are cold
    int counted = 4;        ///< ticks whose instructions are counted
    std::function<void(engines::Engine&, int tick)> script = {}; ///< before a tick, none: nothing
    std::function<void(engines::Engine&, int tick)> act =
        {};                       ///< the timed part of a tick; none: Engine::advance
    const char* figure_name = ""; ///< of `figure`; empty: there is none
    std::function<double(const engines::Engine&)> figure = {}; ///< how well it went, at the end
    bool against_ode = true;                                   ///< ODE can do it too
    double half_side = 1e9, floor = -5; ///< [m]: whoever is farther out along x or z, or lower, is lost
    bool stands = false;                ///< sway and fallen bodies are measured
    Target target = {};
};

/// Sizes for a check that all runs, in place of the real ones.
enum class Size { full, quick };

std::vector<std::string> scene_names(); ///< S1 to S6, pyramids, grid, drum, S4-plane, the rows of rows/
struct Maker {
    const char* name;
    BenchScene (*make)(Size);
};
/// Of a name that is there.
BenchScene make_bench_scene(const std::string& name, Size size = Size::full);
/// Boxes on a plane, 2 m from each other.
BenchScene resting_boxes(int count);

} // namespace lockstone::bench
