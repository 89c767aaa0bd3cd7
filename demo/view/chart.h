#pragma once
/// Draws curves over time from rectangles.

#include "pages/page.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace lockstone::demo {

struct Curve {
    std::string name;
    glm::vec4 colour{1};
    std::span<const double> values; ///< one per tick, from the first tick
};

enum class ChartScale : std::uint8_t {
    from_zero, ///< linear, from 0 to the greatest value so far
    powers,    ///< logarithmic, between the chart's bounds
};

/// The label of a horizontal line across the chart.
struct ChartMark {
    double value;
    std::string text;
};

struct Chart {
    std::string title;
    ChartScale scale = ChartScale::from_zero;
    double low = 0, high = 0;       ///< bounds of `powers`; values beyond them are drawn at the edge
    std::vector<ChartMark> marks{}; ///< of `powers`; `from_zero` makes its own marks
    std::string unit{};             ///< unit of the marks of `from_zero`
    std::uint64_t ticks = 1;        ///< length of the time axis
    std::vector<Curve> curves{};
};

/// Draws a chart. `corner`, `size`: of the whole chart with its title [design px].
void draw_chart(Frame& frame, const Moment& moment, const Chart& chart, const glm::vec2& corner,
                const glm::vec2& size);

/// A number of up to four digits with a prefix of its unit: "3.19 MJ", "20 J".
std::string format_unit(double value, const std::string& unit);

/// The least of 1, 2, 5, 10, 20, ... times a power of ten that is not below `value`; 1 if `value` is not above 0.
double round_up(double value);

/// The position of a value on the chart's axis: 0 the lower edge, 1 the upper edge. Not-a-number is at the upper edge.
float height_of(double value, const Chart& chart, double greatest);

} // namespace lockstone::demo
