// The quality of a run, measured in the same way for every engine.
#pragma once

#include "bench/scenes.h"

namespace lockstone::bench {

struct Quality {
    double overlap_mm = 0;        ///< the deepest overlap
    double overlap_static_mm = 0; ///< the deepest overlap with a static body
    double sway_mm = 0;           ///< the largest horizontal distance of a body from its start
    /// Bodies that dropped by more than a quarter of a metre, or turned by more than 20 degrees.
    int fallen = 0;
    double joint_mm = 0; ///< distance between the two anchors of the widest joint
    int lost = 0;        ///< bodies that left the scene
};

/// Measures the current poses. Overlaps come from Lockstone's narrow phase, which runs on a copy of the poses. So all
/// engines are measured alike, and no engine judges itself.
Quality quality_of(const BenchScene& scene, const engines::Engine& engine);
double widest_joint_mm(const engines::Scene& scene, const engines::Engine& engine);

} // namespace lockstone::bench
