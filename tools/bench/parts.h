// What `lockstone bench` can measure, part by part, and all of it in one object.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

struct Plan {
    std::vector<std::string> parts =
        {}; ///< of part_names(), or scenes of `lockstone scenes`; none: all but front and threads
    std::vector<int> substeps = {};     ///< of Lockstone: each is a contestant; none: the default
    std::vector<std::string> simd = {}; ///< instruction sets likewise; none: the best
    int ticks = 0;                      ///< timed in a scene; 0: its own
    int runs = 3;                       ///< of each scene: of each tick the least counts
    bool quick = false;                 ///< a few ticks of small scenes
};

/// The scenes, then: state, awake, scaling, verify, arena, threads, front.
std::vector<std::string> part_names();
/// An error that names the parts there are, for a name that is none.
Status check_parts(const std::vector<std::string>& parts);
/// Of the chosen parts, those that are scenes of the benchmark.
std::vector<BenchScene> chosen_scenes(const Plan& plan);
std::vector<engines::Contestant> chosen_contestants(const Plan& plan);

/// Measures. `done` sees each row as soon as it is there, with the key that it stands under.
Result<Json> run_parts(const Plan& plan,
                       const std::function<void(const std::string& key, const Json& row)>& done);

} // namespace lockstone::bench
