#pragma once
/// Plays a game, from a person's inputs, its script or a file, and records it.

#include "camera_rig.h"
#include "cli/input_source.h"
#include "input_map.h"
#include "options.h"
#include "page.h"
#include "replay/recorder.h"

#include <optional>

namespace lockstone::demo {

/// The next page plays the recording.
class LivePage final : public Page {
  public:
    /// Opens the page. `stage` must outlive it. Errors: no such scene, bad options, a file that cannot be read or
    /// written.
    static Result<std::unique_ptr<Page>> open(const Options& options, Stage& stage);

    std::string_view name() const override { return "play"; }
    std::uint32_t tick_rate() const override { return world_.def().tick_rate; }
    std::uint64_t tick_count() const override { return world_.tick_count(); }
    Status tick() override;
    bool finished() const override { return ended_ || world_.tick_count() >= ticks_; }
    void control(const Input& input, const Moment& moment) override;
    std::vector<Frame> draw(const Moment& moment) override;
    Result<std::unique_ptr<Page>> next() override;
    Verdict verdict() const override { return {"no tick was compared", false}; }

  private:
    LivePage(const Options& options, Stage& stage, std::unique_ptr<Game> game, World world,
             cli::InputSource source);
    Status start_recording(const Options& options);
    void draw_overlay(Frame& frame, const Moment& moment) const;

    Stage& stage_;
    std::unique_ptr<Game> game_;
    World world_;
    cli::InputSource source_;
    bool people_play_;
    std::uint64_t ticks_; ///< number of ticks to play
    bool ended_ = false;

    std::string record_file_; ///< empty: records to memory
    std::unique_ptr<replay::Sink> sink_;
    std::optional<replay::InputRecorder> recorder_;

    InputMap input_map_;
    SceneView view_;
    CameraRig rig_;
    double tick_us_ = 0; ///< smoothed
};

} // namespace lockstone::demo
