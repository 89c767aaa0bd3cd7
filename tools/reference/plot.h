// gnuplot scripts that draw a comparison as SVG.
#pragma once

#include "reference/drift.h"

namespace reference {

struct Drawn {
    std::string scene;
    double tick_rate = 60;
    std::span<const Sample> samples; ///< of all ticks; empty: the plot shows only the drift
    std::span<const DriftLine> drifts;
};
/// Separation, energy, momentum, penetration, cost and drift over time. Without samples it draws the drift alone,
/// larger.
std::string plot_script(const Drawn& drawn, const std::string& file);

} // namespace reference
