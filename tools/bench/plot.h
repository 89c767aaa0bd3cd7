// Pictures of what was measured, for gnuplot to draw as SVG.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

/// Of `front`, where it was measured: cost against quality, scene by scene. Else of the scenes: Bullet / ours beside what it
/// must be.
Result<std::string> plot_script(const Json& results, const std::string& file);

} // namespace lockstone::bench
