// Where a tick's time goes, phase by phase. The clock is here, outside of the engine, which only says what it has done.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

/// Runs each scene in Lockstone and writes all phases of the last 60 ticks to `file`, as a Chrome trace (chrome://tracing,
/// ui.perfetto.dev). Returns, for each scene, what each phase takes of a tick: the median of
/// all ticks, for the clock is the wall's and the machine does other things too.
Result<Json> profile(const std::vector<BenchScene>& scenes, const engines::Contestant& who, int ticks,
                     const std::string& file);

} // namespace lockstone::bench
