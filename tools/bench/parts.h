// The parts of `lockstone bench`. Each part can be run alone; all results form one JSON object.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

struct Plan {
    /// Names from part_names(), or scenes of `lockstone scenes`; empty: all parts but front and threads.
    std::vector<std::string> parts = {};
    std::vector<int> substeps = {}; ///< of Lockstone, one contestant for each; empty: the default
    /// Instruction sets of Lockstone, one contestant for each; empty: the best.
    std::vector<std::string> simd = {};
    int ticks = 0;      ///< timed ticks of a scene; 0: as many as the scene names
    int runs = 3;       ///< of each scene; the least time of each tick counts
    bool quick = false; ///< a few ticks of small scenes
};

/// The names of the scenes, then: state, awake, scaling, verify, arena, threads, front.
std::vector<std::string> part_names();
/// Returns an error for an unknown name; it lists the known ones.
Status check_parts(const std::vector<std::string>& parts);
/// The chosen parts that are scenes of the benchmark.
std::vector<BenchScene> chosen_scenes(const Plan& plan);
std::vector<engines::Contestant> chosen_contestants(const Plan& plan);

/// Runs the chosen parts. Calls `done` with each row as soon as it is measured, and with the row's key in the results.
Result<Json> run_parts(const Plan& plan,
                       const std::function<void(const std::string& key, const Json& row)>& done);

} // namespace lockstone::bench
