// Sessions: peers that agree, hostile peers, joins, relays, run-ahead.
#include "checks.h"
#include "session/event_ledger.h"
#include "session/inputs/large.h"
#include "session/join/join_scenes.h"
#include "session/join/relayed_scenes.h"
#include "session/lifetime.h"
#include "session/run_ahead.h"
#include "support/rigs/busy_game.h"
#include "support/rigs/snap_game.h"

namespace planted {

namespace {

std::string peers_agree() {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        MatchDef def;
        def.link = {.latency_ms = 90, .jitter_ms = 30, .loss_permille = 80};
        def.seed = seed;
        def.inspected_ticks = 0; // images kept for reports would hide missing save requests
        Match match(def);
        match.run(500);
        if (!match.agree(0, 1) || match.machine(0).timeline.ticks.size() < 200)
            return "the peers' timelines part";
        for (PeerId id : {PeerId{0}, PeerId{1}}) {
            if (!match.notices<Desync>(id).empty()) return "a desync is told of";
            if (!match.machine(id).events.holds(match.machine(id).timeline.ticks.size()) ||
                match.machine(id).events.count(EventStatus::predicted) == 0)
                return "an event is told twice, or never to its end";
            Arena straight(2);
            if (run_straight(match.machine(id).timeline, 2, straight) !=
                match.machine(id).timeline.ticks.back().hash)
                return "the inputs, run straight, give another hash";
        }
    }
    return {};
}

/// Returns the first error of the scenes.
std::string first_wrong(const std::vector<HostileScene>& scenes) {
    for (const HostileScene& scene : scenes)
        if (const std::string wrong = scene.run(); !wrong.empty())
            return std::string(scene.name) + ": " + wrong;
    return {};
}

std::string broken_joints_are_told() {
    const test::Snapped snapped = test::run_snap_game();
    return snapped.told == snapped.joints ? "" : "a session does not tell which joints break";
}

std::string all_kinds_are_told() {
    const std::string missing = run_busy_game(250).pairs.missing();
    return missing.empty() ? "" : "kinds that never happened in one tick: " + missing;
}

std::string other_ticks_refused() {
    const test::SnapGame game;
    World theirs = scene::made(game.start()), ours = scene::made(game.start());
    WorldSimulation simulation(ours, game);
    for (int t = 0; t < 3; ++t) theirs.tick();
    if (!simulation.adopt_at(3, theirs.save_portable())) return "a state of its tick is refused";
    return simulation.adopt_at(4, theirs.save_portable()) ? "a state of another tick is taken" : "";
}

/// A game's own simulation may report events in any order, and one of them twice.
std::string unordered_events_are_told_once() {
    const auto event_of = [](std::uint32_t shape) {
        Event e{};
        e.shape_a.index = shape, e.shape_b.index = 100;
        return e;
    };
    session::EventLedger ledger(4);
    std::vector<SessionEvent> told;
    ledger.record(0, std::array{event_of(4), event_of(1), event_of(4)}), ledger.publish(0, told);
    ledger.record(0, std::array{event_of(1), event_of(4)}), ledger.publish(1, told);
    if (told.size() != 4) return std::to_string(told.size()) + " events are told, not 4";
    for (int i = 0; i < 2; ++i)
        if (told[2 + i].status != EventStatus::confirmed || told[2 + i].id != told[i].id)
            return "an event that was predicted is not confirmed";
    return {};
}

} // namespace

Checks session_checks() {
    return {{"peers agree", peers_agree},
            {"hostile peers", [] { return first_wrong(hostile_scenes()); }},
            {"machines come back", [] { return first_wrong(join_scenes()); }},
            {"relays serve", [] { return first_wrong(relay_scenes()); }},
            {"sessions end before their runners", [] { return first_wrong(lifetime_scenes()); }},
            {"large inputs keep up", [] { return first_wrong(large_input_scenes()); }},
            {"shows ahead", [] { return first_wrong(run_ahead_scenes()); }},
            {"joints that break are told", broken_joints_are_told},
            {"states of another tick are refused", other_ticks_refused},
            {"events out of order are told once", unordered_events_are_told_once},
            {"every two kinds are told", all_kinds_are_told}};
}

} // namespace planted
