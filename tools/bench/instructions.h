// Counts the instructions of a tick. The counts are exact where times are noisy.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

/// Runs each scene up to its warm-up ticks, passes its state to this program under callgrind, and reads the number of
/// instructions of a few ticks. `keep`: a folder for callgrind's files, to be read with callgrind_annotate; empty: the
/// files are removed.
Result<Json> count_instructions(const std::vector<BenchScene>& scenes, const engines::Contestant& who,
                                const std::string& keep);
/// The part that runs under callgrind.
Result<void> run_counted(const BenchScene& scene, const engines::Contestant& who,
                         const std::string& state_file);

} // namespace lockstone::bench
