// The rows of the table of speed: scenes and questions that S1 to S6 do not have, each with a bound that was written before it was tuned.
// README.md beside the other scenes' says what is in each and how its bound is derived.
#pragma once

#include "bench/scenes.h"
#include "engines/pieces.h"

#include <span>

namespace lockstone::bench::rows {

/// All rows, in the order of the table.
std::vector<Maker> makers();
/// The scene with what it must cost, from the table of bounds.cpp; without an entry there: as it is.
BenchScene bounded(BenchScene scene);

// By files.
std::span<const Maker> swept_rows();
std::span<const Maker> joined_rows();
std::span<const Maker> stacked_rows();
std::span<const Maker> played_rows();
std::span<const Maker> created_rows();
std::span<const Maker> asked_rows();

// The engines' names hide those of lockstone.
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

/// A row with its name; it runs beside Bullet alone, and is judged after its timed ticks.
inline BenchScene begin_row(const char* name, std::string about, int ticks, int counted_from) {
    BenchScene made{.name = name, .about = std::move(about)};
    made.ticks = made.judged_after = ticks, made.counted_from = counted_from;
    made.against_ode = false;
    made.target.p99_per_mean = 0;
    return made;
}

/// The i-th place of a square grid of `count` places around the origin, at a height.
inline V3 place_on_grid(int i, int count, double step, double height) {
    const int side = static_cast<int>(std::ceil(std::sqrt(count)));
    const double middle = 0.5 * (side - 1);
    return {step * (i % side - middle), height, step * (i / side - middle)};
}

} // namespace lockstone::bench::rows
