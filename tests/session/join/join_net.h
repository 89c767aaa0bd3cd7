// A match that others watch from a recent state on, each machine of which is a host to them.
#pragma once

#include "lockstone/session/spectator.h"
#include "session/match.h"

#include <algorithm>

namespace lockstone::test {

class JoinNet {
  public:
    struct Guest {
        Arena arena;
        Timeline timeline;
        EventLaw events;
        std::vector<Notice> notices;
        std::unique_ptr<Session> session;
        std::unique_ptr<SessionRunner> runner;

        explicit Guest(std::uint32_t players) : arena(players) { timeline.begins_late = true; }
        template <class N> std::vector<N> notices_of() const {
            std::vector<N> found;
            for (const Notice& notice : notices)
                if (const N* n = std::get_if<N>(&notice)) found.push_back(*n);
            return found;
        }
    };
    /// Shows what a machine held, but for what `lie` makes of it.
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

    explicit JoinNet(std::uint32_t of)
        : machines(of), match(as_match(of)), network(of + 8, link(), 3), shown(of) {
        SessionDef d;
        d.content_id = 7;
        d.input_size = input_size_of<Pad>;
        for (PeerId id = 0; id < of; ++id) d.players.push_back(id);
        def = d;
        for (PeerId id = 0; id < of; ++id) {
            states.push_back(std::make_unique<Shown>(*this, id, of));
            hosts.push_back(std::make_unique<SpectatorHost>(def, network.endpoint(id)));
            hosts.back()->set_states(states.back().get());
        }
    }
    Guest& watch(WatchDef how) {
        const PeerId id = machines + static_cast<PeerId>(guests.size());
        Guest& g = *guests.emplace_back(std::make_unique<Guest>(machines));
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
                g->runner->frame(match.now_ms);
                for (const SessionEvent& e : g->runner->events()) g->events.see(e);
                while (const auto notice = g->session->next_notice()) g->notices.push_back(*notice);
            }
        }
    }
    /// How many ticks the guest is behind; `never` where it has seen another match.
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
    static LinkDef link() {
        return {.latency_ms = 60,
                .jitter_ms = 30,
                .loss_permille = 100,
                .duplicate_permille = 20,
                .damage_permille = 10};
    }
    static MatchDef as_match(std::uint32_t of) {
        MatchDef d{.machines = of, .link = {.latency_ms = 50, .jitter_ms = 20, .loss_permille = 50}};
        d.players.clear();
        for (PeerId id = 0; id < of; ++id) d.players.push_back(id);
        return d;
    }
    void show(PeerId id) {
        const std::vector<Timeline::Tick>& ticks = match.machine(id).timeline.ticks;
        for (std::size_t& at = shown[id]; at < ticks.size(); ++at) {
            std::vector<PlayerInput> inputs;
            for (std::size_t p = 0; p < machines; ++p)
                inputs.push_back({std::span(ticks[at].inputs).subspan(p * sizeof(Pad), sizeof(Pad)),
                                  ticks[at].statuses[p]});
            std::uint64_t hash = ticks[at].hash;
            if (lie) { // it stands by its lie
                if (const State* state = states[id]->state_after(at)) hash = state->hash();
            }
            hosts[id]->on_confirmed(at, inputs, hash);
        }
    }
    std::vector<std::unique_ptr<Shown>> states;
    std::vector<std::unique_ptr<SpectatorHost>> hosts;
    std::vector<std::size_t> shown;
};

} // namespace lockstone::test
