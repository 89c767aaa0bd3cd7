// How well a scene went: what stands beside each time, measured in the same way for every engine.
#pragma once

#include "bench/scenes.h"

namespace lockstone::bench {

struct Quality {
    double overlap_mm = 0;        ///< the deepest
    double overlap_static_mm = 0; ///< the deepest with what stands still
    double sway_mm = 0;           ///< the farthest that anybody moved horizontally from where he started
    int fallen = 0;      ///< dropped by more than a quarter of a metre, or turned by more than 20 degrees
    double joint_mm = 0; ///< how far the anchors of the widest joint are apart
    int lost = 0;        ///< left the scene
};

/// Of the poses as they are. Overlaps are those that Lockstone's narrow phase finds when the engine's poses are put into a
/// world of its own: one measure for all, and not the engine's own opinion of itself.
Quality quality_of(const BenchScene& scene, const engines::Engine& engine);
double widest_joint_mm(const engines::Scene& scene, const engines::Engine& engine);

} // namespace lockstone::bench
