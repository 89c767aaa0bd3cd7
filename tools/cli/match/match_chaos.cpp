#include "cli/match/match_chaos.h"

#include "lockstone/math/random.h"

#include <algorithm>
#include <array>

namespace lockstone::cli {
namespace {

constexpr std::uint32_t players_max = 4;

/// A link of one direction: most links are good, one of four is bad.
LinkDef draw_link(Random& random) {
    const bool is_bad = random.below(4) == 0;
    LinkDef link;
    link.latency_ms = 10 + random.below(is_bad ? 140 : 60);
    link.jitter_ms = random.below(is_bad ? 60 : 20);
    link.loss_permille = random.below(is_bad ? 250 : 50);
    link.duplicate_permille = random.below(50);
    link.reorder_permille = random.below(50);
    link.damage_permille = random.below(20);
    return link;
}

} // namespace

const std::vector<std::string>& chaos_kinds() {
    static const std::vector<std::string> kinds = {"host",       "ahead",   "relay",  "watchers", "rejoin",
                                                   "late",       "sleep",   "cuts",   "clocks",   "damage",
                                                   "duplicates", "reorder", "jitter", "loss",     "latency"};
    return kinds;
}

// All values are drawn first, and then the kinds in `without` are switched off. So switching one kind off does not
// change the others.
Chaos chaos_of(std::uint64_t seed, std::uint64_t ticks, const std::vector<std::string>& without) {
    Random random = Random::seeded(seed);
    constexpr std::uint32_t frame_ms = 17;
    const auto is_out = [&](const char* kind) { return std::ranges::find(without, kind) != without.end(); };
    Chaos chaos{2 + random.below(players_max - 1), {}};
    MatchDef& def = chaos.def;
    def.seed = seed, def.ticks = ticks;
    def.mode = random.below(4) == 0 ? MatchMode::lockstep : MatchMode::rollback;
    for (std::uint32_t i = 0; i < players_max * players_max; ++i) def.links.push_back(draw_link(random));
    def.links.resize(std::size_t{chaos.players} * chaos.players);
    for (std::uint32_t p = 0; p < players_max; ++p)
        def.clock_permille.push_back(static_cast<std::int32_t>(random.below(41)) - 20);
    def.watchers = random.below(3) == 0 ? 1 + random.below(2) : 0;
    def.sleeps = random.below(2) == 0, def.cuts = random.below(2) == 0;
    // A machine that joins accepts a state only if more than one other machine sends it, so a late or returning machine
    // needs a match of at least three.
    const std::uint32_t early =
        random.below(static_cast<std::uint32_t>(std::min<std::uint64_t>(ticks, 4000) / 2 + 1));
    const bool one_is_late = random.below(3) == 0, one_comes_back = random.below(3) == 0;
    def.first_late = 60 + early, def.first_crash = 60 + early / 2;
    def.late = one_is_late && chaos.players >= 3 ? 1 : 0;
    def.rejoins = one_comes_back && chaos.players - def.late >= 3 ? 1 : 0;
    def.relayed = random.below(2) == 0 && def.watchers != 0;
    const bool is_lost = random.below(2) == 0;
    // Peer 1 continues to show the match when peer 0 cannot, so no machine may crash in such a match.
    if (def.relayed && is_lost && def.rejoins == 0 && chaos.players - def.late >= 2)
        def.show_lost = 60 + early;
    def.run_ahead = random.below(3) == 0 ? 1 + random.below(run_ahead_limit) : 0;
    // Drawn last, so that seeds give the matches that they gave before this kind existed.
    def.host_crashes = random.below(2) == 0 && def.rejoins != 0;
    for (LinkDef& link : def.links) {
        if (is_out("damage")) link.damage_permille = 0;
        if (is_out("duplicates")) link.duplicate_permille = 0;
        if (is_out("reorder")) link.reorder_permille = 0;
        if (is_out("jitter")) link.jitter_ms = 0;
        if (is_out("loss")) link.loss_permille = 0;
        if (is_out("latency")) link.latency_ms = 0;
    }
    // In lockstep the input delay has to cover the slowest link. Otherwise the match runs at fewer than ten ticks a
    // second, and the sessions drop the machine that they wait for.
    std::uint32_t slowest_ms = 0;
    for (const LinkDef& link : def.links) slowest_ms = std::max(slowest_ms, link.latency_ms + link.jitter_ms);
    if (def.mode == MatchMode::lockstep) def.input_delay = slowest_ms / frame_ms + 2;
    if (is_out("clocks")) def.clock_permille.clear();
    if (is_out("host")) def.host_crashes = false;
    if (is_out("ahead")) def.run_ahead = 0;
    if (is_out("relay")) def.relayed = false;
    if (is_out("watchers")) def.watchers = 0;
    if (is_out("sleep")) def.sleeps = false;
    if (is_out("cuts")) def.cuts = false;
    if (is_out("late")) def.late = 0;
    if (is_out("rejoin")) def.rejoins = 0;
    return chaos;
}

std::string told(const Chaos& chaos) {
    const MatchDef& def = chaos.def;
    std::uint32_t loss = 0, latency = 0;
    for (const LinkDef& link : def.links)
        loss = std::max(loss, link.loss_permille),
        latency = std::max(latency, link.latency_ms + link.jitter_ms);
    std::string words = std::to_string(chaos.players) + " peers, up to " + std::to_string(latency) +
                        " ms and " + std::to_string(loss / 10) + " % lost";
    if (def.watchers != 0) words += ", " + std::to_string(def.watchers) + " watching";
    if (def.watchers != 0 && def.relayed) words += " through a relay";
    if (def.watchers != 0 && def.relayed && def.show_lost != 0) words += " whose host leaves";
    if (def.run_ahead != 0) words += ", " + std::to_string(def.run_ahead) + " ticks shown ahead";
    if (def.late != 0) words += ", one joins late";
    if (def.rejoins != 0) words += def.host_crashes ? ", the first rejoins" : ", one rejoins";
    if (def.sleeps) words += ", machines pause";
    if (def.cuts) words += ", links are cut";
    return words;
}

} // namespace lockstone::cli
