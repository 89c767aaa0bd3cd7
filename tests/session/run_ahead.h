// Matches that are shown some ticks ahead, beside equal matches that are not. For the tests and for the planted faults.
#pragma once

#include "session/hostile_scenes.h"
#include "session/match.h"

namespace lockstone::test {

/// Counts the calls that its runner makes.
class CountingArena final : public Arena {
  public:
    using Arena::Arena;
    void advance(std::span<const PlayerInput> inputs) override {
        Arena::advance(inputs);
        ++advances;
    }
    void restore(const Image& image) override {
        Arena::restore(image);
        ++restores;
    }
    void save(Image& image) const override {
        Arena::save(image);
        ++saves;
    }
    std::uint64_t advances = 0, restores = 0;
    mutable std::uint64_t saves = 0;
};

struct AheadMatch : Match {
    std::vector<std::string> told; ///< the texts of machine 0's events
    explicit AheadMatch(const MatchDef& of)
        : Match(of, [players = static_cast<std::uint32_t>(completed(of).players.size())](PeerId) {
              return std::make_unique<CountingArena>(players);
          }) {}
    CountingArena& arena(PeerId id) { return static_cast<CountingArena&>(*machine(id).simulation); }
    /// The tick of the shown state.
    std::uint64_t shown_tick(PeerId id) { return arena(id).state().rows(arena_columns().clock)[0].tick; }
    void play(int frames_to_run) {
        for (int i = 0; i < frames_to_run; ++i) {
            frame();
            for (const SessionEvent& e : machine(0).runner->events())
                told.push_back(std::to_string(e.id) + "/" + std::to_string(static_cast<int>(e.status)) + "/" +
                               std::to_string(e.event.tick) + "/" + std::to_string(e.event.shape_a.index) +
                               "/" + std::to_string(e.event.shape_b.index));
        }
    }
};

/// Compares a match shown `ticks` ahead with the same match without. Returns a sentence about the first difference, or
/// an empty string.
inline std::string shown_ahead(MatchDef def, std::uint32_t ticks) {
    AheadMatch plain(def);
    def.run_ahead = ticks;
    AheadMatch ahead(def);
    plain.play(500), ahead.play(500);
    for (PeerId id = 0; id < def.machines; ++id) {
        if (ahead.machine(id).timeline.ticks != plain.machine(id).timeline.ticks)
            return "what is confirmed is not what it is without";
        if (!ahead.notices<Desync>(id).empty()) return "a desync";
    }
    if (ahead.machine(0).timeline.ticks.size() < 300) return "the match did not get on";
    if (ahead.told != plain.told) return "other events are told";
    const std::uint64_t current = ahead.machine(0).session->current_tick();
    return ahead.shown_tick(0) == current + ticks ? "" : "it is not shown so far ahead";
}

inline std::vector<HostileScene> run_ahead_scenes() {
    static const MatchDef alone{.players = {0}, .machines = 1, .input_delay = 0};
    static const MatchDef two{.input_delay = 1, .link = lossy};
    static const MatchDef lockstep{.lockstep = true, .input_delay = 5, .link = {.latency_ms = 30}};
    return {
        {"one player, four ticks ahead", [] { return shown_ahead(alone, 4); }},
        {"two machines, three ticks ahead", [] { return shown_ahead(two, 3); }},
        {"lockstep, one tick ahead", [] { return shown_ahead(lockstep, 1); }},
    };
}

} // namespace lockstone::test
