// The command `lockstone match`.
#include "cli/match/match_chaos.h"
#include "cli/progress.h"
#include "cli/scene_choice.h"
#include "cli/text.h"
#include "replay/verifier.h"

#include <algorithm>
#include <cstdio>
#include <iterator>

namespace lockstone::cli {
namespace {

struct Args {
    std::string scene = "rollback-arena";
    std::string seeds = "1..1";
    std::uint32_t peers = 2;
    std::uint32_t loss_percent = 0, latency_ms = 50, jitter_ms = 10;
    std::uint64_t ticks = 600;
    bool relayed = false;
    std::uint32_t watchers = 0, late = 0, rejoin = 0;
    bool trouble = false, chaos = false, plant = false, recover = false;
    std::vector<std::string> without;
    std::string mode = "rollback";
    std::string record_prefix;
};

void describe(CLI::App& command, Args& args) {
    add_text(command, "SCENE", args.scene, "scene with players, see `lockstone scenes`").show_default();
    add_text(command, "--seeds", args.seeds, "range of seeds A..B; each seed gives one match").show_default();
    add_number(command, "--peers", args.peers, "number of machines; each has one player");
    add_number(command, "--loss", args.loss_percent, "lost packets [%], 0 to 99", 0, 99);
    add_number(command, "--latency", args.latency_ms, "delay of a packet one way [ms], 0 to 10000", 0, 10000);
    add_number(command, "--jitter", args.jitter_ms, "largest additional delay of a packet [ms], 0 to 10000",
               0, 10000);
    add_number(command, "--ticks", args.ticks, "number of ticks that every peer must confirm", 1,
               match_ticks_max);
    add_number(command, "--watchers", args.watchers,
               "number of machines that watch machine 1, 0 to 64; they join in turn", 0, 64);
    add_flag(command, "--relayed", args.relayed,
             "the watchers use a relay that receives the match from machines 1 and 2");
    add_number(command, "--late", args.late, "number of machines that join late and take free seats, 0 to 15",
               0, 15);
    add_number(command, "--rejoin", args.rejoin,
               "number of times that a machine loses all its state and rejoins, 0 to 1000", 0, 1000);
    add_flag(command, "--trouble", args.trouble, "pause machines and cut links for some time");
    add_flag(command, "--chaos", args.chaos,
             "draw players, network and all kinds of trouble, also wrong clocks, from the seed; options for "
             "them have no effect; a failing match is reduced to a smaller one");
    add_flag(command, "--plant", args.plant,
             "one machine changes a bit of its state half way; every match must then fail");
    add_flag(command, "--recover", args.recover,
             "a machine whose state differs from most others takes their state and rejoins; with --plant "
             "exactly one must do so");
    add_texts(command, "--without", args.without, "kinds of trouble to leave out, with --chaos");
    add_text(command, "--mode", args.mode, "kind of session: rollback or lockstep")
        .one_of({"rollback", "lockstep"})
        .show_default();
    add_text(command, "--record-prefix", args.record_prefix,
             "write the recording of each machine to PREFIX-SEED-MACHINE.lsr; machines count from 1");
}

struct Seeds {
    std::uint64_t first, last;
};
Result<Seeds> parse_seeds(const std::string& text) {
    const std::size_t dots = text.find("..");
    const auto first = number_of(std::string_view(text).substr(0, dots)),
               last = dots == std::string::npos ? first : number_of(std::string_view(text).substr(dots + 2));
    if (!first || !last || *last < *first)
        return Error{"--seeds " + text + ": is not A..B with A at most B, both at most " +
                     std::to_string(UINT64_MAX)};
    return Seeds{*first, *last};
}

/// The first peer that confirmed the match from tick 0 and therefore has all ticks.
auto there_throughout(const MatchOutcome& match) {
    return std::ranges::find(match.peers, std::uint64_t{0}, &PeerOutcome::first);
}

/// True if one of the two machines had dropped the other by that tick. Each then continues in a match of its own.
bool have_parted(const MatchOutcome& match, PeerId a, PeerId b, std::uint64_t tick) {
    return std::ranges::any_of(match.departures, [&](const Departure& d) {
        return d.tick <= tick && ((d.told_by == a && d.gone == b) || (d.told_by == b && d.gone == a));
    });
}

/// Differences of the confirmed ticks of two machines, as sentences that begin with `name`.
std::vector<std::string> differences(const MatchOutcome& match, PeerId self, PeerId other,
                                     const std::string& name) {
    const PeerOutcome &peer = match.peers[self], &first = match.peers[other];
    const std::string its_name = "machine " + std::to_string(other + 1);
    std::vector<std::string> found;
    for (std::size_t tick = peer.first; tick < first.hashes.size() && found.empty(); ++tick) {
        if (peer.hashes[tick - peer.first] == first.hashes[tick]) continue;
        if (have_parted(match, self, other, tick))
            return {name + ": lost the connection to " + its_name + "; from tick " + std::to_string(tick) +
                    " on each plays its own match"};
        found.push_back(name + ": differs from " + its_name + " after tick " + std::to_string(tick));
    }
    const std::size_t before = first.inputs.size() - std::min(first.inputs.size(), peer.inputs.size());
    if (!std::ranges::equal(peer.inputs, std::span(first.inputs).subspan(before)))
        found.push_back(name + ": its confirmed inputs are not those of " + its_name);
    return found;
}

/// The differences between the peers of a match, in sentences; empty if there are none.
std::vector<std::string> disagreements(const MatchOutcome& match, const Game& game, std::uint64_t seed) {
    std::vector<std::string> found = match.broken;
    const auto first_there = there_throughout(match);
    if (first_there == match.peers.end()) return {"no machine was connected from the start to the end"};
    const PeerOutcome& first = *first_there;
    const auto other = static_cast<PeerId>(first_there - match.peers.begin());
    for (PeerId p = 0; p < match.peers.size(); ++p) {
        const PeerOutcome& peer = match.peers[p];
        const std::string name = "seed " + std::to_string(seed) + ", machine " + std::to_string(p + 1);
        std::ranges::move(differences(match, p, other, name), std::back_inserter(found));
        if (peer.recording.empty()) continue;
        const auto recording = replay::Recording::from_bytes(peer.recording, name);
        if (!recording)
            found.push_back(recording.error().message);
        else if (const auto report = replay::verify(*recording, &game); !report.good())
            found.push_back(report.sentence);
    }
    for (std::size_t w = 0; w < match.watched.size(); ++w)
        if (!std::equal(first.hashes.begin(), first.hashes.end(), match.watched[w].begin()))
            found.push_back("seed " + std::to_string(seed) + ", watcher " + std::to_string(w + 1) +
                            ": saw a different match than machine " + std::to_string(other + 1));
    return found;
}

std::string recording_name(const std::string& prefix, std::uint64_t seed, std::size_t machine) {
    return prefix + "-" + std::to_string(seed) + "-" + std::to_string(machine + 1) + ".lsr";
}

Status write_recordings(const MatchOutcome& match, const std::string& prefix, std::uint64_t seed) {
    for (std::size_t p = 0; p < match.peers.size(); ++p) {
        if (match.peers[p].recording.empty()) continue;
        const std::string path = recording_name(prefix, seed, p);
        Result<replay::FileSink> sink = replay::FileSink::create(path);
        if (!sink) return sink.error();
        if (Status s = sink->append(match.peers[p].recording); !s) return s;
        if (Status s = sink->close(); !s) return s;
    }
    return {};
}

void print_summary(const MatchOutcome& match, const MatchDef& def, std::uint64_t seed) {
    SessionStats sum;
    for (const PeerOutcome& peer : match.peers) {
        sum.rollbacks += peer.stats.rollbacks;
        sum.resimulated += peer.stats.resimulated;
        sum.stalls += peer.stats.stalls;
        sum.hashes_compared += peer.stats.hashes_compared;
        sum.depth_max = std::max(sum.depth_max, peer.stats.depth_max);
    }
    const auto n = [](std::uint64_t v) { return static_cast<unsigned long long>(v); };
    std::printf(
        "seed %llu: %llu ticks of %u peers agree, %s, %llu rollbacks (deepest %llu), %llu ticks run again, "
        "%llu stalls, %llu ms, hash %s\n",
        n(seed), n(def.ticks), static_cast<unsigned>(match.peers.size()),
        def.mode == MatchMode::lockstep ? "lockstep" : "rollback", n(sum.rollbacks), n(sum.depth_max),
        n(sum.resimulated), n(sum.stalls), n(match.milliseconds),
        hash_text(there_throughout(match)->hashes.back()).c_str());
}

Chaos as_told(const Args& args, std::uint64_t seed) {
    Chaos match{args.peers, {}};
    match.def.seed = seed;
    match.def.ticks = args.ticks;
    match.def.mode = args.mode == "lockstep" ? MatchMode::lockstep : MatchMode::rollback;
    match.def.watchers = args.watchers;
    match.def.relayed = args.relayed;
    match.def.sleeps = match.def.cuts = args.trouble;
    match.def.late = args.late;
    match.def.rejoins = args.rejoin;
    match.def.link.latency_ms = args.latency_ms;
    match.def.link.jitter_ms = args.jitter_ms;
    match.def.link.loss_permille = args.loss_percent * 10;
    return match;
}

struct Played {
    MatchOutcome match;
    std::vector<std::string> found; ///< failures, in sentences
};
Result<Played> play(const Args& args, const Chaos& chaos,
                    const std::function<void(std::uint64_t)>& progress) {
    const Result<std::unique_ptr<Game>> game =
        make_scene(args.scene, {.size = 0, .seed = chaos.def.seed, .players = chaos.players});
    if (!game) return game.error();
    Result<MatchOutcome> match = play_match(**game, chaos.def, progress);
    if (!match) return match.error();
    Played played{std::move(*match), {}};
    played.found = disagreements(played.match, **game, chaos.def.seed);
    if (chaos.def.planted && chaos.def.recovers && played.match.recoveries != 1)
        played.found.push_back("seed " + std::to_string(chaos.def.seed) + ": " +
                               std::to_string(played.match.recoveries) + " machines recovered instead of 1");
    return played;
}

void set_plant(const Args& args, MatchDef& def) {
    def.planted = args.plant, def.recovers = args.recover;
    // With host_crashes or show_lost, peer 1 shows the match in place of peer 0. With --recover peer 1 may drop its
    // state, so both are switched off.
    if (args.recover) def.show_lost = 0, def.host_crashes = false;
}

/// Removes kinds of trouble, and then halves the ticks, as long as the match still fails. Prints the command that
/// repeats the smallest failing match.
void shrink(const Args& args, std::uint64_t seed) {
    std::vector<std::string> without = args.without;
    std::uint64_t ticks = args.ticks;
    const auto fails = [&](std::uint64_t some_ticks, const std::vector<std::string>& less) {
        Chaos smaller = chaos_of(seed, some_ticks, less);
        set_plant(args, smaller.def);
        const Result<Played> played = play(args, smaller, {});
        return !played || !played->found.empty();
    };
    for (const std::string& kind : chaos_kinds()) {
        std::vector<std::string> less = without;
        less.push_back(kind);
        if (fails(ticks, less)) without = less;
    }
    constexpr std::uint64_t fewest = 30;
    while (ticks / 2 >= fewest && fails(ticks / 2, without)) ticks /= 2;
    std::string command = "lockstone match " + args.scene + " --chaos --seeds " + std::to_string(seed) +
                          ".." + std::to_string(seed) + " --ticks " + std::to_string(ticks);
    if (args.plant) command += " --plant";
    if (args.recover) command += " --recover";
    if (!without.empty()) command += " --without";
    for (const std::string& kind : without) command += " " + kind;
    std::printf("seed %llu still fails with: %s\n", static_cast<unsigned long long>(seed), command.c_str());
}

/// Returns true if the peers agree.
Result<bool> play_seed(const Args& args, std::uint64_t seed, std::uint64_t ticks_before, Progress& progress) {
    Chaos chaos = args.chaos ? chaos_of(seed, args.ticks, args.without) : as_told(args, seed);
    set_plant(args, chaos.def);
    const Result<Played> played =
        play(args, chaos, [&](std::uint64_t ticks) { progress.at(ticks_before + ticks); });
    if (!played && !args.chaos) return played.error();
    const std::vector<std::string> found = played ? played->found : std::vector{played.error().message};
    if (played && !args.record_prefix.empty())
        if (Status s = write_recordings(played->match, args.record_prefix, seed); !s) return s.error();
    progress.wipe();
    for (const std::string& sentence : found) std::printf("%s\n", sentence.c_str());
    if (played && !found.empty()) // the notes that came before the failure
        for (const std::string& note : played->match.notes) std::printf("  %s\n", note.c_str());
    if (found.empty()) print_summary(played->match, chaos.def, seed);
    if (args.chaos && !found.empty()) {
        std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), told(chaos).c_str());
        shrink(args, seed);
    }
    return found.empty();
}

