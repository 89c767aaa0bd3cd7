// Measures the time of a tick by phase. The engine itself reads no clock; it only reports the end of each phase.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

/// Runs each scene in Lockstone and writes all phases of the last 60 ticks to `file`, as a Chrome trace
/// (chrome://tracing, ui.perfetto.dev). Returns the time of each phase for each scene: the median over all ticks,
/// because the clock is the wall clock and includes other work of the machine.
Result<Json> profile(const std::vector<BenchScene>& scenes, const engines::Contestant& who, int ticks,
                     const std::string& file);

} // namespace lockstone::bench
