// A match in which every machine is a host for spectators, which begin with a recent state.
#pragma once

#include "lockstone/session/spectator.h"
#include "session/match.h"

#include <algorithm>
#include <optional>

namespace lockstone::test {

/// Gives a host all ticks that a machine has confirmed since tick `shown`. `lie(tick)` may return another hash.
template <class Lie>
void show_ticks(SpectatorHost& host, const Timeline& played, std::size_t players, std::size_t& shown,
                Lie&& lie) {
    for (; shown < played.ticks.size(); ++shown) {
        const Timeline::Tick& tick = played.ticks[shown];
        std::vector<PlayerInput> inputs;
        for (std::size_t p = 0; p < players; ++p)
            inputs.push_back(
                {std::span(tick.inputs).subspan(p * sizeof(Pad), sizeof(Pad)), tick.statuses[p]});
        const std::optional<std::uint64_t> other = lie(shown);
        host.on_confirmed(shown, inputs, other.value_or(tick.hash));
    }
}
inline void show_ticks(SpectatorHost& host, const Timeline& played, std::size_t players, std::size_t& shown) {
    show_ticks(host, played, players, shown, [](std::uint64_t) { return std::optional<std::uint64_t>(); });
}

class JoinNet {
  public:
    struct Guest {
        Arena arena;
        Timeline timeline;
        EventLaw events;
        std::vector<Notice> notices;
        std::unique_ptr<Session> session;
        std::unique_ptr<SessionRunner> runner;
        bool is_there = true;

        Guest(std::uint32_t players, bool from_state) : arena(players) { timeline.begins_late = from_state; }
        template <class N> std::vector<N> notices_of() const {
            std::vector<N> found;
            for (const Notice& notice : notices)
                if (const N* n = std::get_if<N>(&notice)) found.push_back(*n);
            return found;
        }
    };
    /// Returns the states that a machine held, changed by `lie`.
    struct Shown final : StateInspector {
        JoinNet& net;
        PeerId from;
        Arena arena;
        Shown(JoinNet& of, PeerId id, std::uint32_t players) : net(of), from(id), arena(players) {}
        const State* state_after(std::uint64_t tick) override {
            const State* state = net.match.machine(from).runner->inspector().state_after(tick);
            if (state == nullptr) return nullptr;
            arena.state() = *state;
            if (net.lie) net.lie(from, arena);
            return &arena.state();
        }
        Rerun run_again(std::uint64_t, std::span<const PlayerInput>) override { return {}; }
    };

    explicit JoinNet(std::uint32_t of, SpectatorHostDef host_def = {})
        : machines(of), match(as_match(of)), network(of + 8, lossy, 3), shown(of) {
        def.content_id = 7;
        def.input_size = input_size_of<Pad>;
        for (PeerId id = 0; id < of; ++id) def.players.push_back(id);
        for (PeerId id = 0; id < of; ++id) {
            states.push_back(std::make_unique<Shown>(*this, id, of));
            hosts.push_back(std::make_unique<SpectatorHost>(def, network.endpoint(id), host_def));
            hosts.back()->set_states(states.back().get());
        }
    }
    Guest& watch(WatchDef how) {
        const PeerId id = machines + static_cast<PeerId>(guests.size());
        Guest& g = *guests.emplace_back(std::make_unique<Guest>(machines, how.from_state));
        g.session = make_spectator_session(def, std::move(how), network.endpoint(id)).value();
        g.runner = std::make_unique<SessionRunner>(*g.session, g.arena, RunnerDef{&g.timeline});
        return g;
    }
    void run(int frames) {
        for (int i = 0; i < frames; ++i) {
            match.frame();
            network.advance_to(match.now_ms);
            for (PeerId id = 0; id < machines; ++id) {
                show(id);
                hosts[id]->poll();
            }
            for (const auto& g : guests) {
                if (!g->is_there) continue;
                g->runner->frame(match.now_ms);
                for (const SessionEvent& e : g->runner->events()) g->events.see(e);
                while (const auto notice = g->session->next_notice()) g->notices.push_back(*notice);
            }
        }
    }
    SpectatorHost& host(PeerId id) { return *hosts[id]; }
    /// Returns how many ticks the guest is behind; `never` if it has seen another match.
    std::uint64_t behind(const Guest& g) const {
        const Timeline& played = match.machines[0]->timeline;
        if (!g.timeline.agrees(played) || g.timeline.end() > played.end()) return ~std::uint64_t{0};
        return played.end() - g.timeline.end();
    }

    std::uint32_t machines;
    Match match;
    SimulatedNetwork network;
    SessionDef def;
    std::function<void(PeerId, Arena&)> lie;
    std::vector<std::unique_ptr<Guest>> guests;

  private:
    static MatchDef as_match(std::uint32_t of) {
        return {.machines = of, .link = {.latency_ms = 50, .jitter_ms = 20, .loss_permille = 50}};
    }
    void show(PeerId id) {
        show_ticks(*hosts[id], match.machine(id).timeline, machines, shown[id], [&](std::uint64_t tick) {
            const State* state =
                lie ? states[id]->state_after(tick) : nullptr; // the inspector repeats its lie
            return state != nullptr ? std::optional(state->hash()) : std::nullopt;
        });
    }
    std::vector<std::unique_ptr<Shown>> states;
    std::vector<std::unique_ptr<SpectatorHost>> hosts;
    std::vector<std::size_t> shown;
};

} // namespace lockstone::test
