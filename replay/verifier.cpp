#include "replay/verifier.h"

#include "base/text.h"

#include <algorithm>
#include <thread>

namespace lockstone::replay {
namespace {

using base::hex;
using base::join;

/// The result of one segment, or of several, up to the first difference.
struct Outcome {
    std::uint64_t ticks = 0, hashes = 0, keyframes = 0;
    std::optional<std::uint64_t> bad_tick;
    std::string sentence;

    void add(const Outcome& other) {
        ticks += other.ticks;
        hashes += other.hashes;
        keyframes += other.keyframes;
        if (!other.bad_tick || (bad_tick && *bad_tick <= *other.bad_tick)) return;
        bad_tick = other.bad_tick;
        sentence = other.sentence;
    }
    void diverge(std::uint64_t tick, std::string why) {
        bad_tick = tick;
        sentence = std::move(why);
    }
};

/// A recording from tick 0 must start like the game; otherwise it could begin with any state.
void check_start(Player& player, const Game& game, Outcome& outcome) {
    const Result<World> start = game.start();
    ++outcome.hashes;
    if (!start) return outcome.diverge(0, join("the game does not start: ", start.error().message));
    const auto differences = State::diff(start->state(), player.world().state(), 1);
    if (differences.empty() && start->hash() == player.world().hash()) return;
    outcome.diverge(0, join("the recorded start is not the game's: ",
                            differences.empty() ? "the hash differs" : to_string(differences.front()),
                            " (the game's against recorded)"));
}

void check_tick(Player& player, Outcome& outcome) {
    const std::uint64_t tick = player.time();
    if (const Status status = player.step(); !status) return outcome.diverge(tick, status.error().message);
    ++outcome.ticks;
    ++outcome.hashes;
    const std::uint64_t computed = player.world().hash(), recorded = player.recording().hash_at(tick + 1);
    if (computed != recorded)
        outcome.diverge(tick, join("tick ", tick, ": the state's hash is ", hex(computed), ", recorded is ",
                                   hex(recorded)));
}

void check_keyframe(Player& player, std::size_t keyframe, Outcome& outcome) {
    const std::vector<std::byte> recorded = player.recording().keyframe_image(keyframe);
    const std::uint64_t time = player.time();
    ++outcome.keyframes;
    if (player.world().save_portable() == recorded) return;
    std::string why = join("keyframe at ", time, ": the recorded bytes are not those of the state");
    State image(player.world().state().layout_shared());
    if (const Status status = image.restore_portable(recorded); !status)
        why += join(": ", status.error().message);
    else if (const auto first = State::diff(player.world().state(), image, 1); !first.empty())
        why += join(": ", to_string(first.front()), " (computed against recorded)");
    outcome.diverge(time == player.recording().start_tick() ? time : time - 1, std::move(why));
}

/// Checks the ticks of segment `k` and the keyframe at its end. The player must be at the start of the segment.
void check_segment(Player& player, std::size_t k, const VerifyOptions& options, Outcome& outcome) {
    const auto keyframes = player.recording().keyframes();
    const bool has_next = k + 1 < keyframes.size();
    const std::uint64_t end = has_next ? keyframes[k + 1].time : player.recording().end_tick();
    while (!outcome.bad_tick && player.time() < end) {
        check_tick(player, outcome);
        if (options.ticks_done != nullptr) options.ticks_done->fetch_add(1, std::memory_order_relaxed);
    }
    if (!outcome.bad_tick && has_next) check_keyframe(player, k + 1, outcome);
}

std::unique_ptr<Tasks> tasks_of(const VerifyOptions& options) {
    return options.threads > 1 ? make_worker_pool(options.threads) : nullptr;
}

/// Takes segments by `next` and checks them, with its own player.
Outcome run_apart(const Recording& recording, const Game* game, const VerifyOptions& options,
                  std::span<const std::size_t> segments, std::atomic<std::size_t>& next) {
    Outcome all;
    Result<Player> player = Player::open(recording, game);
    if (!player) {
        all.diverge(recording.start_tick(), player.error().message);
        return all;
    }
    const std::unique_ptr<Tasks> tasks = tasks_of(options);
    player->world().set_tasks(tasks.get());
    player->keep_states(0);
    for (std::size_t i = next.fetch_add(1); i < segments.size(); i = next.fetch_add(1)) {
        Outcome outcome;
        const std::size_t k = segments[i];
        ++outcome.hashes; // the hash of the state from which the segment starts
        if (const Status status = player->seek_keyframe(k); !status)
            outcome.diverge(recording.keyframes()[k].time, status.error().message);
        else
            check_segment(*player, k, options, outcome);
        all.add(outcome);
    }
    return all;
}

Outcome run_straight(Player& player, const VerifyOptions& options) {
    const std::unique_ptr<Tasks> tasks = tasks_of(options);
    player.world().set_tasks(tasks.get());
    Outcome outcome;
    for (std::size_t k = 0; !outcome.bad_tick && k < segment_count(player.recording()); ++k)
        check_segment(player, k, options, outcome);
    player.world().set_tasks(nullptr);
    return outcome;
}

Outcome run_jobs(const Recording& recording, const Game* game, const VerifyOptions& options,
                 std::span<const std::size_t> segments) {
    std::atomic<std::size_t> next = 0;
    const std::size_t jobs =
        std::clamp<std::size_t>(options.jobs, 1, std::max<std::size_t>(segments.size(), 1));
    std::vector<Outcome> outcomes(jobs);
    std::vector<std::thread> threads;
    for (std::size_t j = 1; j < jobs; ++j)
        threads.emplace_back([&, j] { outcomes[j] = run_apart(recording, game, options, segments, next); });
    outcomes[0] = run_apart(recording, game, options, segments, next);
    for (std::thread& thread : threads) thread.join();
    Outcome all;
    for (const Outcome& outcome : outcomes) all.add(outcome);
    return all;
}

VerifyReport report_of(const Recording& recording, const Outcome& outcome) {
    VerifyReport report;
    report.ticks = outcome.ticks;
    report.hashes_compared = outcome.hashes;
    report.keyframes_compared = outcome.keyframes;
    report.first_bad_tick = outcome.bad_tick;
    const bool names_file = outcome.sentence.starts_with(recording.name());
    const std::string compared = join(outcome.ticks, " ticks, ", outcome.hashes, " hashes and ",
                                      outcome.keyframes, " keyframes compared");
    if (outcome.bad_tick) {
        report.verdict = Verdict::diverged;
        report.sentence = names_file ? outcome.sentence : join(recording.name(), ": ", outcome.sentence);
        if (recording.header().engine != engine_version)
            report.sentence +=
                join(" (recorded by engine ", recording.header().engine, ", this is ", engine_version, ")");
    } else if (!recording.complete()) {
        report.verdict = Verdict::incomplete;
        report.sentence = join(recording.damage(), " (", compared, ", all agree)");
    } else if (outcome.ticks == 0) {
        report.verdict = Verdict::vacuous;
        report.sentence = join(recording.name(), ": no tick was compared, so nothing was verified");
    } else {
        report.verdict = Verdict::good;
        report.sentence = join(recording.name(), ": ", compared, ", all agree");
    }
    return report;
}

} // namespace

std::string_view name_of(Verdict verdict) {
    static constexpr std::string_view names[] = {"good", "diverged", "incomplete", "vacuous", "unusable"};
    const auto index = static_cast<std::size_t>(verdict);
    return index < std::size(names) ? names[index] : "unknown";
}

std::size_t segment_count(const Recording& recording) {
    const auto keyframes = recording.keyframes();
    const bool ends_with_one = keyframes.size() > 1 && keyframes.back().time == recording.end_tick();
    return keyframes.size() - (ends_with_one ? 1 : 0);
}

VerifyReport verify(const Recording& recording, const Game* game, const VerifyOptions& wanted) {
    VerifyReport report;
    if (wanted.shards == 0 || wanted.shard >= wanted.shards) {
        report.sentence = join("shard ", wanted.shard, " of ", wanted.shards, ": shards count from 0");
        return report;
    }
    Result<Player> player = Player::open(recording, game);
    if (!player) {
        report.sentence = player.error().message;
        return report;
    }
    player->keep_states(0);
    // As many jobs as fit into the memory limit.
    const std::uint64_t each =
        Player::memory_of(recording, player->world().def(), player->world().schema()) + 1;
    const std::uint64_t fits = (recording.limits().memory - recording.memory()) / each;
    VerifyOptions options = wanted;
    options.jobs = static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(wanted.jobs, 1, std::max<std::uint64_t>(fits, 1)));
    std::vector<std::size_t> segments;
    for (std::size_t k = options.shard; k < segment_count(recording); k += options.shards)
        segments.push_back(k);

    Outcome outcome;
    const bool has_start = options.shard == 0 && game != nullptr && recording.header().mode == Mode::inputs;
    if (has_start && recording.start_tick() == 0) check_start(*player, *game, outcome);
    if (!outcome.bad_tick) {
        const bool straight = options.jobs <= 1 && options.shards == 1 && !options.from_keyframes;
        if (straight)
            outcome.add(run_straight(*player, options));
        else {
            player = Error{"each job has one of its own"}; // frees its memory; each job has its own player
            outcome.add(run_jobs(recording, game, options, segments));
        }
    }
    report = report_of(recording, outcome);
    if (segments.empty())
        report.sentence +=
            join(" (there are ", segment_count(recording), " segments for ", options.shards, " shards)");
    return report;
}

} // namespace lockstone::replay
