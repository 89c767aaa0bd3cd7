// The timed scenes: their bodies, the script that acts on them, and the bounds of their cost.
//
// One thread, sleeping off, 1/60 s, gravity -9.81 m/s^2, 1000 kg/m^3, friction 0.6, each engine at its default quality.
// The scenes are usual benchmarks of such engines: a wall of boxes, heaps, ragdolls, a terrain, a game.
#pragma once

#include "engines/scene.h"

#include <functional>

namespace lockstone::bench {

/// The bounds of a scene's cost and quality; 0: no bound.
struct Target {
    double ratio_must = 0, ratio_goal = 0;               ///< time of Bullet / time of Lockstone
    double p99_ratio_must = 0;                           ///< the same ratio for the 99th percentiles
    double instructions_must = 0, instructions_goal = 0; ///< of a tick [millions]
    double overlap_mm = 0;                               ///< the deepest overlap at the end
    bool overlap_with_static = false; ///< `overlap_mm` bounds only the overlap with static bodies
    double sway_mm = 0;               ///< also demands that no body falls
    double joint_mm = 0;              ///< the widest joint in the whole run
    double heap_mb = 0;               ///< at the end
    double p99_per_mean = 2;          ///< of the ticks after the bodies have landed
    double near_points = 0;           ///< contact points that do not touch, in any tick
};

struct BenchScene {
    std::string name;  ///< "S1"
    std::string about; ///< "pyramid of 820 boxes"
    engines::Scene scene = {};
    int ticks = 600;        ///< timed ticks
    int judged_after = 600; ///< ticks until the quality is measured; those beyond `ticks` are not timed
    int landed_after = 150; ///< ticks until the bodies have landed
    int counted_from = 300; ///< the tick from which instructions are counted
    int settle = 0;         ///< ticks before the timed ones
    int warm = 10;          ///< ticks before the counted ones, since caches are cold after a restore
    int counted = 4;        ///< number of ticks whose instructions are counted
    std::function<void(engines::Engine&, int tick)> script = {}; ///< runs before each tick; may be empty
    /// The timed part of a tick; empty: Engine::advance.
    std::function<void(engines::Engine&, int tick)> act = {};
    const char* figure_name = ""; ///< name of `figure`; empty: the scene has none
    /// A scene's own measure of quality, at the end.
    std::function<double(const engines::Engine&)> figure = {};
    bool against_ode = true; ///< ODE can run it too
    /// [m]: a body is lost beyond half_side along x or z, or below floor.
    double half_side = 1e9, floor = -5;
    bool stands = false; ///< sway and fallen bodies are measured
    Target target = {};
};

/// `full` for measurements; `quick` makes small scenes for a check that every scene runs.
enum class Size { full, quick };

std::vector<std::string> scene_names(); ///< S1 to S6, pyramids, grid, drum, S4-plane, the rows of rows/
struct Maker {
    const char* name;
    BenchScene (*make)(Size);
};
/// The scene of a name of scene_names().
BenchScene make_bench_scene(const std::string& name, Size size = Size::full);
/// Boxes at rest on a plane, 2 m apart.
BenchScene resting_boxes(int count);

} // namespace lockstone::bench
