#include "cli/match/match.h"

#include "cli/match/event_law.h"
#include "cli/text.h"
#include "lockstone/math/random.h"
#include "lockstone/session/join.h"
#include "lockstone/session/spectator.h"
#include "lockstone/session/spectator_relay.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <bit>
#include <memory>

namespace lockstone::cli {
namespace {

/// A world that a session drives. It can flip a bit of its own state after a given tick (`planted_at`).
class PlayedWorld final : public Simulation {
  public:
    PlayedWorld(World& driven, const Game& game) : world(driven), simulation(driven, game) {}
    void save(Image& image) const override { simulation.save(image); }
    void restore(const Image& image) override { simulation.restore(image); }
    void advance(std::span<const PlayerInput> inputs) override {
        const std::uint64_t tick = world.tick_count();
        simulation.advance(inputs);
        if (tick == planted_at) flip();
    }
    std::uint64_t hash() const override { return simulation.hash(); }
    std::span<const Event> events() const override { return simulation.events(); }
    State& state() override { return simulation.state(); }
    Status adopt_at(std::uint64_t tick, std::span<const std::byte> image) override {
        Status taken = simulation.adopt_at(tick, image);
        if (taken && on_adopt) on_adopt();
        return taken;
    }
    /// Runs the tick without the flipped bit. The result then differs from the tick as it was played, and the report
    /// shows it.
    std::optional<Rerun> run_aside(const Image& before, std::span<const PlayerInput> inputs) override {
        return simulation.run_aside(before, inputs);
    }
    void record_phase_hashes(bool on) override { simulation.record_phase_hashes(on); }
    std::span<const PhaseHash> phase_hashes() const override { return simulation.phase_hashes(); }

    std::optional<std::uint64_t> planted_at = {}; ///< the tick after which a bit flips; empty: never
    std::function<void()> on_adopt = {};          ///< called after a state from outside was adopted

  private:
    void flip() {
        const StateLayout& layout = state().layout();
        const ColumnInfo* column = layout.find_column("body.velocity");
        state().edit_bytes(static_cast<std::uint32_t>(column - layout.columns().data()), 0, 1)[0] ^=
            std::byte{1};
    }

    World& world;
    WorldSimulation simulation;
};

/// Messages count machines from 1.
std::string machine_name(PeerId id) { return "machine " + std::to_string(id + 1); }

/// Everything that belongs to one machine. It must not be moved: its parts hold references to each other.
struct Peer {
    Peer(World start, const Game& game) : world(std::move(start)), simulation(world, game) {}

    World world;
    PlayedWorld simulation;
    replay::MemorySink sink;
    std::unique_ptr<ConfirmedLog> log;
    /// Set for peer 0 if the match has watchers; set for peer 1 too if they use a relay or if peer 0 crashes.
    std::unique_ptr<SpectatorHost> host;
    std::unique_ptr<Session> session;
    std::unique_ptr<SessionRunner> runner;
    EventLaw events;
    std::uint32_t differs = 0; ///< bit p: peer p reported another hash
    bool gave_way = false;     ///< it dropped its state and joined again
    std::uint32_t wait_frames = 0;
    std::uint64_t awake_at_ms = 0;
};

/// A machine that watches.
struct Watcher final : ConfirmedSink {
    Watcher(World start, const Game& game, PeerId id)
        : world(std::move(start)), simulation(world, game), self(id) {}
    void on_confirmed(std::uint64_t, std::span<const PlayerInput>, std::uint64_t hash) override {
        hashes.push_back(hash);
    }

