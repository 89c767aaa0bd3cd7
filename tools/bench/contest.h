// Runs one scene in several engines. The engines take turns every few ticks, so that other work of the machine affects
// all of them alike.
#pragma once

#include "bench/quality.h"
#include "json/json.h"

namespace lockstone::bench {

using Json = json::Value;

/// The results of one contestant in one scene.
struct Run {
    engines::Contestant who;
    /// The least time of each tick over all runs: every run does the same work, only the noise differs.
    std::vector<double> tick_us = {};
    double heap_mb = 0; ///< that the engine has allocated at the end
    Quality quality = {};
    double joint_worst_mm = 0; ///< the widest joint in any tick
    double figure = 0;         ///< BenchScene::figure at the end; 0: the scene has none
    std::size_t contacts = 0;  ///< contact points in the last tick; Lockstone only
    std::size_t near_most = 0; ///< contact points that do not touch, the most in any tick; Lockstone only
    std::uint64_t dropped = 0; ///< contacts that exceeded the capacity; Lockstone only
};

struct ContestPlan {
    int ticks = 0; ///< timed ticks; 0: as many as the scene names
    int runs = 1;
    bool is_judged = true; ///< quality is measured
};

/// Bullet with its default settings. `iterations`: 0 means the default.
engines::Contestant bullet_as_it_comes(const std::string& name, int iterations = 0);
/// Every engine of this build, with its default settings.
std::vector<engines::Contestant> default_contestants();
std::vector<Run> contest(const BenchScene& scene, const std::vector<engines::Contestant>& who,
                         const ContestPlan& plan);

/// Runs the timed part of a tick once. Returns the processor time of this thread [us].
double timed_act(const BenchScene& scene, engines::Engine& engine, int tick);

/// Mean, median and 99th percentile of a run [ms], its heap and its quality.
Json json_of(const Run& run);
/// The scene, all runs, the ratios to the first run of Bullet, and the verdicts on the scene's bounds.
Json json_of(const BenchScene& scene, const std::vector<Run>& runs);

/// An entry in a list of verdicts: the measured figure is at most, or at least, its bound.
Json at_most(const char* what, double found, double must);
Json at_least(const char* what, double found, double must);

double mean(const std::vector<double>& values);
/// The value below which `fraction` of the samples lie; 0 without samples.
double percentile(std::vector<double> samples, double fraction);

} // namespace lockstone::bench
