#pragma once
/// Curves over time, drawn over the picture from rectangles.

#include "pages/page.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace lockstone::demo {

struct Curve {
    std::string name;
    glm::vec4 colour{1};
    std::span<const double> values; ///< one a tick, from the first
};

enum class ChartScale : std::uint8_t {
    from_zero, ///< linear, from 0 to the greatest value so far
    powers,    ///< logarithmic, between the chart's bounds
};

/// What stands at a line across the chart.
struct ChartMark {
    double value;
    std::string text;
};

struct Chart {
    std::string title;
    ChartScale scale = ChartScale::from_zero;
    double low = 0, high = 0;       ///< bounds of `powers`; values beyond them lie on the edge
    std::vector<ChartMark> marks{}; ///< of `powers`; `from_zero` marks its ends itself
    std::string unit{};             ///< of what `from_zero` marks
    std::uint64_t ticks = 1;        ///< the length of the time axis
    std::vector<Curve> curves{};
};

/// `corner`, `size`: of the whole chart with its title [design px].
void draw_chart(Frame& frame, const Moment& moment, const Chart& chart, const glm::vec2& corner,
                const glm::vec2& size);

/// A number of up to four digits with a prefix of its unit: "3.19 MJ", "20 J".
std::string format_unit(double value, const std::string& unit);

/// The least of 1, 2, 5, 10, 20, ... times a power of ten that is not below `value`; 1 for what is not above 0.
double round_up(double value);

/// Where a value lies on the chart's axis: 0 the lower edge, 1 the upper one. What is no number lies at the upper edge.
float height_of(double value, const Chart& chart, double greatest);

} // namespace lockstone::demo
