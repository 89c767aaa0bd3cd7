#include "compare_page.h"

#include "camera_rig.h"
#include "reference/scenes.h"
#include "reference/side_by_side.h"
#include "view/chart.h"
#include "view/hud.h"
#include "view/outlines.h"

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace lockstone::demo {
namespace {

constexpr float reach_min = 6;       ///< [m]
constexpr float charts_height = 164; ///< [design px]
/// [m]: the verdict names the first tick at which a body is farther than this from its counterpart.
constexpr double apart = 0.01;
const glm::vec4 ours_ink = ink::blue, thesis_ink(1.0f, 0.55f, 0.15f, 1);

glm::vec3 to_glm(const reference::Vec& v) { return {v.x, v.y, v.z}; }
glm::mat4 to_glm(const reference::Pose& pose) {
    const reference::Turn& q = pose.rotation;
    glm::mat4 out = glm::mat4_cast(glm::quat(static_cast<float>(q.w), static_cast<float>(q.x),
                                             static_cast<float>(q.y), static_cast<float>(q.z)));
    out[3] = glm::vec4(to_glm(pose.position), 1);
    return out;
}

/// A row of the panel: "energy             203 J     464 J".
std::string row(const char* name, double ours, double thesis, const char* unit) {
    char text[128];
    std::snprintf(text, sizeof text, "%-12s%14s%14s", name, format_unit(ours, unit).c_str(),
                  format_unit(thesis, unit).c_str());
    return text;
}
double length(const reference::Vec& v) { return std::hypot(v.x, v.y, v.z); }

/// For example "3.2 mm".
std::string format_length(double metres) {
    if (!std::isfinite(metres)) return "infinitely far";
    if (metres < 1e-3) return format_number(metres * 1e6, 1) + " \u00b5m";
    return metres < 1 ? format_number(metres * 1e3, 1) + " mm" : format_number(metres, 2) + " m";
}

class ComparePage final : public Page {
  public:
    ComparePage(const Options& options, Stage& stage, reference::SideBySide both);

    std::string_view name() const override { return "compare"; }
    std::uint32_t tick_rate() const override { return tick_rate_; }
    std::uint64_t tick_count() const override { return now_.tick; }
    Status tick() override;
    bool finished() const override { return tick_count() >= ticks_; }
    void control(const Input& input, const Moment& moment) override;
    std::vector<Frame> draw(const Moment& moment) override;
    Verdict verdict() const override;

  private:
    struct Cage {
        glm::mat4 previous{1}, current{1};
        std::vector<Edge> edges; ///< in the body's frame
        float radius = 0;        ///< distance of the farthest point from the body's origin [m]
    };
    void measure();
    void read_cages();
    void draw_thesis(Frame& frame, float alpha) const;
    void draw_overlay(Frame& frame, const Moment& moment) const;
    Frame draw_charts(const Moment& moment) const;

    Stage& stage_;
    reference::SideBySide both_;
    std::uint32_t tick_rate_;
    std::uint64_t ticks_;
    reference::Sample now_;
    std::vector<double> energy_ours_, energy_theirs_; ///< by tick; the first entry is the start [J]
    std::vector<double> distance_; ///< by tick: the largest distance between a body and its counterpart [m]
    bool thesis_shown_ = true;
    float reach_ = 0;         ///< the overview ignores outlines farther than this from the start [m]
    glm::vec3 start_{0};      ///< centre of the moving bodies at the start [m]
    std::vector<Cage> cages_; ///< of the thesis' bodies; a cage without edges is not drawn
    SceneView view_;
    CameraRig rig_;
};

Result<reference::SideBySide> start(const Options& options) {
    Result<std::unique_ptr<Game>> game = options.asset_file.empty()
                                             ? reference::make_compare_scene(options.source, options.scene)
                                             : make_game(options);
    if (!game) return game.error();
    const std::string name = (*game)->name();
    Result<reference::SideBySide> both =
        reference::SideBySide::create(std::move(*game), {}, options.scene.seed);
    if (!both) return Error{name + " cannot be compared: " + both.error().message};
    return both;
}

std::uint64_t ticks_of(const Options& options) {
    const reference::CompareScene* scene = reference::find_compare_scene(options.source);
    return options.ticks.value_or(scene != nullptr ? scene->ticks : ticks_default);
}

ComparePage::ComparePage(const Options& options, Stage& stage, reference::SideBySide both)
    : stage_(stage), both_(std::move(both)), tick_rate_(both_.ours().def().tick_rate),
      ticks_(ticks_of(options)) {
    const reference::Engine& thesis = both_.theirs();
    cages_.resize(thesis.bodies().size());
    for (std::size_t i = 0; i < cages_.size(); ++i) {
        if (!thesis.is_dynamic(i)) continue; // all other bodies have equal poses in both engines
        for (const ShapeDef& shape : thesis.shapes(i)) {
            const std::vector<Edge> edges = outline_of(shape, both_.ours().assets());
            cages_[i].edges.insert(cages_[i].edges.end(), edges.begin(), edges.end());
        }
        for (const auto& [from, to] : cages_[i].edges)
            cages_[i].radius = std::max({cages_[i].radius, glm::length(from), glm::length(to)});
    }
    read_cages();
    read_cages(); // twice, so that previous and current poses are equal
    measure();
    view_.reset(both_.ours());
    start_ = view_.bounds().centre();
    reach_ = std::max(2 * view_.bounds().radius(), reach_min);
    rig_.frame_scene(view_.bounds());
}

void ComparePage::measure() {
    now_ = both_.sample();
    energy_ours_.push_back(now_.ours.energy());
    energy_theirs_.push_back(now_.theirs.energy());
    distance_.push_back(now_.separation_max);
}

void ComparePage::read_cages() {
    const std::span<const reference::Body> bodies = both_.theirs().bodies();
    for (std::size_t i = 0; i < cages_.size(); ++i) {
        cages_[i].previous = cages_[i].current;
        cages_[i].current = to_glm(bodies[i].pose);
    }
    Bounds company;
    for (const Cage& cage : cages_) {
        const glm::vec3 middle(cage.current[3]);
        if (cage.edges.empty() || !(glm::distance(middle, start_) < reach_)) continue;
        company.add(middle - cage.radius), company.add(middle + cage.radius);
    }
    view_.set_company(company);
}

Status ComparePage::tick() {
    if (finished()) return {};
    if (const Status status = both_.tick(); !status) return status;
    view_.capture(both_.ours());
    read_cages();
    measure();
    return {};
}

void ComparePage::control(const Input& input, const Moment& moment) {
    if (input.pressed(Key::o)) thesis_shown_ = !thesis_shown_;
    rig_.control(input, view_, moment.size.y * moment.pixel_scale, moment.seconds, false);
}

// ---- drawing ----------------------------------------------------------------------------------------------

std::vector<Frame> ComparePage::draw(const Moment& moment) {
    const float alpha = finished() ? 1 : moment.alpha;
    rig_.update(view_, alpha, moment.seconds);
    Frame frame;
    frame.camera = rig_.camera();
    frame.wireframe = stage_.view.wireframe;
    view_.draw(frame, alpha, stage_, std::nullopt);
    if (thesis_shown_) draw_thesis(frame, alpha);
    // The charts have a part of the picture of their own, so that they do not hide the scene.
    const bool charts = stage_.view.overlay && moment.size.y > 2 * charts_height;
    if (charts) frame.viewport.w = 1 - charts_height / moment.size.y;
    if (stage_.view.overlay) draw_overlay(frame, moment);
    draw_help(frame, moment, stage_.view, "O shows or hides the outlines");
    std::vector<Frame> frames{std::move(frame)};
    if (charts) frames.push_back(draw_charts(moment));
    return frames;
}

void ComparePage::draw_thesis(Frame& frame, float alpha) const {
    const glm::vec3 colour(thesis_ink);
    for (const Cage& cage : cages_) {
        // Corners move in straight lines between two ticks. The error of mixing matrices is too small to see.
        const glm::mat4 place = (1 - alpha) * cage.previous + alpha * cage.current;
        for (const auto& [from, to] : cage.edges)
            frame.lines.push_back({.from = glm::vec3(place * glm::vec4(from, 1)),
                                   .to = glm::vec3(place * glm::vec4(to, 1)),
                                   .colour = colour,
                                   .width = 1.8f});
    }
}

void ComparePage::draw_overlay(Frame& frame, const Moment& moment) const {
    const reference::Measures &ours = now_.ours, &thesis = now_.theirs;
    TextPanel panel(moment, {12, 12});
    const std::string scene = both_.game().name();
    panel.title(scene.substr(0, scene.find(' ')));
    panel.line("solid: Lockstone", ours_ink);
    panel.line("outlines: the thesis' engine", thesis_ink);
    panel.line("tick " + std::to_string(tick_count()) + " of " + std::to_string(ticks_) + "   " +
                   format_speed(stage_.clock),
               ink::white);
    panel.line("                 Lockstone        thesis");
    panel.line(row("energy", ours.energy(), thesis.energy(), "J"));
    panel.line(row("momentum", length(ours.momentum), length(thesis.momentum), "N s"));
    panel.line(row("overlap", 1e3 * ours.penetration, 1e3 * thesis.penetration, "mm"));
    panel.line("farthest apart  " + format_length(now_.separation_max), ink::white);
    panel.draw(frame);
}

Frame ComparePage::draw_charts(const Moment& moment) const {
    const float share = charts_height / moment.size.y;
    Frame frame;
    frame.viewport = {0, 1 - share, 1, share};
    frame.scene = false;
    const Chart energy{
        .title = "energy",
        .unit = "J",
        .ticks = ticks_ + 1,
        .curves = {{"Lockstone", ours_ink, energy_ours_}, {"thesis", thesis_ink, energy_theirs_}}};
    const Chart distance{.title = "farthest apart",
                         .scale = ChartScale::powers,
                         .low = 1e-7,
                         .high = 100,
                         .marks = {{1e-6, "1 \u00b5m"}, {1e-3, "1 mm"}, {1, "1 m"}},
                         .ticks = ticks_ + 1,
                         .curves = {{"", ink::white, distance_}}};
    const glm::vec2 size(0.5f * moment.size.x, charts_height);
    draw_chart(frame, moment, energy, {0, 0}, size);
    draw_chart(frame, moment, distance, {size.x, 0}, size);
    return frame;
}

Verdict ComparePage::verdict() const {
    const auto first =
        std::find_if(distance_.begin(), distance_.end(), [](double metres) { return !(metres <= apart); });
    std::string sentence = both_.game().name() + ": after " + std::to_string(tick_count()) +
                           " ticks the largest distance between the two engines is " +
                           format_length(distance_.back()) + "; ";
    sentence += first == distance_.end()
                    ? "never more than 1 cm until then"
                    : "more than 1 cm from tick " + std::to_string(first - distance_.begin()) + " on";
    return {sentence};
}

} // namespace

Result<std::unique_ptr<Page>> open_comparison(const Options& options, Stage& stage) {
    Result<reference::SideBySide> both = start(options);
    if (!both) return both.error();
    return std::unique_ptr<Page>(std::make_unique<ComparePage>(options, stage, std::move(*both)));
}

Status check_comparison(const Options& options) {
    const Result<reference::SideBySide> both = start(options);
    return both ? Status{} : both.error();
}

} // namespace lockstone::demo
