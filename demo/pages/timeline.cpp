#include "timeline.h"

#include "view/hud.h"

#include <algorithm>
#include <cmath>

namespace lockstone::demo {
namespace {

constexpr float side_margin = 24, bar_bottom = 30, bar_height = 10, grab_margin = 12; ///< [design px]

struct Bar {
    float left, width, top;
};
Bar bar_of(const Moment& moment) {
    return {side_margin, std::max(moment.size.x - 2 * side_margin, 1.0f), moment.size.y - bar_bottom};
}

float x_of(const Bar& bar, const TimelineContent& content, std::uint64_t time) {
    const auto length = static_cast<float>(std::max<std::uint64_t>(content.end - content.start, 1));
    return bar.left + bar.width * static_cast<float>(time - content.start) / length;
}

/// The worst check of a range of ticks, so that one wrong tick among thousands is visible.
TickCheck worst(std::span<const TickCheck> checks) {
    if (std::find(checks.begin(), checks.end(), TickCheck::differs) != checks.end())
        return TickCheck::differs;
    const bool all =
        std::all_of(checks.begin(), checks.end(), [](TickCheck c) { return c == TickCheck::bit_exact; });
    return all ? TickCheck::bit_exact : TickCheck::unknown;
}

} // namespace

std::optional<std::uint64_t> Timeline::drag(const Input& input, const Moment& moment,
                                            const TimelineContent& content) {
    const Bar bar = bar_of(moment);
    const glm::vec2 cursor = input.cursor / moment.pixel_scale;
    if (input.pressed(MouseButton::left))
        dragging_ = cursor.y > bar.top - grab_margin && cursor.y < bar.top + bar_height + grab_margin;
    if (!input.down(MouseButton::left)) dragging_ = false;
    if (!dragging_) return std::nullopt;
    const float share = std::clamp((cursor.x - bar.left) / bar.width, 0.0f, 1.0f);
    return content.start +
           static_cast<std::uint64_t>(std::lround(share * static_cast<float>(content.end - content.start)));
}

/// Draws one rectangle per run of equal pixels.
void Timeline::draw_checks(Frame& frame, const Moment& moment, const TimelineContent& content) {
    const Bar bar = bar_of(moment);
    const auto columns = static_cast<std::size_t>(bar.width);
    const std::size_t ticks = content.checks.size();
    const auto check_of = [&](std::size_t column) {
        const std::size_t first = column * ticks / columns,
                          end = std::max((column + 1) * ticks / columns, first + 1);
        return worst(content.checks.subspan(first, end - first));
    };
    for (std::size_t column = 0; ticks != 0 && column < columns;) {
        const TickCheck check = check_of(column);
        std::size_t end = column + 1;
        while (end < columns && check_of(end) == check) ++end;
        if (check != TickCheck::unknown)
            frame.rects.push_back({.position = {bar.left + static_cast<float>(column), bar.top},
                                   .size = {static_cast<float>(end - column), bar_height},
                                   .colour = check == TickCheck::bit_exact
                                                 ? glm::vec4(0.30f, 0.72f, 0.38f, 0.95f)
                                                 : glm::vec4(1.0f, 0.25f, 0.2f, 1)});
        column = end;
    }
}

void Timeline::draw(Frame& frame, const Moment& moment, const TimelineContent& content) const {
    const Bar bar = bar_of(moment);
    frame.rects.push_back(
        {.position = {0, moment.size.y - height}, .size = {moment.size.x, height}, .colour = ink::shade});
    frame.rects.push_back(
        {.position = {bar.left, bar.top}, .size = {bar.width, bar_height}, .colour = {1, 1, 1, 0.16f}});
    draw_checks(frame, moment, content);
    for (const std::uint64_t keyframe : content.keyframes)
        frame.rects.push_back({.position = {x_of(bar, content, keyframe) - 1, bar.top + bar_height + 3},
                               .size = {2, 6},
                               .colour = {0.50f, 0.78f, 1.0f, 0.9f}});
    frame.rects.push_back({.position = {x_of(bar, content, content.now) - 2, bar.top - 5},
                           .size = {4, bar_height + 10},
                           .colour = ink::white});
    const std::string text = format_time(content.now - content.start, content.tick_rate) + " of " +
                             format_time(content.end - content.start, content.tick_rate) + "   tick " +
                             std::to_string(content.now) + " of " + std::to_string(content.end) + "   " +
                             std::to_string(content.keyframes.size()) +
                             (content.keyframes.size() == 1 ? " keyframe" : " keyframes");
    frame.text.push_back(
        {.text = text, .position = {bar.left, moment.size.y - height + 5}, .colour = ink::white});
}

} // namespace lockstone::demo
