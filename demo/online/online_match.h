#pragma once
/// One machine of a match over UDP: it meets the others by a code, plays or watches, records what is confirmed. Real time.

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
        meeting,  ///< waiting at the relay until all machines are there
        entering, ///< waiting for the host to say what is played
        playing,
        settled, ///< every tick is confirmed; others may still need our packets
        over,
        failed, ///< error() says why
    };
    static constexpr std::size_t history = 120; ///< frames kept in depths()

    /// Hosts, joins or watches, as the options say. `ticks`: how long a hosted match is.
    static Result<std::unique_ptr<OnlineMatch>> begin(const Options& options, std::uint64_t ticks);

    /// Call once per tick of real time. `people` may be null: then bots play.
    void frame(InputMap* people);

    Phase phase() const { return phase_; }
    const std::string& error() const { return error_; } ///< a sentence; empty: all is well
    bool desynced() const { return desync_tick_.has_value(); }
    /// Null where the worlds agree, or where no report names a difference.
    const DesyncReport* desync_report() const { return report_.get(); }

    // ---- while meeting, and later ----
    bool is_host() const { return host_; }
    bool watches() const { return watches_; }
    const Invitation& invitation() const { return meeting_->invitation(); }
    bool relay_is_ours() const { return relay_ != nullptr; }
    std::uint32_t machines() const { return machines_; }
    PeerId self() const {
        return wire_ && !watches_ ? meeting_->token()->slot : 0;
    } ///< who watches: the host's
    /// Of the next watcher; its code is empty where nobody can be let in.
    Invitation invitation_to_watch() const { return gallery_ ? gallery_->invitation() : Invitation{}; }
    std::uint32_t watchers() const { return play_ && play_->watched ? play_->watched->watchers() : 0; }
    /// "waiting for ..."; for one line.
    std::string state() const;

    // ---- from the game on ----
    const Game* game() const { return rules_.get(); }
    const World* world() const { return play_ ? &play_->world : nullptr; }
    const Session& session() const { return *play_->session; } ///< with a world only
    const ConfirmedLog& log() const { return log_; }
    std::uint64_t ticks() const { return card_.ticks; }
    std::string player_in_words(std::uint32_t player) const; ///< "you", "machine 2", "bot of machine 1"
    std::span<const std::string> notices() const { return notices_; }
    const std::deque<std::uint32_t>& depths() const { return depths_; } ///< of rollbacks, by frame
    std::uint32_t last_depth() const { return last_depth_; }
    std::uint32_t input_delay() const { return delay_.delay(); } ///< [ticks], tuned by the way to the others
    Stall stall() const { return stall_; }
    /// "600 ticks, hash ..., 37 rollbacks, ..."
    std::string summary() const;

    /// Closes the recording of all confirmed ticks; no tick is confirmed after that. Only with a world.
    Result<std::span<const std::byte>> recording();
    /// The recording of what is confirmed, and the game that plays it; uses the match up. Nothing: it had not begun.
    struct Recorded {
        std::vector<std::byte> bytes;
        std::unique_ptr<Game> game;
    };
    Result<std::optional<Recorded>> finish();

  private:
    struct Play {
        /// `host` may be null: nobody can watch.
        Play(World start, const Game& game, std::unique_ptr<Session> made,
             std::unique_ptr<SpectatorHost> host, ConfirmedLog& to)
            : world(std::move(start)), simulation(world, game), session(std::move(made)),
              watched(std::move(host)),
              runner(*session, simulation,
                     {.sink = watched ? static_cast<ConfirmedSink*>(watched.get()) : &to}) {}
        World world;
        WorldSimulation simulation;
        std::unique_ptr<Session> session;
        std::unique_ptr<SpectatorHost> watched; ///< hands on to the log
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
    std::uint32_t machines_; ///< elsewhere than at the host: known from the card
    std::string wanted_;     ///< the scene that a joining machine was asked to play; empty: any
    std::optional<std::uint64_t> plant_;
    MatchCard card_;
    Phase phase_ = Phase::meeting;
    std::string error_;

    std::unique_ptr<HostRelay> relay_; ///< null: somebody else's
    std::optional<Meeting> meeting_;
    std::optional<UdpTransport> wire_;
    std::optional<CardTransport> packets_;
    std::optional<Gallery> gallery_; ///< of a machine that plays
    std::unique_ptr<Game> rules_;    ///< without a fault
    std::unique_ptr<Game> played_;   ///< null, or the rules with one
    ConfirmedLog log_;
    std::unique_ptr<Play> play_; ///< uses all above

    std::uint64_t frames_ = 0, entered_ms_ = 0, progress_ms_ = 0, ticks_seen_ = 0;
    std::uint32_t wait_ = 0, frames_settled_ = 0, frames_since_desync_ = 0, frames_since_told_ = 0;
    std::string told_;                           ///< where the worlds differ
    std::shared_ptr<const DesyncReport> report_; ///< the same
    std::optional<std::uint64_t> desync_tick_;
    InputDelayTuner delay_{InputDelayDef{}};
    Stall stall_ = Stall::none;
    std::vector<std::string> notices_;
    std::deque<std::uint32_t> depths_;
    std::uint32_t last_depth_ = 0;
};

} // namespace lockstone::demo
