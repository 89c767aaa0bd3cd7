#include "online/online_match.h"

#include "cli/match/serve_relay.h"
#include "online/planted_game.h"
#include "view/hud.h"

#include <algorithm>

namespace lockstone::demo {
namespace {

constexpr std::uint32_t prediction_max = 16; ///< [ticks]: a quarter of a second may be predicted
constexpr std::uint64_t host_patience_ms = 20'000;
constexpr std::uint32_t frames_settled = 60;       ///< others may need the last packets for so long
constexpr std::uint32_t frames_for_watchers = 240; ///< additional frames for watchers
/// Frames after a desync in which the machines locate the difference.
constexpr std::uint32_t frames_of_inquiry = 300;
constexpr std::uint64_t frames_between_cards = 10;

std::string number(std::uint64_t n) { return std::to_string(n); }
std::string machine(PeerId peer) { return "machine " + number(peer + 1); }

std::string in_words(const DesyncReport& report) { return "the worlds differ: " + to_string(report); }

} // namespace

// ---- the beginning ----------------------------------------------------------------------------------------

OnlineMatch::OnlineMatch(const Options& options, std::uint64_t ticks)
    : host_(options.host), watches_(!options.watch.empty()), machines_(options.machines),
      wanted_(options.source_given ? options.source : ""), plant_(options.plant) {
    card_.ticks = ticks, card_.script_seed = options.scene.seed, card_.machines = machines_;
}

Result<std::unique_ptr<OnlineMatch>> OnlineMatch::begin(const Options& options, std::uint64_t ticks) {
    std::unique_ptr<OnlineMatch> match(new OnlineMatch(options, ticks));
    if (const Status chosen = options.host ? match->choose_game(options) : Status{}; !chosen)
        return chosen.error();
    if (const Status begun = match->begin_meeting(options); !begun) return begun.error();
    return match;
}

Status OnlineMatch::choose_game(const Options& options) {
    Result<std::unique_ptr<Game>> game = make_scene(options.source, options.scene);
    if (!game) return game.error();
    if ((*game)->player_count() < machines_)
        return Error{options.source + " has " + number((*game)->player_count()) + " players, and " +
                     number(machines_) + " machines need one each; rollback-arena and cars have up to four"};
    rules_ = std::move(*game);
    card_.game = rules_->name(), card_.content_id = rules_->content_id();
    return {};
}

Status OnlineMatch::begin_meeting(const Options& options) {
    Invitation invitation;
    if (options.host && options.relay.empty()) {
        Result<std::unique_ptr<HostRelay>> started =
            HostRelay::start(static_cast<std::uint16_t>(options.port));
        if (!started) return started.error();
        relay_ = std::move(*started);
        invitation = relay_->invitation();
    } else {
        const std::string& word = host_ ? options.relay : watches_ ? options.watch : options.join;
        const Result<Invitation> given = parse_invitation(word);
        if (!given) return given.error();
        invitation = *given;
        if (options.host && !invitation.code.empty())
            return Error{"--relay takes no code: to join a match, use --join " + word};
        if (!options.host && invitation.code.empty())
            return Error{(watches_ ? "--watch" : "--join") + std::string(" needs the code too: CODE@") +
                         word};
    }
    Result<Meeting> meeting = Meeting::begin(invitation, machines_, cli::unix_ms());
    if (!meeting) return meeting.error();
    meeting_ = std::move(*meeting);
    return {};
}

void OnlineMatch::fail(const std::string& sentence) { phase_ = Phase::failed, error_ = sentence; }

// ---- a frame ----------------------------------------------------------------------------------------------

void OnlineMatch::frame(InputMap* people) {
    const std::uint64_t now_ms = cli::unix_ms();
    ++frames_;
    if (wire_) wire_->poll(now_ms);
    if (phase_ == Phase::meeting)
        meet(now_ms);
    else if (phase_ == Phase::entering)
        enter(now_ms);
    else if (phase_ == Phase::playing || phase_ == Phase::settled)
        play(now_ms, people);
}

void OnlineMatch::meet(std::uint64_t now_ms) {
    if (const Status status = meeting_->poll(now_ms); !status) return fail(status.error().message);
    if (!meeting_->token()) return;
    Result<UdpTransport> opened = UdpTransport::open(*meeting_->token(), {}, {}, now_ms);
    if (!opened) return fail(opened.error().message);
    wire_ = std::move(*opened);
    packets_.emplace(*wire_);
    phase_ = Phase::entering, entered_ms_ = now_ms;
    if (!host_) return;
    if (const Status started = start_session(); !started) fail(started.error().message);
}

void OnlineMatch::enter(std::uint64_t now_ms) {
    while (packets_->receive()) {} // drops packets of sessions: they are sent again
    if (!packets_->card(0)) {
        if (now_ms - entered_ms_ > host_patience_ms)
            fail("the host of the code " + invitation().code + " does not answer through the relay at " +
                 to_string(invitation().relay));
        return;
    }
    card_ = *packets_->card(0);
    machines_ = card_.machines;
    Result<std::unique_ptr<Game>> game = game_of(card_, wanted_);
    if (!game) return fail(game.error().message);
    rules_ = std::move(*game);
    if (const Status started = start_session(); !started) fail(started.error().message);
}

Status OnlineMatch::start_session() {
    Result<World> world = rules_->start();
    if (!world) return world.error();
    std::vector<PeerId> homes;
    for (PeerId p = 0; p < rules_->player_count(); ++p) homes.push_back(p % machines_);
    delay_ = InputDelayTuner({.tick_rate = world->def().tick_rate, .least = 2});
    SessionDef def = session_def(*rules_, self(), homes);
    def.prediction_max = prediction_max;
    def.input_delay = delay_.delay();
    Result<std::unique_ptr<Session>> session =
        watches_ ? make_spectator_session(def, 0, *packets_) : make_rollback_session(def, *packets_);
    if (!session) return session.error();
    if (plant_) {
        Result<std::unique_ptr<Game>> again = make_scene_named(rules_->name());
        if (!again) return again.error();
        played_ = std::make_unique<PlantedGame>(std::move(*again), *plant_);
    }
    std::unique_ptr<SpectatorHost> watched;
    // Every machine that plays also shows the match, so that watchers can go on when one machine has left.
    if (!watches_) {
        Invitation relay = invitation();
        relay.code.clear();
        gallery_.emplace(relay, card_);
        watched = std::make_unique<SpectatorHost>(def, *gallery_, SpectatorHostDef{}, &log_);
    }
    if (const Status begun = log_.begin(*rules_, *world, card_.ticks); !begun) return begun;
    play_ = std::make_unique<Play>(std::move(*world), played_ ? *played_ : *rules_, std::move(*session),
                                   std::move(watched), log_);
    phase_ = Phase::playing;
    return {};
}

void OnlineMatch::play(std::uint64_t now_ms, InputMap* people) {
    if (gallery_) gallery_->poll(now_ms);
    if (host_) tell_the_game();
    const std::uint64_t resimulated = play_->session->stats().resimulated;
    if (watches_)
        watch(now_ms);
    else
        play_tick(now_ms, people);
    depths_.push_back(static_cast<std::uint32_t>(play_->session->stats().resimulated - resimulated));
    if (depths_.size() > history) depths_.pop_front();
    if (depths_.back() != 0) last_depth_ = depths_.back();
    read_notices();
    if (play_->watched) play_->watched->poll();
}

void OnlineMatch::play_tick(std::uint64_t now_ms, InputMap* people) {
    if (play_->session->current_tick() >= card_.ticks) {
        settle_when_done(play_->runner.drain(now_ms));
    } else if (wait_ > 0) {
        --wait_;
        play_->runner.wait(now_ms);
    } else {
        tune_delay();
        add_inputs(people);
        const lockstone::Frame ran = play_->runner.frame(now_ms);
        stall_ = ran.stall, wait_ = ran.wait_ticks;
    }
}

/// Runs several ticks in a frame while it has to catch up.
void OnlineMatch::watch(std::uint64_t now_ms) {
    stall_ = play_->runner.frame(now_ms).stall;
    const std::uint64_t ticks = log_.hashes().size();
    if (ticks != ticks_seen_ || progress_ms_ == 0) ticks_seen_ = ticks, progress_ms_ = now_ms;
    settle_when_done(log_.complete());
    if (phase_ == Phase::playing && now_ms - progress_ms_ > host_patience_ms)
        fail("the host has sent nothing for 20 seconds: only " + number(ticks) + " of " +
             number(card_.ticks) + " ticks arrived");
}

void OnlineMatch::settle_when_done(bool confirmed) {
    if (confirmed) phase_ = Phase::settled;
    const std::uint32_t frames =
        frames_settled + (gallery_ && gallery_->let_in() > 0 ? frames_for_watchers : 0);
    if (phase_ == Phase::settled && ++frames_settled_ > frames && !desync_tick_) phase_ = Phase::over;
}

/// Sends the match card again and again to machines that have not begun, because packets may be lost.
void OnlineMatch::tell_the_game() {
    for (PeerId peer = 1; peer < machines_ && frames_ % frames_between_cards == 0; ++peer)
        if (!play_->session->quality(peer).connected) packets_->send(peer, to_bytes(card_));
}

void OnlineMatch::tune_delay() {
    std::vector<PeerQuality> others;
    for (PeerId peer = 0; peer < machines_; ++peer)
        if (peer != self()) others.push_back(play_->session->quality(peer));
    play_->session->set_input_delay(delay_.update(others));
}

/// A person controls the first player of this machine, and each further one whose gamepad or keys are used. Scripts
/// control the rest.
void OnlineMatch::add_inputs(InputMap* people) {
    const std::uint64_t tick = play_->session->current_tick();
    std::size_t seat = 0;
    for (std::uint32_t p = self(); p < rules_->player_count(); p += machines_, ++seat) {
        std::vector<std::byte> input(rules_->input_size());
        if (people != nullptr && seat < InputMap::seat_count && (seat == 0 || people->used(seat)))
            std::ranges::copy(encode_input(people->take(seat)), input.begin());
        else
            scripted_input(*rules_, card_.script_seed, tick, p, input);
        play_->session->add_local_input(p, input);
    }
}

// ---- what happens -----------------------------------------------------------------------------------------

void OnlineMatch::read_notices() {
    while (const std::optional<Notice> notice = play_->session->next_notice()) take_notice(*notice);
    // The other machine may still send questions.
    if (!told_.empty() && ++frames_since_told_ > frames_settled) fail(told_);
    if (desync_tick_ && told_.empty() && phase_ != Phase::failed &&
        (watches_ || ++frames_since_desync_ > frames_of_inquiry))
        fail("the worlds differ from tick " + number(*desync_tick_) + " on" +
             (watches_ ? "" : ", and the other machine does not report where"));
}

void OnlineMatch::take_notice(const Notice& notice) {
    if (const auto* came = std::get_if<PeerConnected>(&notice))
        notices_.push_back(machine(came->peer) + " has joined");
    if (const auto* gone = std::get_if<PlayerDisconnected>(&notice))
        notices_.push_back("player " + number(gone->player + 1) + " has left at tick " + number(gone->tick));
    if (const auto* desync = std::get_if<Desync>(&notice)) {
        desync_tick_ = desync_tick_.value_or(desync->tick);
        notices_.push_back("the worlds differ from tick " + number(desync->tick) + " on");
    }
    if (const auto* named = std::get_if<DesyncNamed>(&notice))
        told_ = in_words(*named->report), report_ = named->report;
    if (const auto* other = std::get_if<PeerIncompatible>(&notice))
        fail(machine(other->peer) + " plays a different match: " + other->reason);
    if (const auto* stopped = std::get_if<MatchStopped>(&notice)) fail(stopped->reason);
}

// ---- in words ---------------------------------------------------------------------------------------------

std::string OnlineMatch::state() const {
    switch (phase_) {
    case Phase::meeting:
        return invitation().code.empty() || host_ == false ? "contacting the relay"
                                                           : "waiting for the other players";
    case Phase::entering:
        return "waiting for the host";
    case Phase::playing:
        return watches_                      ? "watching"
               : stall_ == Stall::none       ? "playing"
               : stall_ == Stall::connecting ? "waiting for the others to begin"
                                             : "waiting for a machine's inputs";
    case Phase::settled:
        return "all ticks are confirmed";
    case Phase::over:
        return "the match is over";
    case Phase::failed:
        return "stopped";
    }
    return {};
}

std::string OnlineMatch::player_in_words(std::uint32_t player) const {
    const PeerId home = player % machines_;
    const bool first = player < machines_;
    if (!watches_ && home == self()) return first ? "you" : "bot here";
    return first ? machine(home) : "bot of " + machine(home);
}

std::string OnlineMatch::summary() const {
    const SessionStats& stats = play_->session->stats();
    const std::vector<std::uint64_t>& hashes = log_.hashes();
    return rules_->name() + ", " + (watches_ ? "watching" : machine(self())) + " of " + number(machines_) +
           ": " + number(hashes.size()) + " ticks confirmed, hash " +
           (hashes.empty() ? "none" : format_hash(hashes.back())) + ", " + number(stats.rollbacks) +
           " rollbacks, depth at most " + number(stats.depth_max);
}

Result<std::span<const std::byte>> OnlineMatch::recording() {
    if (const Status closed = log_.close(); !closed) return closed.error();
    return std::span<const std::byte>(log_.replay());
}

Result<std::optional<OnlineMatch::Recorded>> OnlineMatch::finish() {
    if (play_ == nullptr || log_.hashes().empty()) return std::optional<Recorded>();
    if (const Status closed = log_.close(); !closed) return closed.error();
    std::vector<std::byte> bytes = log_.replay();
    play_.reset(); // it refers to the rules
    return std::optional<Recorded>({std::move(bytes), std::move(rules_)});
}

} // namespace lockstone::demo