    World world;
    WorldSimulation simulation;
    PeerId self;
    std::vector<std::uint64_t> hashes; ///< by tick
    std::unique_ptr<Session> session;
    std::unique_ptr<SessionRunner> runner;
};

SessionDef session_of(const Game& game, const MatchDef& def, PeerId self) {
    std::vector<PeerId> players(game.player_count());
    for (PeerId p = 0; p < players.size(); ++p) players[p] = p;
    SessionDef session = session_def(game, self, players);
    if (def.input_delay != 0) session.input_delay = def.input_delay;
    session.run_ahead = def.run_ahead;
    for (PeerId p = game.player_count() - def.late; p < players.size(); ++p) session.absent |= 1u << p;
    return session;
}

/// Peer ids on the watchers' network: 0 is peer 0 or the relay, 1 to `watchers` are the watchers, the next one is peer
/// 1.
PeerId second_host(const MatchDef& def) { return def.watchers + 1; }

WatchDef watch_def(const MatchDef& def) {
    WatchDef watch{.hosts = {0}};
    if (def.host_crashes && !def.relayed) watch.hosts.push_back(second_host(def));
    return watch;
}

Result<std::unique_ptr<Watcher>> make_watcher(const Game& game, const MatchDef& def, PeerId self,
                                              Transport& transport) {
    Result<World> world = game.start();
    if (!world) return world.error();
    auto watcher = std::make_unique<Watcher>(std::move(*world), game, self);
    Result<std::unique_ptr<Session>> session =
        make_spectator_session(session_of(game, def, self), watch_def(def), transport);
    if (!session) return session.error();
    watcher->session = std::move(*session);
    watcher->runner =
        std::make_unique<SessionRunner>(*watcher->session, watcher->simulation, RunnerDef{watcher.get()});
    return watcher;
}

Result<replay::InputRecorder> begin_recording(Peer& peer, const Game& game, const MatchDef& def,
                                              PeerId self) {
    replay::RecorderOptions options;
    options.options = {{"match.peer", std::to_string(self + 1)}, {"match.seed", std::to_string(def.seed)}};
    return replay::InputRecorder::begin(peer.sink, game, peer.world, options);
}

bool shows_the_match(const MatchDef& def, PeerId self) {
    return def.watchers > 0 && (self == 0 || (self == 1 && (def.relayed || def.host_crashes)));
}

Result<std::unique_ptr<Peer>> make_peer(const Game& game, const MatchDef& def, PeerId self,
                                        Transport& transport, Transport& to_watchers) {
    Result<World> world = game.start();
    if (!world) return world.error();
    auto peer = std::make_unique<Peer>(std::move(*world), game);
    if (def.planted && self == game.player_count() - def.late - 1)
        peer->simulation.planted_at = def.ticks / 2;
    peer->log = std::make_unique<ConfirmedLog>(def.ticks);
    peer->log->record(begin_recording(*peer, game, def, self));

    const SessionDef as_player = session_of(game, def, self);
    Result<std::unique_ptr<Session>> session = def.mode == MatchMode::rollback
                                                   ? make_rollback_session(as_player, transport)
                                                   : make_lockstep_session(as_player, transport);
    if (!session) return session.error();
    peer->session = std::move(*session);
    ConfirmedSink* sink = peer->log.get();
    if (shows_the_match(def, self)) {
        const SpectatorHostDef host_def{.watchers_max = def.watchers};
        peer->host = std::make_unique<SpectatorHost>(as_player, to_watchers, host_def, peer->log.get());
        sink = peer->host.get();
    }
    peer->runner = std::make_unique<SessionRunner>(*peer->session, peer->simulation, RunnerDef{sink});
    if (peer->host) peer->host->set_states(&peer->runner->inspector());
    return peer;
}

/// A machine that joins a running match and has no state of it yet.
Result<std::unique_ptr<Peer>> make_joining_peer(const Game& game, const MatchDef& def, PeerId self,
                                                std::uint32_t life, Transport& transport) {
    Result<World> world = game.start();
    if (!world) return world.error();
    auto peer = std::make_unique<Peer>(std::move(*world), game);
    peer->log = std::make_unique<ConfirmedLog>(def.ticks);
    peer->simulation.on_adopt = [of = peer.get(), &game, &def, self] {
        of->log->record(begin_recording(*of, game, def, self));
    };
    const JoinDef join{.life = life, .lockstep = def.mode == MatchMode::lockstep};
    Result<std::unique_ptr<Session>> session =
        make_join_session(session_of(game, def, self), join, transport);
    if (!session) return session.error();
    peer->session = std::move(*session);
    peer->runner =
        std::make_unique<SessionRunner>(*peer->session, peer->simulation, RunnerDef{peer->log.get()});
    return peer;
}

/// Between two crashes, and between a crash and the return of that machine.
constexpr std::uint64_t frames_between = 900, frames_away = 120;

/// Lets late machines join. Lets one machine after another lose its state and join again.
Status come_and_go(std::vector<std::unique_ptr<Peer>>& peers, const Game& game, const MatchDef& def,
                   std::uint64_t frame, SimulatedNetwork& network) {
    const auto join = [&](PeerId id, std::uint32_t life) -> Status {
        Result<std::unique_ptr<Peer>> peer = make_joining_peer(game, def, id, life, network.endpoint(id));
        if (!peer) return peer.error();
        peers[id] = std::move(*peer);
        return {};
    };
    for (std::uint32_t n = 0; n < def.late; ++n)
        if (frame == def.first_late + n * 60)
            if (Status s = join(game.player_count() - def.late + n, 1); !s) return s;
    const std::uint32_t who = game.player_count() - def.late - 1;
    for (std::uint32_t n = 0; n < def.rejoins && who > 0; ++n) {
        const std::uint64_t at = def.first_crash + n * frames_between;
        const PeerId id = def.host_crashes && n == 0 ? 0 : 1 + n % who;
        if (frame == at) peers[id] = nullptr;
        if (frame == at + frames_away)
            if (Status s = join(id, n + 1); !s) return s;
    }
    return {};
}

/// Runs one frame of one machine: adds the player's input, polls the session, handles its notices.
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
        for (const SessionEvent& event : peer.runner->events()) peer.events.see(event);
    }
    std::vector<std::string>& desyncs = def.recovers ? out.notes : out.broken;
    while (const auto notice = peer.session->next_notice()) {
        if (const auto* named = std::get_if<DesyncNamed>(&*notice))
            desyncs.push_back(machine_name(self) + ": " + to_string(*named->report));
        if (const auto* stopped = std::get_if<MatchStopped>(&*notice))
            out.notes.push_back(machine_name(self) + ": " + stopped->reason);
        if (const auto* gone = std::get_if<PlayerDisconnected>(&*notice)) {
            out.departures.push_back({self, gone->peer, gone->tick});
            out.notes.push_back(machine_name(self) + ": player " + std::to_string(gone->player + 1) +
                                " left at tick " + std::to_string(gone->tick) + ", at " +
                                std::to_string(now_ms) + " ms");
        }
        if (const auto* desync = std::get_if<Desync>(&*notice)) {
            peer.differs |= 1u << desync->peer;
            desyncs.push_back(machine_name(self) + " and " + machine_name(desync->peer) +
                              " differ after tick " + std::to_string(desync->tick) +
                              ": lower half of the hash " + half_hash_text(desync->local) + " against " +
                              half_hash_text(desync->remote));
        }
    }
}

