// One machine of a match over real sockets: a scene, its world, a session, and its confirmed hashes.
#pragma once

#include "lockstone/net.h"
#include "lockstone/session/join.h"
#include "lockstone/session/spectator.h"
#include "scenes/scenes.h"

namespace lockstone::test {

class NetPlayer final : public ConfirmedSink {
  public:
    /// `shown_to`: the transport of its spectators; null: none. `life`: how often it has come back without any state.
    NetPlayer(const Game& rules, PeerId self, std::uint32_t players, Transport& transport,
              Transport* shown_to = nullptr, std::uint32_t life = 0)
        : game(rules), slot(self), world(rules.start().value()), simulation(world, rules) {
        std::vector<PeerId> machines(players);
        for (PeerId p = 0; p < players; ++p) machines[p] = p;
        const SessionDef def = session_def(game, self, machines);
        session = life == 0 ? make_rollback_session(def, transport).value()
                            : make_join_session(def, {.life = life}, transport).value();
        if (shown_to != nullptr)
            host = std::make_unique<SpectatorHost>(def, *shown_to, SpectatorHostDef{}, this);
        ConfirmedSink* sink = this;
        if (host) sink = host.get();
        runner = std::make_unique<SessionRunner>(*session, simulation, RunnerDef{sink});
        if (host) host->set_states(&runner->inspector());
    }
    NetPlayer(const NetPlayer&) = delete;
    NetPlayer& operator=(const NetPlayer&) = delete;

    /// One frame at 60 Hz. It begins no ticks beyond `ticks_max`, but settles those that have begun.
    void frame(std::uint64_t now_ms, std::uint64_t ticks_max) {
        if (session->current_tick() >= ticks_max) {
            runner->drain(now_ms);
        } else if (waits > 0) {
            --waits;
            runner->wait(now_ms);
        } else {
            std::vector<std::byte> input(game.input_size());
            scripted_input(game, 1, session->current_tick(), slot, input);
            session->add_local_input(slot, input);
            waits = runner->frame(now_ms).wait_ticks;
        }
        if (host) host->poll();
        while (const auto notice = session->next_notice()) {
            desynced = desynced || std::holds_alternative<Desync>(*notice);
            lost = lost || std::holds_alternative<PlayerDisconnected>(*notice) ||
                   std::holds_alternative<MatchStopped>(*notice);
        }
    }
    std::vector<std::uint64_t> hashes; ///< of confirmed ticks
    std::uint64_t first = 0;           ///< the first of these ticks
    std::uint64_t end() const { return first + hashes.size(); }
    bool desynced = false, lost = false;
    const SessionStats& stats() const { return session->stats(); }

  private:
    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput>, std::uint64_t hash) override {
        if (hashes.empty()) first = tick;
        hashes.push_back(hash);
    }
    const Game& game;
    PeerId slot;
    World world;
    WorldSimulation simulation;
    std::unique_ptr<Session> session;
    std::unique_ptr<SpectatorHost> host;
    std::unique_ptr<SessionRunner> runner;
    std::uint32_t waits = 0;
};

} // namespace lockstone::test
