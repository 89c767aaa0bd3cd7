// The rows of the speed table: scenes and queries that S1 to S6 do not cover. The bound of each row was fixed before
// the engine was tuned for it. tools/bench/README.md describes each row and the derivation of its bound.
#pragma once

#include "bench/scenes.h"
#include "engines/pieces.h"

#include <span>

namespace lockstone::bench::rows {

/// All rows, in the order of the table.
std::vector<Maker> makers();
/// Adds the bounds from the table in bounds.cpp to a scene; returns a scene without an entry as it is.
BenchScene bounded(BenchScene scene);

// The rows of each file.
std::span<const Maker> swept_rows();
std::span<const Maker> joined_rows();
std::span<const Maker> stacked_rows();
std::span<const Maker> played_rows();
std::span<const Maker> created_rows();
std::span<const Maker> asked_rows();

// These names of the adapters hide the equal names of the namespace lockstone.
using engines::about;
using engines::Body;
using engines::box;
using engines::capsule;
using engines::cylinder;
using engines::Engine;
using engines::Joint;
using engines::Random;
using engines::Scene;
using engines::Shape;
using engines::solid;
using engines::sphere;
using engines::Turn;
using engines::V3;

/// A row with its name. It runs in Lockstone and Bullet only, and its quality is measured after the timed ticks.
inline BenchScene begin_row(const char* name, std::string about, int ticks, int counted_from) {
    BenchScene made{.name = name, .about = std::move(about)};
    made.ticks = made.judged_after = ticks, made.counted_from = counted_from;
    made.against_ode = false;
    made.target.p99_per_mean = 0;
    return made;
}

/// The i-th place of a square grid of `count` places around the origin [m].
inline V3 place_on_grid(int i, int count, double step, double height) {
    const int side = static_cast<int>(std::ceil(std::sqrt(count)));
    const double middle = 0.5 * (side - 1);
    return {step * (i % side - middle), height, step * (i / side - middle)};
}

} // namespace lockstone::bench::rows
