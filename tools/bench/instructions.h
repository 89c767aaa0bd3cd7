// How many instructions a tick takes: exact where times are noise.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

/// Runs each scene to the tick that it is counted from, hands its state over to this very program under callgrind and reads
/// what that counted in a few ticks. `keep`: a folder for callgrind's files, for callgrind_annotate; empty: none are kept.
Result<Json> count_instructions(const std::vector<BenchScene>& scenes, const engines::Contestant& who,
                                const std::string& keep);
/// The other end: what runs under callgrind.
Result<void> run_counted(const BenchScene& scene, const engines::Contestant& who,
                         const std::string& state_file);

} // namespace lockstone::bench
