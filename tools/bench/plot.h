// gnuplot scripts that draw results as SVG.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

/// A script that draws `front` if the results have it: cost against quality for each scene. Otherwise it draws the time
/// ratio Bullet / Lockstone of each scene beside its bound.
Result<std::string> plot_script(const Json& results, const std::string& file);

} // namespace lockstone::bench
