#include "chart.h"

#include "hud.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace lockstone::demo {
namespace {

constexpr float margin = 10, title_height = 26, label_height = 15, gutter = 64, stroke = 2; ///< [design px]

/// The area of the curves.
struct Area {
    glm::vec2 corner, size;
};

double greatest_of(const Chart& chart) {
    double greatest = 0;
    for (const Curve& curve : chart.curves)
        for (const double value : curve.values)
            if (std::isfinite(value)) greatest = std::max(greatest, value);
    return round_up(greatest);
}

/// Writes text that ends at a corner; `share` of its height lies above the corner.
void write_label(Frame& frame, const Moment& moment, const std::string& text, const glm::vec2& end,
                 float share) {
    const float width = static_cast<float>(letters(text)) * moment.cell.x * label_height / TextLine{}.height;
    frame.text.push_back({.text = text,
                          .position = end - glm::vec2(width, share * label_height),
                          .colour = ink::grey,
                          .height = label_height});
}

void draw_marks(Frame& frame, const Moment& moment, const Chart& chart, const Area& area, double greatest) {
    std::vector<ChartMark> marks = chart.marks;
    if (chart.scale == ChartScale::from_zero)
        marks = {{0, "0"}, {greatest, format_unit(greatest, chart.unit)}};
    for (const ChartMark& mark : marks) {
        const float y = area.corner.y + area.size.y * (1 - height_of(mark.value, chart, greatest));
        frame.rects.push_back(
            {.position = {area.corner.x, y}, .size = {area.size.x, 1}, .colour = {1, 1, 1, 0.22f}});
        write_label(frame, moment, mark.text, {area.corner.x - 6, y}, 0.5f);
    }
}

/// A rectangle for each column of pixels, from the least to the greatest value of its ticks, extended to the rectangle
/// before.
void draw_curve(Frame& frame, const Curve& curve, const Chart& chart, const Area& area, double greatest) {
    const auto columns = static_cast<std::size_t>(std::max(area.size.x, 1.0f));
    const std::size_t ticks = std::max<std::size_t>(chart.ticks, 1);
    float last = -1;
    for (std::size_t column = 0; column < columns; ++column) {
        const std::size_t first = column * ticks / columns;
        if (first >= curve.values.size()) return;
        const std::size_t end = std::clamp((column + 1) * ticks / columns, first + 1, curve.values.size());
        float low = 1, high = 0, now = 0;
        for (std::size_t i = first; i < end; ++i) {
            now = height_of(curve.values[i], chart, greatest);
            low = std::min(low, now), high = std::max(high, now);
        }
        if (last >= 0) low = std::min(low, last), high = std::max(high, last);
        last = now;
        const float top = area.corner.y + (area.size.y - stroke) * (1 - high);
        frame.rects.push_back({.position = {area.corner.x + static_cast<float>(column), top},
                               .size = {1, (area.size.y - stroke) * (high - low) + stroke},
                               .colour = curve.colour});
    }
}

} // namespace

std::string format_unit(double value, const std::string& unit) {
    constexpr const char* prefixes[] = {"", "k", "M", "G", "T"};
    std::size_t power = 0;
    while (std::abs(value) >= 1000 && power + 1 < std::size(prefixes)) value /= 1000, ++power;
    char text[48];
    std::snprintf(text, sizeof text, "%.3g %s%s", value, prefixes[power], unit.c_str());
    return text;
}

double round_up(double value) {
    if (!(value > 0)) return 1;
    const double power = std::pow(10, std::floor(std::log10(value)));
    for (const double step : {1.0, 2.0, 5.0})
        if (value <= step * power) return step * power;
    return 10 * power;
}

float height_of(double value, const Chart& chart, double greatest) {
    if (!std::isfinite(value)) return 1;
    if (chart.scale == ChartScale::from_zero)
        return static_cast<float>(std::clamp(value / greatest, 0.0, 1.0));
    const double share = std::log(std::max(value, chart.low) / chart.low) / std::log(chart.high / chart.low);
    return static_cast<float>(std::clamp(share, 0.0, 1.0));
}

void draw_chart(Frame& frame, const Moment& moment, const Chart& chart, const glm::vec2& corner,
                const glm::vec2& size) {
    frame.rects.push_back({.position = corner, .size = size, .colour = ink::shade});
    glm::vec2 pen = corner + glm::vec2(margin, 6);
    const auto write = [&](const std::string& text, const glm::vec4& colour) {
        frame.text.push_back({.text = text, .position = pen, .colour = colour});
        pen.x += static_cast<float>(text.size() + 2) * moment.cell.x;
    };
    write(chart.title, ink::white);
    for (const Curve& curve : chart.curves)
        if (!curve.name.empty()) write(curve.name, curve.colour);
    const glm::vec2 above(gutter, title_height + margin);
    const Area area{corner + above, size - above - glm::vec2(margin, label_height + 4)};
    const double greatest = greatest_of(chart);
    draw_marks(frame, moment, chart, area, greatest);
    const glm::vec2 below = area.corner + area.size + glm::vec2(0, label_height + 2);
    write_label(frame, moment, std::to_string(chart.ticks - 1) + " ticks", below, 1);
    for (const Curve& curve : chart.curves) draw_curve(frame, curve, chart, area, greatest);
}

} // namespace lockstone::demo
