// Whole matches in one process: N machines on a simulated network, driven frame by frame at 60 frames a second.
#pragma once

#include "cli/match/event_law.h"
#include "lockstone/session/forgetful.h"
#include "lockstone/session/join.h"
#include "session/arena.h"

#include <algorithm>
#include <functional>
#include <map>
#include <ranges>

namespace lockstone::test {

using cli::EventLaw;

/// Keeps the confirmed timeline, and detects ticks that are out of order.
class Timeline final : public ConfirmedSink {
  public:
    struct Tick {
        std::vector<std::byte> inputs;
        std::vector<InputStatus> statuses;
        std::uint64_t hash;
        friend bool operator==(const Tick&, const Tick&) = default;
    };
    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) override {
        if (ticks.empty() && begins_late) first = tick;
        in_order = in_order && tick == end();
        Tick& kept = ticks.emplace_back();
        kept.hash = hash;
        for (const PlayerInput& input : inputs) {
            kept.inputs.insert(kept.inputs.end(), input.bytes.begin(), input.bytes.end());
            kept.statuses.push_back(input.status);
        }
    }
    std::vector<Tick> ticks;
    std::uint64_t first = 0;  ///< the first tick
    bool begins_late = false; ///< `first` may be any tick
    bool in_order = true;
    std::uint64_t end() const { return first + ticks.size(); }
    /// Returns whether both are equal in all ticks that both have.
    bool agrees(const Timeline& other) const {
        for (std::uint64_t t = std::max(first, other.first); t < std::min(end(), other.end()); ++t)
            if (ticks[t - first] != other.ticks[t - other.first]) return false;
        return in_order && other.in_order;
    }
};

/// A link with every fault of networks.
inline constexpr LinkDef lossy{.latency_ms = 60,
                               .jitter_ms = 30,
                               .loss_permille = 100,
                               .duplicate_permille = 20,
                               .reorder_permille = 20,
                               .damage_permille = 10};

struct MatchDef {
    std::vector<PeerId> players = {}; ///< by player: its machine; empty: one player on each machine
    std::uint32_t machines = 2;
    bool lockstep = false;
    std::uint32_t input_delay = 2;
    std::uint32_t prediction_max = 8;
    std::uint64_t disconnect_ms = 5000;
    LinkDef link{};
    std::uint64_t connect_ms = 30'000;
    std::uint32_t absent = 0; ///< of SessionDef; those machines do nothing before Match::join
    std::function<Transport&(PeerId, Transport&)> through =
        {};             ///< wraps the network's endpoint of a machine; empty: no wrapper
    bool record = true; ///< keep timelines and check events: both allocate
    std::uint64_t seed = 1;
    std::uint32_t inspected_ticks = 64; ///< of RunnerDef
    std::uint32_t run_ahead = 0;
    std::uint32_t noise_bytes = 0;    ///< bytes after the pad in each input; they change every tick
    std::string column_left_out = {}; ///< of ForgetfulSimulation
};

inline MatchDef completed(MatchDef def) {
    const bool is_one_each = def.players.empty();
    for (PeerId id = 0; is_one_each && id < def.machines; ++id) def.players.push_back(id);
    return def;
}

class Match {
  public:
    struct Machine {
        std::unique_ptr<Session> session; ///< null: the machine is absent
        std::unique_ptr<Simulation> simulation;
        std::unique_ptr<testing::ForgetfulSimulation> driven; ///< wraps `simulation` for the runner
        Timeline timeline;
        EventLaw events;
        std::vector<Notice> notices;
        std::unique_ptr<SessionRunner> runner;
        std::uint32_t frames_to_wait = 0;
        std::vector<Timeline> lives_before;
    };

    /// `make_simulation(peer)` returns the simulation of a machine.
    template <class Make>
    Match(const MatchDef& match_def, Make&& make)
        : def(completed(match_def)), network(match_def.machines, match_def.link, match_def.seed),
          make_simulation(make) {
        for (PeerId id = 0; id < def.machines; ++id) {
            Machine& m = *machines.emplace_back(std::make_unique<Machine>());
            bool is_absent = false;
            for (std::size_t p = 0; p < def.players.size(); ++p)
                is_absent = is_absent || (def.players[p] == id && (def.absent >> p & 1u) != 0);
            if (is_absent) continue;
            Transport& transport = transport_of(id);
            m.session = (def.lockstep ? make_lockstep_session(session_def_of(id), transport)
                                      : make_rollback_session(session_def_of(id), transport))
                            .value();
            start(m, id);
        }
    }
    SessionDef session_def_of(PeerId id) const {
        SessionDef session_def;
        session_def.content_id = 7;
        session_def.input_size = input_size_of<Pad> + def.noise_bytes;
        session_def.self = id;
        session_def.players = def.players;
        session_def.absent = def.absent;
        session_def.input_delay = def.input_delay;
        session_def.prediction_max = def.prediction_max;
        session_def.disconnect_ms = def.disconnect_ms;
        session_def.connect_ms = def.connect_ms;
        session_def.run_ahead = def.run_ahead;
        return session_def;
    }
    Transport& transport_of(PeerId id) {
        Transport& wire = network.endpoint(id);
        return def.through ? def.through(id, wire) : wire;
    }
    /// The machine ends at once. Only its confirmed timeline remains.
    void crash(PeerId id) {
        const Timeline before = machines[id]->timeline;
        std::vector<Timeline> lives = std::move(machines[id]->lives_before);
        lives.push_back(before);
        machines[id] = std::make_unique<Machine>();
        machines[id]->lives_before = std::move(lives);
    }
    /// An absent machine joins late, or comes back.
    void join(PeerId id, std::uint32_t life = 1) {
        Machine& m = *machines[id];
        m.timeline.begins_late = true;
        m.session =
            make_join_session(session_def_of(id), {.life = life, .lockstep = def.lockstep}, transport_of(id))
                .value();
        start(m, id);
    }
    explicit Match(const MatchDef& match_def)
        : Match(match_def, [players = static_cast<std::uint32_t>(completed(match_def).players.size())](
                               PeerId) { return std::make_unique<Arena>(players); }) {}

