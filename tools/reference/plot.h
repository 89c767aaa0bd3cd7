// Pictures of a comparison, for gnuplot to draw as SVG.
#pragma once

#include "reference/drift.h"

namespace reference {

struct Drawn {
    std::string scene;
    double tick_rate = 60;
    std::span<const Sample> samples; ///< of all ticks; empty: only the drift is drawn
    std::span<const DriftLine> drifts;
};
/// Separation, energy, momentum, penetration, cost and drift over time; without samples the drift alone, larger.
std::string plot_script(const Drawn& drawn, const std::string& file);

} // namespace reference
