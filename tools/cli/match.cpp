// lockstone match
#include "cli/match.h"
#include "cli/progress.h"
#include "cli/scene_choice.h"
#include "cli/text.h"
#include "replay/verifier.h"

#include <cstdio>

namespace lockstone::cli {
namespace {

struct Args {
    std::string scene = "rollback-arena";
    std::string seeds = "1..1";
    std::uint32_t peers = 2;
    std::uint32_t loss_percent = 0, latency_ms = 50, jitter_ms = 10;
    std::uint64_t ticks = 600;
    std::uint32_t watchers = 0, late = 0, rejoin = 0;
    bool trouble = false;
    std::string mode = "rollback";
    std::string record_prefix;
};

void describe(CLI::App& command, Args& args) {
    add_text(command, "SCENE", args.scene, "one of `lockstone scenes` with players").show_default();
    add_text(command, "--seeds", args.seeds, "A..B: one match for each").show_default();
    add_number(command, "--peers", args.peers, "machines, one player each");
    add_number(command, "--loss", args.loss_percent, "packets that are lost [%]", 0, 99);
    add_number(command, "--latency", args.latency_ms, "one way [ms]", 0, 10000);
    add_number(command, "--jitter", args.jitter_ms, "added, up to [ms]", 0, 10000);
    add_number(command, "--ticks", args.ticks, "that every peer has to confirm", 1, UINT64_MAX);
    add_number(command, "--watchers", args.watchers,
               "machines that watch peer 0, and join one after the other", 0, 64);
    add_number(command, "--late", args.late, "machines that come in late, into empty seats", 0, 15);
    add_number(command, "--rejoin", args.rejoin, "how often a machine loses all its state and comes back", 0,
               1000);
    add_flag(command, "--trouble", args.trouble, "machines sleep, and links are cut, for a while");
    add_text(command, "--mode", args.mode, "rollback or lockstep")
        .one_of({"rollback", "lockstep"})
        .show_default();
    add_text(command, "--record-prefix", args.record_prefix, "write PREFIX-SEED-PEER.lsr of every peer");
}

struct Seeds {
    std::uint64_t first, last;
};
Result<Seeds> parse_seeds(const std::string& text) {
    unsigned long long first = 0, last = 0;
    int read = 0;
    const bool range = std::sscanf(text.c_str(), "%llu..%llu%n", &first, &last, &read) == 2;
    if (!range && std::sscanf(text.c_str(), "%llu%n", &first, &read) == 1) last = first;
    if (text.empty() || text.front() == '-' || static_cast<std::size_t>(read) != text.size() || last < first)
        return Error{"--seeds " + text + ": is not A..B with A at most B"};
    return Seeds{first, last};
}

/// What the peers of a match disagree about, with sentences; nothing when all is well.
std::vector<std::string> disagreements(const MatchOutcome& match, const Game& game, std::uint64_t seed) {
    std::vector<std::string> found = match.desyncs;
    const PeerOutcome& first = match.peers.front();
    for (std::size_t p = 0; p < match.peers.size(); ++p) {
        const PeerOutcome& peer = match.peers[p];
        const std::string name = "seed " + std::to_string(seed) + ", peer " + std::to_string(p);
        for (std::size_t tick = peer.first; tick < first.hashes.size(); ++tick)
            if (peer.hashes[tick - peer.first] != first.hashes[tick]) {
                found.push_back(name + ": differs from peer 0 after tick " + std::to_string(tick));
                break;
            }
        const std::size_t before = first.inputs.size() - std::min(first.inputs.size(), peer.inputs.size());
        if (!std::ranges::equal(peer.inputs, std::span(first.inputs).subspan(before)))
            found.push_back(name + ": its confirmed inputs are not those of peer 0");
        if (peer.recording.empty()) continue;
        const auto recording = replay::Recording::from_bytes(peer.recording, name);
        if (!recording)
            found.push_back(recording.error().message);
        else if (const auto report = replay::verify(*recording, &game); !report.good())
            found.push_back(report.sentence);
    }
    for (std::size_t w = 0; w < match.watched.size(); ++w)
        if (!std::equal(first.hashes.begin(), first.hashes.end(), match.watched[w].begin()))
            found.push_back("seed " + std::to_string(seed) + ", watcher " + std::to_string(w) +
                            ": has seen another match than peer 0");
    return found;
}

Status write_recordings(const MatchOutcome& match, const std::string& prefix, std::uint64_t seed) {
    for (std::size_t p = 0; p < match.peers.size(); ++p) {
        if (match.peers[p].recording.empty()) continue;
        const std::string path = prefix + "-" + std::to_string(seed) + "-" + std::to_string(p) + ".lsr";
        Result<replay::FileSink> sink = replay::FileSink::create(path);
        if (!sink) return sink.error();
        if (Status s = sink->append(match.peers[p].recording); !s) return s;
        if (Status s = sink->close(); !s) return s;
    }
    return {};
}

void print_summary(const MatchOutcome& match, const Args& args, std::uint64_t seed) {
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
        n(seed), n(args.ticks), args.peers, args.mode.c_str(), n(sum.rollbacks), n(sum.depth_max),
        n(sum.resimulated), n(sum.stalls), n(match.milliseconds),
        hash_text(match.peers.front().hashes.back()).c_str());
}

/// True when the peers agree.
Result<bool> play_seed(const Args& args, std::uint64_t seed, std::uint64_t ticks_before, Progress& progress) {
    const Result<std::unique_ptr<Game>> game =
        make_scene(args.scene, {.size = 0, .seed = seed, .players = args.peers});
    if (!game) return game.error();
    MatchDef def;
    def.seed = seed;
    def.ticks = args.ticks;
    def.mode = args.mode == "lockstep" ? MatchMode::lockstep : MatchMode::rollback;
    def.watchers = args.watchers;
    def.trouble = args.trouble;
    def.late = args.late;
    def.rejoins = args.rejoin;
    def.link.latency_ms = args.latency_ms;
    def.link.jitter_ms = args.jitter_ms;
    def.link.loss_permille = args.loss_percent * 10;
    const Result<MatchOutcome> match =
        play_match(**game, def, [&](std::uint64_t ticks) { progress.at(ticks_before + ticks); });
    if (!match) return match.error();
    if (!args.record_prefix.empty())
        if (Status s = write_recordings(*match, args.record_prefix, seed); !s) return s.error();
    const std::vector<std::string> found = disagreements(*match, **game, seed);
    progress.wipe();
    for (const std::string& sentence : found) std::printf("%s\n", sentence.c_str());
    if (found.empty()) print_summary(*match, args, seed);
    return found.empty();
}

Result<Exit> match(const Args& args) {
    const Result<Seeds> seeds = parse_seeds(args.seeds);
    if (!seeds) return seeds.error();
    Exit exit = Exit::good;
    const std::uint64_t count = seeds->last - seeds->first + 1;
    Progress progress("matches", count > ~std::uint64_t{0} / args.ticks ? 0 : count * args.ticks);
    for (std::uint64_t seed = seeds->first; seed <= seeds->last; ++seed) {
        const Result<bool> agreed = play_seed(args, seed, (seed - seeds->first) * args.ticks, progress);
        if (!agreed) return agreed.error();
        if (!*agreed) exit = Exit::check_failed;
    }
    return exit;
}

} // namespace

void add_match(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "match", "Play whole matches over a simulated network, from seeds.",
                      describe, match);
}

} // namespace lockstone::cli