/// Machines that are compared. A machine that joins counts once it has confirmed a tick; a machine that recovers counts
/// at once.
std::uint32_t count_voters(const std::vector<std::unique_ptr<Peer>>& peers) {
    return static_cast<std::uint32_t>(std::ranges::count_if(peers, [](const auto& peer) {
        return peer != nullptr && (!peer->log->hashes.empty() || peer->gave_way);
    }));
}

/// True if a machine has to drop its state: it differs from more than half of the others, or it is the second of two.
bool is_outvoted(std::uint32_t differs, PeerId self, std::uint32_t machines) {
    if (machines == 2) return differs != 0 && self != 0;
    return 2 * static_cast<std::uint32_t>(std::popcount(differs)) > machines - 1;
}

/// Recovery: a machine that differs from the majority drops its state and joins again with the state of the others.
Status recover(std::vector<std::unique_ptr<Peer>>& peers, const Game& game, const MatchDef& def,
               SimulatedNetwork& network, MatchOutcome& out) {
    constexpr std::uint32_t lives_before = 1000; // more than the lives that crashes use
    const std::uint32_t voters = count_voters(peers);
    for (PeerId id = 0; id < peers.size(); ++id) {
        if (peers[id] == nullptr || !is_outvoted(peers[id]->differs, id, voters)) continue;
        Result<std::unique_ptr<Peer>> peer =
            make_joining_peer(game, def, id, lives_before + ++out.recoveries, network.endpoint(id));
        if (!peer) return peer.error();
        peers[id] = std::move(*peer);
        peers[id]->gave_way = true;
    }
    return {};
}

