#include "hud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace lockstone::demo {
namespace {

constexpr float title_height = 24;
const float line_height = TextLine{}.height;

glm::vec4 player_ink(std::uint32_t player) {
    const std::uint32_t rgb = look_of(user_key_of(Role::player, player)).colour;
    const glm::vec3 colour = glm::vec3((rgb >> 16) & 0xffu, (rgb >> 8) & 0xffu, rgb & 0xffu) / 255.0f;
    return {glm::mix(colour, glm::vec3(1), 0.35f), 1};
}

} // namespace

// ---- panels -----------------------------------------------------------------------------------------------

void TextPanel::add(const std::string& text, const glm::vec4& colour, float height) {
    lines_.push_back(
        {.text = text, .position = {margin, margin + height_}, .colour = colour, .height = height});
    width_ = std::max(width_, static_cast<float>(letters(text)) * std::ceil(cell_.x * height / line_height));
    height_ += height + 1;
}

void TextPanel::title(const std::string& text, const glm::vec4& colour) {
    add(text, colour, title_height);
    height_ += 4;
}

void TextPanel::line(const std::string& text, const glm::vec4& colour) { add(text, colour, line_height); }

void TextPanel::draw(Frame& frame) const {
    frame.rects.push_back({.position = corner_, .size = size(), .colour = ink::shade});
    for (TextLine line : lines_) {
        line.position += corner_;
        frame.text.push_back(std::move(line));
    }
}

// ---- words ------------------------------------------------------------------------------------------------

std::string format_hash(std::uint64_t hash) {
    std::array<char, 32> text{};
    const auto part = [&](int shift) { return static_cast<unsigned>((hash >> shift) & 0xffffu); };
    std::snprintf(text.data(), text.size(), "%04x %04x %04x %04x", part(48), part(32), part(16), part(0));
    return text.data();
}

std::string format_number(double value, int decimals) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
    return text.data();
}

std::string format_time(std::uint64_t ticks, std::uint32_t rate) {
    const double seconds = static_cast<double>(ticks) / rate;
    std::array<char, 64> text{};
    const auto minutes = static_cast<int>(seconds / 60);
    std::snprintf(text.data(), text.size(), "%02d:%05.2f", minutes, seconds - 60 * minutes);
    return text.data();
}

std::string format_bytes(std::uint64_t bytes) {
    const auto count = static_cast<double>(bytes);
    if (count < 1000) return std::to_string(bytes) + " B";
    return count < 1e6 ? format_number(count / 1e3, 1) + " kB" : format_number(count / 1e6, 1) + " MB";
}

std::string format_speed(const StepClock& clock) {
    if (clock.paused()) return "paused";
    const float speed = clock.speed();
    return speed >= 1 ? "\u00d7 " + format_number(speed, 0) : "\u00d7 1/" + format_number(1 / speed, 0);
}

// ---- what every page has ----------------------------------------------------------------------------------

void control_stage(Stage& stage, const Input& input) {
    const auto toggle = [&](Key key, bool& flag) {
        if (input.pressed(key)) flag = !flag;
    };
    toggle(Key::f1, stage.view.help);
    toggle(Key::f2, stage.view.wireframe);
    toggle(Key::f3, stage.view.contacts);
    toggle(Key::f4, stage.view.bounds);
    toggle(Key::f5, stage.view.crates);
    toggle(Key::f6, stage.view.overlay);
    toggle(Key::f7, stage.view.joints);
    if (input.pressed(Key::p)) stage.clock.set_paused(!stage.clock.paused());
    if (input.pressed(Key::period)) stage.clock.single_step();
    if (input.pressed(Key::left_bracket)) stage.clock.slower();
    if (input.pressed(Key::right_bracket)) stage.clock.faster();
}

void draw_help(Frame& frame, const Moment& moment, const ViewOptions& view, const std::string& page_keys) {
    if (!view.help) return;
    TextPanel panel(moment, {0, 0});
    panel.title("keys");
    std::string rest =
        page_keys + "\n"
                    "P pause   . one tick   [ ] slower, faster\n"
                    "F2 wireframe   F3 contacts   F4 bounds   F5 crates   F6 text   F7 joints   F12 picture\n"
                    "right drag orbit   wheel zoom   middle drag pan   shift Home all\n"
                    "C follow or fly freely (WASD, Q, E)   Tab next player\n"
                    "F1 closes this   Escape ends";
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        panel.line(rest.substr(0, end), ink::white);
        rest.erase(0, end + 1);
    }
    panel.move_to(0.5f * (viewport_size(frame, moment) - panel.size()));
    panel.draw(frame);
}

void draw_match(Frame& frame, const Moment& moment, const SceneView& view, std::uint32_t players) {
    const auto& match = view.match();
    if (!match) return;
    const auto shown =
        std::min<std::size_t>(players == 0 ? match->scores.size() : players, match->scores.size());
    const glm::vec2 size = viewport_size(frame, moment);
    // [design px]: half of a small window has no space beside the panels.
    constexpr float narrow = 620, below_panels = 252;
    TextPanel panel(moment, {size.x - 12, size.x < narrow ? below_panels : 12});
    panel.title("score");
    for (std::uint32_t p = 0; p < shown; ++p) {
        std::string score = std::to_string(match->scores[p]);
        score.insert(0, score.size() < 4 ? 4 - score.size() : 0, ' ');
        panel.line("player " + std::to_string(p + 1) + score + (match->it == p ? "  it" : "    "),
                   player_ink(p));
    }
    panel.align_right();
    panel.draw(frame);
    for (std::uint32_t p = 0; p < shown; ++p) {
        const auto position = view.player_position(p, moment.alpha);
        if (!position) continue;
        // The player who must tag another has a cone overhead.
        const float above = match->it == p ? 1.75f : 0.95f;
        const auto pixel = frame.camera.project(*position + glm::vec3(0, above, 0), size);
        if (!pixel) continue;
        const std::string name = match->it == p ? "it" : std::string("P").append(std::to_string(p + 1));
        frame.text.push_back({.text = name,
                              .position = *pixel - glm::vec2(0.5f * moment.cell.x * 2, moment.cell.y),
                              .colour = player_ink(p),
                              .yields = true});
    }
}

glm::vec2 viewport_size(const Frame& frame, const Moment& moment) {
    return moment.size * glm::vec2(frame.viewport.z, frame.viewport.w);
}

} // namespace lockstone::demo
