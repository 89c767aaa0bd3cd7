#pragma once
/// Plays a recording: simulates every tick again and compares its hash with the recorded one.

#include "camera_rig.h"
#include "options.h"
#include "page.h"
#include "replay/player.h"
#include "timeline.h"

#include <optional>

namespace lockstone::demo {

class ReplayPage final : public Page {
  public:
    /// Opens a file. `stage` must outlive the page. The error names the file, the place and the reason.
    static Result<std::unique_ptr<Page>> open(const Options& options, Stage& stage);
    /// Opens a recording in memory. `game` may be null for a recording of commands. `rig`: the camera to begin with;
    /// may be null.
    static Result<std::unique_ptr<Page>> open(replay::Recording recording, std::unique_ptr<Game> game,
                                              Stage& stage, const CameraRig* rig);

    std::string_view name() const override { return "replay"; }
    std::uint32_t tick_rate() const override { return recording_.header().tick_rate; }
    std::uint64_t tick_count() const override { return player_->time(); }
    Status tick() override;
    bool finished() const override;
    void control(const Input& input, const Moment& moment) override;
    std::vector<Frame> draw(const Moment& moment) override;
    Verdict verdict() const override;

  private:
    ReplayPage(replay::Recording recording, std::unique_ptr<Game> game, Stage& stage);
    void step(); ///< runs a tick and compares its hash
    void seek(std::uint64_t to);
    void work_on_seek();
    std::optional<std::uint64_t> key_target(const Input& input) const;
    TimelineContent timeline_content() const;
    void draw_overlay(Frame& frame, const Moment& moment) const;

    Stage& stage_;
    replay::Recording recording_;
    std::unique_ptr<Game> game_;
    std::optional<replay::Player> player_; ///< refers to the recording and the game
    std::uint64_t last_;                   ///< time of the last tick to play
    std::vector<TickCheck> checks_;        ///< of tick start + i
    std::uint64_t good_ = 0, bad_ = 0;     ///< number of ticks
    std::optional<std::uint64_t> first_bad_;
    std::uint64_t first_bad_hash_ = 0; ///< the hash that the re-simulation produced
    std::string failure_;              ///< the error that stopped the player
    std::optional<std::uint64_t> target_;

    Timeline timeline_;
    SceneView view_;
    CameraRig rig_;
};

} // namespace lockstone::demo
