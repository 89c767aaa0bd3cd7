// A match that hundreds of spectators watch through a relay: the machines that host it, the relay, and the spectators.
#pragma once

#include "lockstone/session/spectator_relay.h"
#include "session/join/join_net.h"
#include "session/timeline.h"

namespace lockstone::test {

/// Three machines play. The first two are hosts of the relay.
class RelayedMatch {
  public:
    struct Watcher {
        Arena arena{3};
        Timeline timeline;
        std::unique_ptr<Session> session;
        std::unique_ptr<SessionRunner> runner;
        std::vector<Notice> notices;
        bool reads = true;
    };
    static constexpr PeerId relay_up = 2; ///< on the hosts' network
    static constexpr std::uint64_t near =
        120; ///< the most ticks that a spectator in sync may be behind: two bad links in a row

    explicit RelayedMatch(std::uint32_t watchers_max, SpectatorRelayDef how = {.hosts = {0, 1}})
        : match({.machines = 3, .disconnect_ms = 1000, .link = bad}), upper(3, bad, 5),
          lower(watchers_max + 1, bad, 6) {
        def.content_id = 7;
        def.input_size = input_size_of<Pad>;
        def.players = {0, 1, 2};
        for (PeerId id = 0; id < 2; ++id) {
            hosts.push_back(std::make_unique<SpectatorHost>(def, upper.endpoint(id)));
            hosts[id]->set_states(&match.machine(id).runner->inspector());
        }
        relay = make_spectator_relay(def, how, upper.endpoint(relay_up), lower.endpoint(0)).value();
    }
    Watcher& watch(bool from_state) {
        Watcher& w = *watchers.emplace_back(std::make_unique<Watcher>());
        w.timeline.begins_late = from_state;
        w.session = make_spectator_session(def, WatchDef{.hosts = {0}, .from_state = from_state},
                                           lower.endpoint(static_cast<PeerId>(watchers.size())))
                        .value();
        w.runner = std::make_unique<SessionRunner>(*w.session, w.arena, RunnerDef{&w.timeline});
        return w;
    }
    void run(int frames) {
        for (int i = 0; i < frames; ++i) {
            match.frame();
            upper.advance_to(match.now_ms);
            lower.advance_to(match.now_ms);
            for (PeerId id = 0; id < 2; ++id) {
                if (match.machine(id).session == nullptr) continue;
                show_ticks(*hosts[id], match.machine(id).timeline, 3, shown[id]);
                hosts[id]->poll();
            }
            relay->poll();
            for (const auto& w : watchers) {
                if (!w->reads) continue;
                w->runner->frame(match.now_ms);
                while (const auto notice = w->session->next_notice()) w->notices.push_back(*notice);
            }
        }
    }
    /// The machine crashes, and stops hosting.
    void lose(PeerId id) {
        hosts[id]->set_states(nullptr);
        match.crash(id);
        upper.unplug(id);
    }
    /// Returns how many ticks the spectator is behind machine 2; `never` if it has seen another match.
    std::uint64_t behind(const Watcher& w) const {
        const Timeline& played = match.machines[2]->timeline;
        if (w.timeline.ticks.empty() || w.timeline.end() > played.end() || !w.timeline.agrees(played))
            return session::never;
        return played.end() - w.timeline.end();
    }
    std::uint64_t furthest_behind() const {
        std::uint64_t most = 0;
        for (const auto& w : watchers)
            if (w->reads) most = std::max(most, behind(*w));
        return most;
    }

    static constexpr LinkDef bad{.latency_ms = 50, .jitter_ms = 20, .loss_permille = 50};
    Match match;
    SimulatedNetwork upper, lower;
    SessionDef def;
    std::vector<std::unique_ptr<SpectatorHost>> hosts;
    std::unique_ptr<SpectatorRelay> relay;
    std::vector<std::unique_ptr<Watcher>> watchers;

  private:
    std::array<std::size_t, 2> shown{};
};

} // namespace lockstone::test