/// The ticks that all peers and all watchers have confirmed.
std::uint64_t ticks_confirmed(const std::vector<std::unique_ptr<Peer>>& peers,
                              const std::vector<std::unique_ptr<Watcher>>& watchers) {
    std::uint64_t least = ~std::uint64_t{0};
    for (const auto& peer : peers)
        least =
            std::min<std::uint64_t>(least, peer == nullptr ? 0 : peer->log->first + peer->log->hashes.size());
    for (const auto& watcher : watchers) least = std::min<std::uint64_t>(least, watcher->hashes.size());
    return least;
}

LinkDef link_of(const MatchDef& def, PeerId from, PeerId to, std::uint32_t machines) {
    return def.links.empty() ? def.link : def.links[std::size_t{from} * machines + to];
}

/// The number of frames that a machine has begun by its own clock, at a frame of the true clock.
std::uint64_t frames_by_own_clock(const MatchDef& def, PeerId id, std::uint64_t frame) {
    const std::int32_t faster = def.clock_permille.empty() ? 0 : def.clock_permille[id];
    return (frame + 1) * static_cast<std::uint64_t>(1000 + faster) / 1000;
}

/// How many ticks a session may roll back. Without machines that come back this is prediction_max. A machine that comes
/// back has announced its first 30 inputs before it receives inputs of the others, so these inputs do not stall the
/// others. If the next machine leaves meanwhile, its inputs end at the tick at which the first one joined. Then only
/// the stall limits the rollback: to twice prediction_max and 8 ticks beyond the last confirmed tick.
std::uint64_t depth_limit(const Game& game, const MatchDef& def) {
    constexpr std::uint64_t polls_between = 8; // of the stall
    const std::uint64_t guesses = session_of(game, def, 0).prediction_max;
    return def.rejoins == 0 && !def.recovers ? guesses : 2 * guesses + polls_between;
}

/// Now and then pauses a machine or cuts a link. Two troubles are at least two seconds apart: several at once would
/// last longer than a session waits, and the session would then drop a machine.
class Trouble {
  public:
    Trouble(const MatchDef& of, std::uint32_t machines_in_all)
        : def(of), machines(machines_in_all), random(Random::seeded(of.seed)) {}
    void come(std::vector<std::unique_ptr<Peer>>& peers, SimulatedNetwork& network, std::uint64_t now_ms) {
        if (is_cut && now_ms >= over_at_ms) cut(network, false);
        constexpr std::uint32_t one_in_frames = 60, sleep_max_ms = 500, cut_max_ms = 2000;
        constexpr std::uint64_t quiet_ms = 2000;
        if ((!def.sleeps && !def.cuts) || now_ms < over_at_ms + quiet_ms || random.below(one_in_frames) != 0)
            return;
        who = random.below(machines);
        const bool sleeps = def.sleeps && (!def.cuts || random.below(2) == 0);
        over_at_ms = now_ms + random.below(sleeps ? sleep_max_ms : cut_max_ms);
        if (!sleeps)
            cut(network, true);
        else if (peers[who] != nullptr)
            peers[who]->awake_at_ms = over_at_ms;
    }

  private:
    /// Cuts or restores the link from `who` to the next machine.
    void cut(SimulatedNetwork& network, bool off) {
        const PeerId other = (who + 1) % machines;
        LinkDef link = link_of(def, who, other, machines);
        if (off) link.loss_permille = 1000;
        network.set_link(who, other, link);
        is_cut = off;
    }

    const MatchDef& def;
    std::uint32_t machines;
    Random random;
    std::uint64_t over_at_ms = 0; ///< end of the last trouble
    PeerId who = 0;
    bool is_cut = false;
};

/// The way from the match to its watchers: peer 0 directly (and peer 1 if peer 0 crashes), or a relay that fetches the
/// match from peers 0 and 1.
struct Show {
    PeerId second; ///< id of peer 1 among watchers without a relay; 0 if it does not show the match
    SimulatedNetwork to_hosts, to_watchers;
    std::unique_ptr<SpectatorRelay> relay; ///< null: no relay
    static constexpr PeerId relay_up = 2;

