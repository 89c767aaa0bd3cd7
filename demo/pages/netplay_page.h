#pragma once
/// Two rollback peers side by side. Each half shows the world as that peer predicts it.

#include "camera_rig.h"
#include "netplay_match.h"
#include "page.h"

#include <array>

namespace lockstone::demo {

class NetplayPage final : public Page {
  public:
    /// Opens the page. `stage` must outlive it.
    static Result<std::unique_ptr<Page>> open(const Options& options, Stage& stage);

    std::string_view name() const override { return "netplay"; }
    std::uint32_t tick_rate() const override { return match_->tick_rate(); }
    std::uint64_t tick_count() const override { return match_->agreement().compared; }
    Status tick() override;
    bool finished() const override { return match_->finished(); }
    void control(const Input& input, const Moment& moment) override;
    std::vector<Frame> draw(const Moment& moment) override;
    Verdict verdict() const override;

  private:
    struct Half {
        SceneView view;
        CameraRig rig;
    };
    NetplayPage(const Options& options, Stage& stage, std::unique_ptr<NetplayMatch> match);
    Status finish(); ///< closes and compares the recordings, writes one if the options name a file
    Frame draw_half(std::uint32_t index, const Moment& moment);
    void draw_peer(Frame& frame, std::uint32_t index, const Moment& moment) const;
    void draw_rollbacks(Frame& frame, const Peer& peer, const Moment& moment) const;
    Frame draw_middle(const Moment& moment) const;

    Stage& stage_;
    std::unique_ptr<NetplayMatch> match_;
    std::array<Half, NetplayMatch::peer_count> halves_;
    InputMap input_map_;
    bool people_play_;
    std::string record_file_;
    bool closed_ = false, replays_identical_ = false;
};

} // namespace lockstone::demo