    /// One frame of every machine. Machines in `asleep` (bits) do nothing.
    void frame(std::uint32_t asleep = 0) {
        ++frames;
        now_ms = frames * 1000 / 60;
        network.advance_to(now_ms);
        for (PeerId id = 0; id < def.machines; ++id) {
            if ((asleep >> id & 1u) == 0) frame_of(id);
        }
    }
    void frame_of(PeerId id) {
        Machine& m = *machines[id];
        if (m.session == nullptr) return;
        if (m.frames_to_wait > 0) {
            --m.frames_to_wait;
            m.runner->wait(now_ms);
            return;
        }
        for (std::uint32_t p = 0; p < def.players.size(); ++p) {
            if (def.players[p] == id)
                m.session->add_local_input(p, scripted_input(p, m.session->current_tick()));
        }
        m.frames_to_wait = m.runner->frame(now_ms).wait_ticks;
        if (def.record) {
            for (const SessionEvent& e : m.runner->events()) m.events.see(e);
        }
        while (const auto notice = m.session->next_notice()) m.notices.push_back(*notice);
    }
    /// A frame in which all machines poll and none advances.
    void pause() {
        ++frames;
        now_ms = frames * 1000 / 60;
        network.advance_to(now_ms);
        for (const std::unique_ptr<Machine>& m : machines) {
            m->runner->wait(now_ms);
            while (const auto notice = m->session->next_notice()) m->notices.push_back(*notice);
        }
    }
    void run(std::uint64_t count) {
        for (std::uint64_t i = 0; i < count; ++i) frame();
    }
    Machine& machine(PeerId id) { return *machines[id]; }
    template <class N> std::vector<N> notices(PeerId id) const {
        std::vector<N> found;
        for (const Notice& notice : machines[id]->notices) {
            if (const N* n = std::get_if<N>(&notice)) found.push_back(*n);
        }
        return found;
    }
    /// Returns whether the ticks that both machines have confirmed have equal inputs, statuses and hashes.
    bool agree(PeerId a, PeerId b) const {
        const auto lives_agree = [&](const Timeline& life) { return life.agrees(machines[b]->timeline); };
        // In a match of two, a machine that crashes may have confirmed ticks that the other never receives. Its earlier
        // lives are then not compared.
        const bool is_kept = def.machines > 2;
        return lives_agree(machines[a]->timeline) &&
               (!is_kept || std::ranges::all_of(machines[a]->lives_before, lives_agree));
    }

    MatchDef def;
    SimulatedNetwork network;
    std::vector<std::unique_ptr<Machine>> machines;
    std::uint64_t frames = 0;
    std::uint64_t now_ms = 0;

  private:
    /// The result is valid until the next call. The buffer is a member because tests count the allocations of frames.
    std::span<const std::byte> scripted_input(std::uint32_t player, std::uint64_t tick) {
        const auto pad = encode_input(scripted_pad(player, tick));
        std::ranges::copy(pad, input.begin());
        SplitMix noise(tick * players_max + player);
        for (std::uint32_t i = 0; i < def.noise_bytes; ++i)
            input[pad.size() + i] = static_cast<std::byte>(noise.below(256));
        return std::span(input).first(pad.size() + def.noise_bytes);
    }
    void start(Machine& m, PeerId id) {
        m.simulation = make_simulation(id);
        m.driven = std::make_unique<testing::ForgetfulSimulation>(*m.simulation, def.column_left_out);
        m.runner = std::make_unique<SessionRunner>(
            *m.session, *m.driven, RunnerDef{def.record ? &m.timeline : nullptr, def.inspected_ticks});
    }
    std::function<std::unique_ptr<Simulation>(PeerId)> make_simulation;
    std::array<std::byte, input_bytes_max> input{};
};

/// Runs the inputs of a timeline once, without any session. Returns the hash after the last tick.
inline std::uint64_t run_straight(const Timeline& timeline, std::uint32_t players, Simulation& simulation) {
    for (const Timeline::Tick& tick : timeline.ticks) {
        std::vector<PlayerInput> inputs;
        for (std::uint32_t p = 0; p < players; ++p) {
            const std::size_t size = tick.inputs.size() / players;
            inputs.push_back({std::span(tick.inputs).subspan(p * size, size), tick.statuses[p]});
        }
        simulation.advance(inputs);
    }
    return simulation.hash();
}

} // namespace lockstone::test
