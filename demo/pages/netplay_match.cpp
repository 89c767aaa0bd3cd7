#include "netplay_match.h"

#include <algorithm>

namespace lockstone::demo {
namespace {

constexpr std::uint32_t prediction_max = 16; ///< [ticks]: a quarter of a second may be predicted
constexpr std::uint32_t input_delay = 1;     ///< [ticks]: small, so that rollbacks occur
constexpr std::uint64_t stuck_frames = 1200;

std::vector<PeerId> homes_of_players(std::uint32_t players) {
    std::vector<PeerId> homes;
    for (std::uint32_t p = 0; p < players; ++p) homes.push_back(p % NetplayMatch::peer_count);
    return homes;
}

std::string describe_notice(const Notice& notice) {
    if (const auto* desync = std::get_if<Desync>(&notice))
        return "desync at tick " + std::to_string(desync->tick);
    if (const auto* gone = std::get_if<PlayerDisconnected>(&notice))
        return "player " + std::to_string(gone->player + 1) + " left at tick " + std::to_string(gone->tick);
    if (const auto* other = std::get_if<PeerIncompatible>(&notice))
        return std::string("the peer is incompatible: ") + other->reason;
    return {};
}

} // namespace

// ---- the peers --------------------------------------------------------------------------------------------

Peer::Peer(World start, const Game& game, std::unique_ptr<Session> made, cli::InputSource source)
    : world(std::move(start)), simulation(world, game), session(std::move(made)),
      runner(*session, simulation, {&log}), inputs(std::move(source)) {}

NetplayMatch::NetplayMatch(const Options& options, std::unique_ptr<Game> game, std::uint64_t ticks)
    : game_(std::move(game)), network_(peer_count, {}, options.scene.seed), ticks_(ticks) {
    set_link(options.latency_ms, options.loss_percent);
}

Result<std::unique_ptr<NetplayMatch>> NetplayMatch::create(const Options& options, std::uint64_t ticks) {
    Result<std::unique_ptr<Game>> game = make_scene(options.source, options.scene);
    if (!game) return game.error();
    if ((*game)->player_count() < peer_count)
        return Error{options.source + " has too few players for two peers; --netplay needs a scene with two "
                                      "players, such as rollback-arena"};
    std::unique_ptr<NetplayMatch> match(new NetplayMatch(options, std::move(*game), ticks));
    for (PeerId self = 0; self < peer_count; ++self)
        if (const Status status = match->add_peer(options, self); !status) return status.error();
    return match;
}

Status NetplayMatch::add_peer(const Options& options, PeerId self) {
    Result<World> world = game_->start();
    if (!world) return world.error();
    tick_rate_ = world->def().tick_rate;
    SessionDef def = session_def(*game_, self, homes_of_players(game_->player_count()));
    def.input_delay = input_delay;
    def.prediction_max = prediction_max;
    Result<std::unique_ptr<Session>> session = make_rollback_session(def, network_.endpoint(self));
    if (!session) return session.error();
    Result<cli::InputSource> inputs = options.input_file.empty()
                                          ? cli::InputSource::scripted(*game_, options.scene.seed)
                                          : cli::InputSource::open(*game_, options.input_file);
    if (!inputs) return inputs.error();
    peers_.push_back(
        std::make_unique<Peer>(std::move(*world), *game_, std::move(*session), std::move(*inputs)));
    return peers_.back()->log.begin(*game_, peers_.back()->world, ticks_);
}

void NetplayMatch::set_link(std::uint32_t latency_ms, std::uint32_t loss_percent) {
    latency_ms_ = latency_ms;
    loss_percent_ = loss_percent;
    LinkDef link;
    link.latency_ms = latency_ms;
    link.jitter_ms = latency_ms / 4;
    link.loss_permille = 10 * loss_percent;
    network_.set_link(0, 1, link);
    network_.set_link(1, 0, link);
}

// ---- a frame ----------------------------------------------------------------------------------------------

void NetplayMatch::frame(InputMap* people) {
    if (finished()) return;
    network_.advance_to(++frames_ * 1000 / tick_rate_);
    for (PeerId self = 0; self < peer_count; ++self) run_peer(*peers_[self], self, people);
    compare_confirmed();
}

void NetplayMatch::run_peer(Peer& peer, PeerId self, InputMap* people) {
    const std::uint64_t now_ms = frames_ * 1000 / tick_rate_;
    const SessionStats before = peer.session->stats();
    if (peer.wait != 0) {
        --peer.wait;
        peer.runner.wait(now_ms);
        account(peer, before);
        return;
    }
    const std::span<const PlayerInput> planned = peer.inputs.at(peer.session->current_tick() + input_delay);
    for (std::uint32_t p = self; p < planned.size(); p += peer_count) {
        const bool person = people != nullptr && p < InputMap::seat_count && (p == 0 || people->used(p));
        if (person)
            peer.session->add_local_input(p, encode_input(people->take(p)));
        else
            peer.session->add_local_input(p, planned[p].bytes);
    }
    const lockstone::Frame ran = peer.runner.frame(now_ms);
    peer.stall = ran.stall;
    peer.wait = ran.wait_ticks;
    account(peer, before);
}

void NetplayMatch::account(Peer& peer, const SessionStats& before) {
    const SessionStats& now = peer.session->stats();
    const auto depth = static_cast<std::uint32_t>(now.resimulated - before.resimulated);
    peer.depths.push_back(depth);
    if (peer.depths.size() > history) peer.depths.pop_front();
    ++peer.frames_since_rollback;
    if (depth != 0) peer.last_depth = depth, peer.frames_since_rollback = 0;
    for (std::uint64_t& since : peer.frames_since_event) ++since;
    for (const SessionEvent& event : peer.runner.events()) {
        const auto status = static_cast<std::size_t>(event.status);
        ++peer.events[status];
        peer.frames_since_event[status] = 0;
    }
    while (const std::optional<Notice> notice = peer.session->next_notice())
        if (std::string text = describe_notice(*notice); !text.empty())
            peer.notices.push_back(std::move(text));
}

void NetplayMatch::compare_confirmed() {
    const ConfirmedLog &a = peers_[0]->log, &b = peers_[1]->log;
    const std::uint64_t both = std::min(a.hashes().size(), b.hashes().size());
    if (agreement_.compared < both) frame_of_progress_ = frames_;
    for (; agreement_.compared < both; ++agreement_.compared) {
        const std::uint64_t tick = agreement_.compared;
        if (a.hashes()[tick] == b.hashes()[tick]) ++agreement_.hashes;
        if (a.inputs()[tick] == b.inputs()[tick]) ++agreement_.inputs;
    }
}

bool NetplayMatch::stuck() const { return frames_ - frame_of_progress_ > stuck_frames; }

bool NetplayMatch::finished() const {
    return stuck() || (peers_[0]->log.complete() && peers_[1]->log.complete());
}

bool NetplayMatch::replays_identical() {
    const bool closed = peers_[0]->log.close().ok() && peers_[1]->log.close().ok();
    return closed && peers_[0]->log.replay() == peers_[1]->log.replay();
}

} // namespace lockstone::demo