Status check_kinds(const Args& args) {
    std::string all;
    for (const std::string& kind : chaos_kinds()) all += (all.empty() ? "" : ", ") + kind;
    for (const std::string& kind : args.without)
        if (std::ranges::find(chaos_kinds(), kind) == chaos_kinds().end())
            return Error{"--without " + kind + ": is no kind of trouble; the kinds are " + all};
    if (!args.without.empty() && !args.chaos) return Error{"--without: give --chaos too"};
    return {};
}

std::string scenes_with_players() {
    std::string names;
    for (const SceneInfo& info : scenes())
        if (info.players_max > 1) names += (names.empty() ? ": " : ", ") + std::string(info.name);
    return names;
}

Result<Exit> match(const Args& args) {
    const Result<Seeds> seeds = parse_seeds(args.seeds);
    if (!seeds) return seeds.error();
    if (Status known = check_kinds(args); !known) return known.error();
    const SceneInfo* info = find_scene(args.scene);
    if (info != nullptr && info->players_max == 0)
        return Error{args.scene + ": has no players; choose a scene with players" + scenes_with_players()};
    if (args.relayed && args.watchers == 0 && !args.chaos)
        return Error{"--relayed: there are no watchers; give --watchers too"};
    if (!args.record_prefix.empty()) // checks the file of the first match before that match is played
        if (Status can = check_outputs({recording_name(args.record_prefix, seeds->first, 0)}); !can)
            return can.error();
    Exit exit = Exit::good;
    const std::uint64_t others =
        seeds->last - seeds->first; // seeds besides the first: this number cannot overflow
    Progress progress("matches", others >= UINT64_MAX / args.ticks ? 0 : (others + 1) * args.ticks);
    for (std::uint64_t n = 0;; ++n) {
        const Result<bool> agreed = play_seed(args, seeds->first + n, n * args.ticks, progress);
        if (!agreed) return agreed.error();
        if (!*agreed) exit = Exit::check_failed;
        if (n == others) return exit;
    }
}

} // namespace

void add_match(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "match",
                      "Play complete matches over a simulated network, one for each seed.", describe, match);
}

} // namespace lockstone::cli
