#pragma once
/// Text and panels over the picture.

#include "pages/page.h"
#include "scene_view.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

namespace lockstone::demo {

namespace ink {
constexpr glm::vec4 white(0.96f, 0.97f, 0.98f, 1), grey(0.74f, 0.78f, 0.82f, 1),
    green(0.55f, 0.92f, 0.55f, 1), amber(1.0f, 0.80f, 0.35f, 1), red(1.0f, 0.45f, 0.40f, 1),
    blue(0.50f, 0.78f, 1.0f, 1), shade(0.06f, 0.08f, 0.11f, 0.66f);
} // namespace ink

/// Lines of text on a dark ground, as wide as the longest line. It grows downwards from its upper left corner.
class TextPanel {
  public:
    TextPanel(const Moment& moment, const glm::vec2& corner) : cell_(moment.cell), corner_(corner) {}
    void title(const std::string& text, const glm::vec4& colour = ink::white);
    void line(const std::string& text, const glm::vec4& colour = ink::grey);
    glm::vec2 size() const { return {width_ + 2 * margin, height_ + 2 * margin}; }
    void move_to(const glm::vec2& corner) { corner_ = corner; }
    /// Moves the panel so that its right or lower edge lies at its corner.
    void align_right() { corner_.x -= size().x; }
    void align_bottom() { corner_.y -= size().y; }
    void draw(Frame& frame) const;

  private:
    static constexpr float margin = 10; ///< [design px]
    void add(const std::string& text, const glm::vec4& colour, float height);
    glm::vec2 cell_, corner_;
    float width_ = 0, height_ = 0;
    std::vector<TextLine> lines_; ///< positions within the panel
};

/// The number of UTF-8 characters of a text, not of bytes.
inline std::size_t letters(const std::string& text) {
    return static_cast<std::size_t>(std::count_if(
        text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; }));
}

std::string format_hash(std::uint64_t hash);                      ///< "9f3c 21d0 77ab e415"
std::string format_time(std::uint64_t ticks, std::uint32_t rate); ///< "00:20.07"
std::string format_bytes(std::uint64_t bytes);                    ///< "12.3 kB"
std::string format_number(double value, int decimals);
/// For example "× 0.25" or "paused".
std::string format_speed(const StepClock& clock);

/// Handles the keys of every page: wireframe, contacts, bounds, crates, overlay, joints, help, pause, step, speed.
void control_stage(Stage& stage, const Input& input);

/// Draws the list of keys, if it is switched on. `page_keys`: keys of the page, one per line.
void draw_help(Frame& frame, const Moment& moment, const ViewOptions& view, const std::string& page_keys);

/// Draws the scores of the first `players` of a match (0: of all) at the upper right, and names above the players.
void draw_match(Frame& frame, const Moment& moment, const SceneView& view, std::uint32_t players);

/// The size of a frame's viewport [design px].
glm::vec2 viewport_size(const Frame& frame, const Moment& moment);

} // namespace lockstone::demo
