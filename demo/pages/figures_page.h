#pragma once
/// Draws the four pictures of the thesis from a recording. Each step of the page is a picture.

#include "options.h"
#include "page.h"
#include "recorded_game.h"
#include "view/figure_ticks.h"
#include "view/scene_view.h"

#include <optional>

namespace lockstone::demo {

class FiguresPage final : public Page {
  public:
    /// Plays the recording up to the last of the four moments. `stage` must outlive the page. The error names the file
    /// and the problem: the recording is not complete, a tick is not bit-exact, or one of the moments does not occur.
    static Result<std::unique_ptr<Page>> open(const Options& options, Stage& stage);

    std::string_view name() const override { return "figure"; }
    std::uint32_t tick_rate() const override { return 1; } ///< a picture a second
    std::uint64_t tick_count() const override { return shown_; }
    std::string picture_name() const override { return "figure-" + std::to_string(shown_); }
    Status tick() override;
    bool finished() const override { return shown_ == figures_.size(); }
    void control(const Input& input, const Moment& moment) override;
    std::vector<Frame> draw(const Moment& moment) override;
    Verdict verdict() const override;

  private:
    struct Figure {
        std::uint64_t time; ///< the state after this many ticks
        const char* caption;
        std::uint64_t trail_from; ///< time of the start of its trails
    };
    using Places = std::array<glm::vec3, 2>; ///< centres of both blocks

    FiguresPage(RecordedGame recorded, Stage& stage) : stage_(stage), recorded_(std::move(recorded)) {}
    Result<FigureTicks> find_ticks();
    void choose_figures(const FigureTicks& ticks);
    Status find_places(const std::array<BodyId, 2>& blocks);
    Status go_to(std::size_t figure);
    Status find_corners();
    void fit_camera(const glm::vec2& size);
    void draw_trails(Frame& frame) const;
    void draw_numbers(Frame& frame, const Moment& moment) const;
    void draw_caption(Frame& frame, const Moment& moment) const;

    Stage& stage_;
    RecordedGame recorded_;
    std::optional<replay::Player> player_; ///< refers to the recording and the game
    std::array<Figure, 4> figures_{};
    std::size_t shown_ = 0;      ///< number of shown figures; the last of them is on the screen
    std::vector<Places> places_; ///< by time
    SceneView view_;
    std::vector<glm::vec3> corners_; ///< of the boxes around the blocks in all four figures
    Camera camera_;
    glm::vec2 fitted_size_{0}; ///< picture size for which the camera was placed [design px]
};

} // namespace lockstone::demo