    explicit Show(const MatchDef& def)
        : second(def.host_crashes ? second_host(def) : 0), to_hosts(3, def.link, def.seed ^ 0x5eed),
          to_watchers(def.watchers + (def.host_crashes ? 2 : 1), def.link, ~def.seed) {}
    Status begin(const Game& game, const MatchDef& def) {
        if (!def.relayed || def.watchers == 0) return {};
        Result<std::unique_ptr<SpectatorRelay>> made =
            make_spectator_relay(session_of(game, def, 0), {.hosts = {0, 1}, .state_polls = 600},
                                 to_hosts.endpoint(relay_up), to_watchers.endpoint(0));
        if (!made) return made.error();
        relay = std::move(*made);
        return {};
    }
    Transport& of_host(PeerId self) {
        if (relay) return to_hosts.endpoint(self == 0 ? 0 : 1);
        return to_watchers.endpoint(self == 1 ? second : 0);
    }
    void run(const std::vector<std::unique_ptr<Peer>>& peers, const MatchDef& def, std::uint64_t frame,
             std::uint64_t now_ms) {
        to_hosts.advance_to(now_ms);
        if (relay && def.show_lost != 0 && frame == def.show_lost) to_hosts.unplug(0);
        for (const auto& peer : peers)
            if (peer != nullptr && peer->host) peer->host->poll();
        if (relay) relay->poll();
    }
};

/// Adds one watcher after each pause and reports every desync that the watchers find.
Status run_watchers(std::vector<std::unique_ptr<Watcher>>& watchers, const Game& game, const MatchDef& def,
                    std::uint64_t frame, SimulatedNetwork& network, MatchOutcome& out) {
    constexpr std::uint64_t frames_apart = 150;
    if (watchers.size() < def.watchers && frame >= watchers.size() * frames_apart) {
        const PeerId id = static_cast<PeerId>(watchers.size() + 1);
        Result<std::unique_ptr<Watcher>> watcher = make_watcher(game, def, id, network.endpoint(id));
        if (!watcher) return watcher.error();
        watchers.push_back(std::move(*watcher));
    }
    network.advance_to(out.milliseconds);
    for (const auto& watcher : watchers) {
        watcher->runner->frame(out.milliseconds);
        while (const auto notice = watcher->session->next_notice())
            if (const auto* desync = std::get_if<Desync>(&*notice))
                out.broken.push_back("watcher " + std::to_string(watcher->self) + " differs after tick " +
                                     std::to_string(desync->tick));
    }
    return {};
}

/// Empty if the peer confirmed no tick because it joined when the others had finished.
std::vector<std::byte> recording_of(Peer& peer) {
    return peer.log->hashes.empty() ? std::vector<std::byte>{} : std::move(peer.sink.bytes);
}

/// A message that says how far each machine came in a match that did not end.
std::string not_through(const std::vector<std::unique_ptr<Peer>>& peers, const MatchOutcome& out,
                        const MatchDef& def, std::uint64_t frames) {
    std::string told = "seed " + std::to_string(def.seed) + ": the match has not ended after " +
                       std::to_string(frames) + " frames";
    for (std::size_t p = 0; p < peers.size(); ++p)
        told += ", " + machine_name(static_cast<PeerId>(p)) +
                (peers[p] == nullptr
                     ? std::string(" is absent")
                     : " is at tick " + std::to_string(peers[p]->session->current_tick()) + " with " +
                           std::to_string(peers[p]->log->hashes.size()) + " confirmed");
    for (const std::string& note : out.notes) told += "\n  " + note;
    return told;
}

} // namespace

void ConfirmedLog::on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) {
    if (tick >= ticks_max && hashes.empty()) first = ticks_max; // it joined when the others had finished
    if (tick >= ticks_max || !state) return;
    if (recorder) state = recorder->on_tick(tick, inputs, hash);
    if (hashes.empty()) first = tick;
    hashes.push_back(hash);
    for (const PlayerInput& input : inputs) {
        inputs_confirmed.push_back(static_cast<std::byte>(input.status));
        inputs_confirmed.insert(inputs_confirmed.end(), input.bytes.begin(), input.bytes.end());
    }
}

