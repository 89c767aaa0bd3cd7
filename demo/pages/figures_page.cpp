#include "figures_page.h"

#include "render/camera/camera_control.h"
#include "view/hud.h"
#include "view/to_glm.h"

#include <algorithm>
#include <cmath>

namespace lockstone::demo {
namespace {

constexpr float pitch = -0.16f; ///< low, so that heights above the ground are visible [rad]
// Margins of the picture at the sides and at the top [design px].
constexpr float edge = 24, caption = 64;
constexpr std::uint64_t trail_ticks = 24; ///< at most

} // namespace

// ---- which ticks ------------------------------------------------------------------------------------------

Result<std::unique_ptr<Page>> FiguresPage::open(const Options& options, Stage& stage) {
    Result<RecordedGame> recorded = open_recording(options.source);
    if (!recorded) return recorded.error();
    std::unique_ptr<FiguresPage> page(new FiguresPage(std::move(*recorded), stage));
    const Result<FigureTicks> ticks = page->find_ticks();
    if (!ticks) return Error{options.source + ": " + ticks.error().message};
    page->choose_figures(*ticks);
    if (const Status status = page->find_places(ticks->blocks); !status) return status.error();
    if (const Status status = page->find_corners(); !status) return status.error();
    return std::unique_ptr<Page>(std::move(page));
}

/// Plays the recording to find the ticks. An error if a tick differs from the recording, because the pictures would
/// show another run.
Result<FigureTicks> FiguresPage::find_ticks() {
    Result<replay::Player> player = replay::Player::open(recorded_.recording, recorded_.game.get());
    if (!player) return player.error();
    player_ = std::move(*player);
    Result<FigureFinder> finder = FigureFinder::create(player_->world());
    if (!finder) return finder.error();
    while (!finder->done() && !player_->at_end()) {
        if (const Status status = player_->step(); !status) return status.error();
        if (!player_->agrees())
            return Error{"tick " + std::to_string(player_->time() - 1) + " is not bit-exact"};
        finder->after_tick(player_->world());
    }
    return finder->ticks();
}

void FiguresPage::choose_figures(const FigureTicks& ticks) {
    figures_ = {{{ticks.in_the_air, "both blocks in the air", 0},
                 {ticks.meeting, "1 bounces off the ground, 2 hits it", ticks.in_the_air},
                 {ticks.apart, "they fly apart", ticks.meeting},
                 {ticks.landing, "both meet the ground again", ticks.apart}}};
    for (Figure& figure : figures_)
        figure.trail_from = std::max(figure.trail_from, figure.time - std::min(figure.time, trail_ticks));
}

Status FiguresPage::find_places(const std::array<BodyId, 2>& blocks) {
    for (std::uint64_t time = 0; time <= figures_.back().time; ++time) {
        if (const Status status = player_->seek(time); !status) return status;
        const World& world = player_->world();
        places_.push_back({to_glm(to_float(world.center_of_mass(blocks[0]))),
                           to_glm(to_float(world.center_of_mass(blocks[1])))});
    }
    return {};
}

Status FiguresPage::go_to(std::size_t figure) {
    if (const Status status = player_->seek(figures_[figure].time); !status) return status;
    view_.reset(player_->world());
    return {};
}

/// Collects the corners of all four figures. Goes from the last figure to the first, so that the player ends at the
/// first one.
Status FiguresPage::find_corners() {
    for (std::size_t i = figures_.size(); i-- > 0;) {
        if (const Status status = go_to(i); !status) return status;
        const Bounds box = view_.bounds();
        for (const float x : {box.min.x, box.max.x})
            for (const float y : {0.0f, box.max.y})
                for (const float z : {box.min.z, box.max.z}) corners_.emplace_back(x, y, z);
    }
    return {};
}

/// One camera for all four pictures, so that they can be compared. It is as near as possible and looks at right angles
/// to the direction in which the blocks fly apart.
void FiguresPage::fit_camera(const glm::vec2& size) {
    if (size == fitted_size_) return; // keep the camera if it was moved by hand
    fitted_size_ = size;
    Bounds all;
    for (const glm::vec3& corner : corners_) all.add(corner);
    const Places& apart = places_[figures_[2].time];
    const glm::vec3 way = apart[1] - apart[0];
    const float yaw = std::atan2(way.x < 0 ? way.z : -way.z, std::abs(way.x));
    camera_ = Camera(all.centre(), 4 * all.radius(), yaw, pitch);
    const auto fits = [&] {
        return std::all_of(corners_.begin(), corners_.end(), [&](const glm::vec3& corner) {
            const auto pixel = camera_.project(corner, size);
            return pixel && glm::all(glm::greaterThan(*pixel, glm::vec2(edge, caption))) &&
                   glm::all(glm::lessThan(*pixel, size - edge));
        });
    };
    for (int step = 0; step < 200 && fits(); ++step) camera_.zoom(0.98f);
}

Status FiguresPage::tick() {
    if (finished()) return {};
    if (const Status status = go_to(shown_); !status) return status;
    ++shown_;
    return {};
}

// ---- pictures ---------------------------------------------------------------------------------------------

void FiguresPage::control(const Input& input, const Moment& moment) {
    drive_camera(camera_, input, moment.size.y * moment.pixel_scale, moment.seconds);
}

std::vector<Frame> FiguresPage::draw(const Moment& moment) {
    fit_camera(moment.size);
    Frame frame;
    frame.camera = camera_;
    frame.wireframe = stage_.view.wireframe;
    view_.draw(frame, 1, stage_, std::nullopt);
    if (stage_.view.overlay && shown_ != 0) {
        draw_trails(frame);
        draw_numbers(frame, moment);
        draw_caption(frame, moment);
    }
    draw_help(frame, moment, stage_.view, "");
    return {std::move(frame)};
}

/// The recent path of each block; older parts are thinner.
void FiguresPage::draw_trails(Frame& frame) const {
    const Figure& figure = figures_[shown_ - 1];
    for (std::uint64_t t = figure.trail_from; t < figure.time; ++t)
        for (std::size_t i = 0; i < places_[t].size(); ++i) {
            const auto age = static_cast<float>(figure.time - t) / static_cast<float>(trail_ticks + 1);
            frame.lines.push_back({.from = places_[t][i],
                                   .to = places_[t + 1][i],
                                   .colour = {1.0f, 0.93f, 0.55f},
                                   .width = 4.0f * (1 - age)});
        }
}

/// Number 1 is the block that touches the ground first.
void FiguresPage::draw_numbers(Frame& frame, const Moment& moment) const {
    const Places& now = places_[figures_[shown_ - 1].time];
    for (std::size_t i = 0; i < now.size(); ++i) {
        const auto pixel = camera_.project(now[i], moment.size);
        if (!pixel) continue;
        constexpr float height = 26;
        const glm::vec2 half = 0.5f * height / moment.cell.y * moment.cell;
        frame.text.push_back(
            {.text = i == 0 ? "1" : "2", .position = *pixel - half, .colour = ink::white, .height = height});
    }
}

void FiguresPage::draw_caption(Frame& frame, const Moment& moment) const {
    const Figure& figure = figures_[shown_ - 1];
    TextPanel panel(moment, {12, 12});
    panel.line("figure " + std::to_string(shown_) + "   tick " + std::to_string(figure.time), ink::white);
    panel.line(figure.caption);
    panel.draw(frame);
}

Verdict FiguresPage::verdict() const {
    std::string sentence;
    for (std::size_t i = 0; i < figures_.size(); ++i)
        sentence += "figure " + std::to_string(i + 1) + ": tick " + std::to_string(figures_[i].time) + ", " +
                    figures_[i].caption + "\n";
    return {sentence + "every tick up to them is bit-exact"};
}

} // namespace lockstone::demo
