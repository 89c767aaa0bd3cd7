#pragma once
/// A match of two machines in one process: two worlds, two rollback sessions, and a simulated network. It contains no
/// game logic: it passes inputs to the sessions and counts events.

#include "cli/input_source.h"
#include "confirmed_log.h"
#include "input_map.h"
#include "lockstone/session.h"
#include "options.h"

#include <array>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace lockstone::demo {

struct Peer {
    Peer(World start, const Game& game, std::unique_ptr<Session> made, cli::InputSource source);

    World world;
    WorldSimulation simulation;
    std::unique_ptr<Session> session;
    ConfirmedLog log;
    SessionRunner runner;
    cli::InputSource inputs;

    std::uint32_t wait = 0;           ///< frames to skip, so that the other peer catches up
    Stall stall = Stall::none;        ///< of the last frame
    std::deque<std::uint32_t> depths; ///< rollback depths of the last frames, 0 for none; the newest last
    std::uint32_t last_depth = 0;     ///< of the last rollback
    std::uint64_t frames_since_rollback = 1000;
    std::array<std::uint64_t, 3> events{}; ///< by EventStatus
    std::array<std::uint64_t, 3> frames_since_event{1000, 1000, 1000};
    std::vector<std::string> notices;
};

class NetplayMatch {
  public:
    static constexpr std::uint32_t peer_count = 2;
    static constexpr std::size_t history = 120; ///< number of frames in Peer::depths

    static Result<std::unique_ptr<NetplayMatch>> create(const Options& options, std::uint64_t ticks);

    /// Runs one frame (a tick's time) on both machines. `people` may be null: then scripts play.
    void frame(InputMap* people);
    bool finished() const;
    void set_link(std::uint32_t latency_ms, std::uint32_t loss_percent);

    const Game& game() const { return *game_; }
    std::uint32_t tick_rate() const { return tick_rate_; }
    std::uint64_t ticks() const { return ticks_; }
    std::uint32_t latency_ms() const { return latency_ms_; }
    std::uint32_t loss_percent() const { return loss_percent_; }
    const Peer& peer(std::uint32_t index) const { return *peers_[index]; }
    bool stuck() const; ///< true if the peers have stopped confirming ticks

    struct Agreement {
        std::uint64_t compared = 0; ///< number of ticks that both peers have confirmed
        std::uint64_t hashes = 0;   ///< number of these with equal hashes
        std::uint64_t inputs = 0;   ///< number of these with equal inputs
    };
    const Agreement& agreement() const { return agreement_; }
    /// Closes the recordings of both peers and compares them.
    bool replays_identical();

  private:
    NetplayMatch(const Options& options, std::unique_ptr<Game> game, std::uint64_t ticks);
    Status add_peer(const Options& options, PeerId self);
    void run_peer(Peer& peer, PeerId self, InputMap* people);
    void account(Peer& peer, const SessionStats& before);
    void compare_confirmed();

    std::unique_ptr<Game> game_;
    SimulatedNetwork network_;
    std::vector<std::unique_ptr<Peer>> peers_;
    std::uint64_t ticks_;
    std::uint32_t tick_rate_ = 60;
    std::uint32_t latency_ms_ = 0, loss_percent_ = 0;
    std::uint64_t frames_ = 0, frame_of_progress_ = 0;
    Agreement agreement_;
};

} // namespace lockstone::demo
