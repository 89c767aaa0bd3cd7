#include "frame.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lockstone::demo {

bool touches(const TextLine& line, const glm::vec2& cell, std::span<const Rect> rects) {
    const auto letters = std::ranges::count_if(
        line.text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; });
    const glm::vec2 end = line.position + cell * glm::vec2(static_cast<float>(letters), 1);
    return std::ranges::any_of(rects, [&](const Rect& rect) {
        return line.position.x < rect.position.x + rect.size.x && rect.position.x < end.x &&
               line.position.y < rect.position.y + rect.size.y && rect.position.y < end.y;
    });
}

glm::vec3 palette_colour(std::uint32_t index) {
    // Colours chosen by hand, with another lightness on each lap: computed hues of equal saturation look unnatural.
    constexpr std::array<glm::vec3, 9> colours{{
        {0.88f, 0.42f, 0.30f}, // brick
        {0.27f, 0.55f, 0.74f}, // steel blue
        {0.93f, 0.71f, 0.31f}, // amber
        {0.40f, 0.64f, 0.45f}, // moss
        {0.60f, 0.46f, 0.70f}, // plum
        {0.88f, 0.83f, 0.72f}, // sand
        {0.24f, 0.63f, 0.62f}, // teal
        {0.82f, 0.50f, 0.58f}, // rose
        {0.45f, 0.50f, 0.58f}, // slate
    }};
    const auto lap = static_cast<float>(index / colours.size() % 3);
    return glm::clamp(colours[index % colours.size()] * (1.0f - 0.09f * lap), glm::vec3(0), glm::vec3(1));
}

} // namespace lockstone::demo
