// One scene in several engines at once: their ticks by turns, so that whatever else the machine does meets all alike.
#pragma once

#include "bench/quality.h"
#include "json/json.h"

namespace lockstone::bench {

using Json = json::Value;

/// What a contestant did in a scene.
struct Run {
    engines::Contestant who;
    std::vector<double> tick_us =
        {}; ///< of each tick the least of all runs: the work is the same in each, the noise is not
    double heap_mb = 0; ///< at the end, of its own
    Quality quality = {};
    double joint_worst_mm = 0; ///< in any tick
    double figure = 0;         ///< of a scene that has one of its own
    std::size_t contacts = 0;  ///< points in the last tick; Lockstone only
    std::size_t near_most = 0; ///< of them that do not touch, the most in any tick; Lockstone only
    std::uint64_t dropped = 0; ///< contacts that found no room; Lockstone only
};

struct ContestPlan {
    int ticks = 0; ///< timed; 0: the scene's own
    int runs = 1;
    bool is_judged = true; ///< quality is measured
};

/// 0: its default number of iterations.
engines::Contestant bullet_as_it_comes(const std::string& name, int iterations = 0);
/// All engines that are built, as they come.
std::vector<engines::Contestant> default_contestants();
std::vector<Run> contest(const BenchScene& scene, const std::vector<engines::Contestant>& who,
                         const ContestPlan& plan);

/// Runs the timed part of a tick once; returns its time of this thread [us].
double timed_act(const BenchScene& scene, engines::Engine& engine, int tick);

/// Mean, median and 99th percentile of a run [ms], heap and quality.
Json json_of(const Run& run);
/// The scene, all runs, the ratios to the first of Bullet, and the verdict on what was asked.
Json json_of(const BenchScene& scene, const std::vector<Run>& runs);

/// An entry of a list of verdicts: what was found is at most, or at least, what it must be.
Json at_most(const char* what, double found, double must);
Json at_least(const char* what, double found, double must);

double mean(const std::vector<double>& values);
/// The value below which `fraction` of the samples lie; 0 for none.
double percentile(std::vector<double> samples, double fraction);

} // namespace lockstone::bench
