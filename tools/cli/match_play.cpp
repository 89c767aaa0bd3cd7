#include "cli/match.h"

#include "cli/text.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <memory>

namespace lockstone::cli {
namespace {

/// Everything of one machine. Not moved: its parts refer to each other.
struct Peer {
    Peer(World start, const Game& game) : world(std::move(start)), simulation(world, game) {}

    World world;
    WorldSimulation simulation;
    replay::MemorySink sink;
    std::unique_ptr<ConfirmedLog> log;
    std::unique_ptr<Session> session;
    std::unique_ptr<SessionRunner> runner;
    std::uint32_t wait_frames = 0;
};

Result<std::unique_ptr<Peer>> make_peer(const Game& game, const MatchDef& def, PeerId self,
                                        Transport& transport) {
    Result<World> world = game.start();
    if (!world) return world.error();
    auto peer = std::make_unique<Peer>(std::move(*world), game);
    replay::RecorderOptions options;
    options.options = {{"match.peer", std::to_string(self)}, {"match.seed", std::to_string(def.seed)}};
    Result<replay::InputRecorder> recorder =
        replay::InputRecorder::begin(peer->sink, game, peer->world, options);
    if (!recorder) return recorder.error();
    peer->log = std::make_unique<ConfirmedLog>(std::move(*recorder), def.ticks);

    std::vector<PeerId> players(game.player_count());
    for (PeerId p = 0; p < players.size(); ++p) players[p] = p;
    const SessionDef session_of = session_def(game, self, players);
    Result<std::unique_ptr<Session>> session = def.mode == MatchMode::rollback
                                                   ? make_rollback_session(session_of, transport)
                                                   : make_lockstep_session(session_of, transport);
    if (!session) return session.error();
    peer->session = std::move(*session);
    peer->runner = std::make_unique<SessionRunner>(*peer->session, peer->simulation,
                                                   RunnerDef{.sink = peer->log.get(), .column_left_out = {}});
    return peer;
}

/// One frame of one machine: the player's input, the session, its notices.
void run_frame(Peer& peer, PeerId self, const Game& game, const MatchDef& def, std::uint64_t now_ms,
               MatchOutcome& out) {
    if (peer.wait_frames > 0) {
        --peer.wait_frames;
        peer.runner->wait(now_ms);
    } else {
        std::vector<std::byte> input(game.input_size());
        scripted_input(game, def.seed, peer.session->current_tick(), self, input);
        peer.session->add_local_input(self, input);
        peer.wait_frames = peer.runner->frame(now_ms).wait_ticks;
    }
    while (const auto notice = peer.session->next_notice()) {
        if (const auto* named = std::get_if<DesyncNamed>(&*notice))
            out.desyncs.push_back("peer " + std::to_string(self) + ": " + to_string(*named->report));
        if (const auto* desync = std::get_if<Desync>(&*notice))
            out.desyncs.push_back("peer " + std::to_string(self) + " and peer " +
                                  std::to_string(desync->peer) + " differ after tick " +
                                  std::to_string(desync->tick) + ": " + hash_text(desync->local) +
                                  " against " + hash_text(desync->remote));
    }
}

/// By all of them.
std::uint64_t ticks_confirmed(const std::vector<std::unique_ptr<Peer>>& peers) {
    std::uint64_t least = ~std::uint64_t{0};
    for (const auto& peer : peers) least = std::min<std::uint64_t>(least, peer->log->hashes.size());
    return least;
}

} // namespace

void ConfirmedLog::on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) {
    if (tick >= ticks_max || !state) return;
    state = recorder.on_tick(tick, inputs, hash);
    hashes.push_back(hash);
    for (const PlayerInput& input : inputs) {
        inputs_confirmed.push_back(static_cast<std::byte>(input.status));
        inputs_confirmed.insert(inputs_confirmed.end(), input.bytes.begin(), input.bytes.end());
    }
}

Status ConfirmedLog::close() {
    if (!state) return state;
    return recorder.close();
}

Result<MatchOutcome> play_match(const Game& game, const MatchDef& def,
                                const std::function<void(std::uint64_t)>& progress) {
    SimulatedNetwork network(game.player_count(), def.link, def.seed);
    std::vector<std::unique_ptr<Peer>> peers;
    for (PeerId p = 0; p < game.player_count(); ++p) {
        Result<std::unique_ptr<Peer>> peer = make_peer(game, def, p, network.endpoint(p));
        if (!peer) return peer.error();
        peers.push_back(std::move(*peer));
    }
    MatchOutcome out;
    const std::uint64_t rate = peers.front()->world.def().tick_rate;
    const std::uint64_t frames_max = 20 * def.ticks + 60 * rate;
    for (std::uint64_t frame = 0; ticks_confirmed(peers) < def.ticks; ++frame) {
        if (frame == frames_max)
            return Error{"seed " + std::to_string(def.seed) + ": the match is still not through after " +
                         std::to_string(frames_max) + " frames"};
        out.milliseconds = frame * 1000 / rate;
        network.advance_to(out.milliseconds);
        for (PeerId p = 0; p < peers.size(); ++p) run_frame(*peers[p], p, game, def, out.milliseconds, out);
        if (progress) progress(ticks_confirmed(peers));
    }
    for (auto& peer : peers) {
        if (Status s = peer->log->close(); !s) return s.error();
        out.peers.push_back({std::move(peer->sink.bytes), std::move(peer->log->hashes),
                             std::move(peer->log->inputs_confirmed), peer->session->stats()});
    }
    return out;
}

} // namespace lockstone::cli