void ConfirmedLog::record(Result<replay::InputRecorder> to) {
    if (to)
        recorder = std::move(*to);
    else
        state = to.error();
}

Status ConfirmedLog::close() {
    if (!state) return state;
    return recorder ? recorder->close() : Status();
}

Result<MatchOutcome> play_match(const Game& game, const MatchDef& def,
                                const std::function<void(std::uint64_t)>& progress) {
    SimulatedNetwork network(game.player_count(), def.link, def.seed);
    Show show(def);
    if (Status s = show.begin(game, def); !s) return s.error();
    Trouble trouble(def, game.player_count());
    if (!def.links.empty())
        for (PeerId from = 0; from < game.player_count(); ++from)
            for (PeerId to = 0; to < game.player_count(); ++to)
                network.set_link(from, to, link_of(def, from, to, game.player_count()));
    std::vector<std::uint64_t> frames(game.player_count()); // of each machine's own clock
    std::vector<std::unique_ptr<Watcher>> watchers;
    std::vector<std::unique_ptr<Peer>> peers;
    if (def.late >= game.player_count()) return Error{"match: no machine starts the match; lower --late"};
    peers.resize(game.player_count());
    for (PeerId p = 0; p < game.player_count() - def.late; ++p) {
        Result<std::unique_ptr<Peer>> peer = make_peer(game, def, p, network.endpoint(p), show.of_host(p));
        if (!peer) return peer.error();
        peers[p] = std::move(*peer);
    }
    MatchOutcome out;
    const std::uint64_t rate = peers.front()->world.def().tick_rate;
    const std::uint64_t frames_max = 20 * def.ticks + 60 * rate;
    const std::uint64_t last_back = def.first_crash + frames_away + (def.rejoins - 1) * frames_between,
                        last_late = def.first_late + (def.late - 1) * 60;
    const std::uint64_t last_coming =
        std::max(def.rejoins == 0 ? 0 : last_back + 1, def.late == 0 ? 0 : last_late + 1);
    for (std::uint64_t frame = 0; watchers.size() < def.watchers ||
                                  ticks_confirmed(peers, watchers) < def.ticks || frame < last_coming;
         ++frame) {
        if (frame == frames_max) return Error{not_through(peers, out, def, frames_max)};
        out.milliseconds = frame * 1000 / rate;
        network.advance_to(out.milliseconds);
        trouble.come(peers, network, out.milliseconds);
        if (Status s = come_and_go(peers, game, def, frame, network); !s) return s.error();
        for (PeerId p = 0; p < peers.size(); ++p)
            for (const std::uint64_t due = frames_by_own_clock(def, p, frame); frames[p] < due; ++frames[p])
                if (peers[p] != nullptr && out.milliseconds >= peers[p]->awake_at_ms)
                    run_frame(*peers[p], p, game, def, frames[p] * 1000 / rate, out);
        if (def.recovers)
            if (Status s = recover(peers, game, def, network, out); !s) return s.error();
        if (Status s = run_watchers(watchers, game, def, frame, show.to_watchers, out); !s) return s.error();
        show.run(peers, def, frame, out.milliseconds);
        if (progress) progress(ticks_confirmed(peers, watchers));
    }
    for (auto& peer : peers) {
        if (Status s = peer->log->close(); !s) return s.error();
        if (!peer->events.holds(peer->log->first + peer->log->hashes.size()))
            out.broken.push_back(machine_name(static_cast<PeerId>(out.peers.size())) +
                                 ": an event was reported twice, or was never confirmed or cancelled");
        if (const std::uint64_t depth = peer->session->stats().depth_max; depth > depth_limit(game, def))
            out.broken.push_back(machine_name(static_cast<PeerId>(out.peers.size())) + ": rolled back by " +
                                 std::to_string(depth) + " ticks, but " +
                                 std::to_string(depth_limit(game, def)) + " is the limit");
        out.peers.push_back({recording_of(*peer), peer->log->first, std::move(peer->log->hashes),
                             std::move(peer->log->inputs_confirmed), peer->session->stats()});
    }
    for (auto& watcher : watchers) out.watched.push_back(std::move(watcher->hashes));
    return out;
}

} // namespace lockstone::cli
