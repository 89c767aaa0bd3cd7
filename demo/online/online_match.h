#pragma once
/// One machine of a match over UDP. It finds the others by a code, plays or watches, and records the confirmed ticks.
/// Runs in real time.

#include "input_map.h"
#include "lockstone/session/input_delay.h"
#include "lockstone/session/spectator.h"
#include "meet/match_card.h"
#include "meet/meeting.h"
#include "online/gallery.h"
#include "online/host_relay.h"
#include "options.h"
#include "pages/confirmed_log.h"

#include <deque>

namespace lockstone::demo {

class OnlineMatch {
  public:
    enum class Phase {
        meeting,  ///< at the relay, until all machines have joined
        entering, ///< waits for the host's match card
        playing,
        settled, ///< every tick is confirmed; others may still need packets of this machine
        over,
        failed, ///< error() has the reason
    };
    static constexpr std::size_t history = 120; ///< number of frames in depths()

    /// Hosts, joins or watches a match according to the options. `ticks`: length of a hosted match.
    static Result<std::unique_ptr<OnlineMatch>> begin(const Options& options, std::uint64_t ticks);

    /// Call once per tick of real time. `people` may be null: then scripts play.
    void frame(InputMap* people);

    Phase phase() const { return phase_; }
    const std::string& error() const { return error_; } ///< a sentence; empty: no error
    bool desynced() const { return desync_tick_.has_value(); }
    /// Null if the worlds agree, or if no report names a difference.
    const DesyncReport* desync_report() const { return report_.get(); }

    // ---- while meeting, and later ----
    bool is_host() const { return host_; }
    bool watches() const { return watches_; }
    const Invitation& invitation() const { return meeting_->invitation(); }
    bool relay_is_ours() const { return relay_ != nullptr; }
    std::uint32_t machines() const { return machines_; }
    /// The peer id of this machine; for a watcher that of the host.
    PeerId self() const { return wire_ && !watches_ ? meeting_->token()->slot : 0; }
    /// The invitation for the next watcher; its code is empty if no watcher can join.
    Invitation invitation_to_watch() const { return gallery_ ? gallery_->invitation() : Invitation{}; }
    std::uint32_t watchers() const { return play_ && play_->watched ? play_->watched->watchers() : 0; }
    /// "waiting for ...", in one line.
    std::string state() const;

    // ---- once the game is known ----
    const Game* game() const { return rules_.get(); }
    const World* world() const { return play_ ? &play_->world : nullptr; }
    const Session& session() const { return *play_->session; } ///< only if there is a world
    const ConfirmedLog& log() const { return log_; }
    std::uint64_t ticks() const { return card_.ticks; }
    std::string player_in_words(std::uint32_t player) const; ///< "you", "machine 2", "bot of machine 1"
    std::span<const std::string> notices() const { return notices_; }
    const std::deque<std::uint32_t>& depths() const { return depths_; } ///< rollback depths, by frame
    std::uint32_t last_depth() const { return last_depth_; }
    /// [ticks], adapted to the delay of the links.
    std::uint32_t input_delay() const { return delay_.delay(); }
    Stall stall() const { return stall_; }
    /// "600 ticks, hash ..., 37 rollbacks, ..."
    std::string summary() const;

    /// Closes the recording of all confirmed ticks; later ticks are not confirmed. Requires a world.
    Result<std::span<const std::byte>> recording();
    /// The recording of the confirmed ticks, and the game that plays it. The match cannot be used afterwards. Empty if
    /// the match had not begun.
    struct Recorded {
        std::vector<std::byte> bytes;
        std::unique_ptr<Game> game;
    };
    Result<std::optional<Recorded>> finish();

  private:
    struct Play {
        /// `host` may be null: then the match has no watchers.
        Play(World start, const Game& game, std::unique_ptr<Session> made,
             std::unique_ptr<SpectatorHost> host, ConfirmedLog& to)
            : world(std::move(start)), simulation(world, game), session(std::move(made)),
              watched(std::move(host)),
              runner(*session, simulation,
                     {.sink = watched ? static_cast<ConfirmedSink*>(watched.get()) : &to}) {}
        World world;
        WorldSimulation simulation;
        std::unique_ptr<Session> session;
        std::unique_ptr<SpectatorHost> watched; ///< passes confirmed ticks on to the log
        SessionRunner runner;
    };
    OnlineMatch(const Options& options, std::uint64_t ticks);
    Status begin_meeting(const Options& options);
    Status choose_game(const Options& options);
    void fail(const std::string& sentence);
    void meet(std::uint64_t now_ms);
    void enter(std::uint64_t now_ms);
    Status start_session();
    void play(std::uint64_t now_ms, InputMap* people);
    void play_tick(std::uint64_t now_ms, InputMap* people);
    void watch(std::uint64_t now_ms);
    void settle_when_done(bool confirmed);
    void tell_the_game();
    void tune_delay();
    void add_inputs(InputMap* people);
    void read_notices();
    void take_notice(const Notice& notice);

    bool host_, watches_;
    std::uint32_t machines_; ///< from the options at the host, else from the card
    std::string wanted_;     ///< the scene that the options of a joining machine demand; empty: any
    std::optional<std::uint64_t> plant_;
    MatchCard card_;
    Phase phase_ = Phase::meeting;
    std::string error_;

    std::unique_ptr<HostRelay> relay_; ///< null: the relay belongs to others
    std::optional<Meeting> meeting_;
    std::optional<UdpTransport> wire_;
    std::optional<CardTransport> packets_;
    std::optional<Gallery> gallery_; ///< only of a machine that plays
    std::unique_ptr<Game> rules_;    ///< without a planted fault
    std::unique_ptr<Game> played_;   ///< null, or the rules with a planted fault
    ConfirmedLog log_;
    std::unique_ptr<Play> play_; ///< refers to all members above

    std::uint64_t frames_ = 0, entered_ms_ = 0, progress_ms_ = 0, ticks_seen_ = 0;
    std::uint32_t wait_ = 0, frames_settled_ = 0, frames_since_desync_ = 0, frames_since_told_ = 0;
    std::string told_;                           ///< a sentence with the first difference of the worlds
    std::shared_ptr<const DesyncReport> report_; ///< the report of that difference
    std::optional<std::uint64_t> desync_tick_;
    InputDelayTuner delay_{InputDelayDef{}};
    Stall stall_ = Stall::none;
    std::vector<std::string> notices_;
    std::deque<std::uint32_t> depths_;
    std::uint32_t last_depth_ = 0;
};

} // namespace lockstone::demo
