// The command `lockstone verify`.
#include "cli/progress.h"
#include "cli/recordings/recording_choice.h"
#include "cli/text.h"
#include "replay/verifier.h"
#include "json/json.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <future>

namespace lockstone::cli {
namespace {

struct Args {
    std::vector<std::string> files;
    std::uint32_t jobs = 1, threads = 1;
    std::string shard = "0/1";
    bool json = false;
    LimitChoice limits;
};

void describe(CLI::App& command, Args& args) {
    add_texts(command, "FILE", args.files, "recordings (.lsr)").required();
    add_number(command, "--jobs", args.jobs,
               "number of threads for a recording, 1 to 256; each verifies ticks between keyframes", 1, 256);
    add_threads(command, args.threads);
    add_text(command, "--shard", args.shard,
             "I/N: verify only part I of N parts, where I is 0 to N - 1; parts begin and end at keyframes")
        .show_default();
    add_flag(command, "--json", args.json, "print the results as JSON");
    describe_limits(command, args.limits);
}

struct Shard {
    std::uint32_t part, parts;
};
Result<Shard> parse_shard(const std::string& text) {
    const std::size_t slash = std::min(text.find('/'), text.size());
    const auto part = number_of(std::string_view(text).substr(0, slash)),
               parts = number_of(std::string_view(text).substr(std::min(slash + 1, text.size())));
    if (!part || !parts || *part >= *parts || *parts > UINT32_MAX)
        return Error{"--shard " + text + ": is not I/N with I from 0 to N - 1, and N at most " +
                     std::to_string(UINT32_MAX)};
    return Shard{static_cast<std::uint32_t>(*part), static_cast<std::uint32_t>(*parts)};
}

/// Verifies a recording and shows a progress bar meanwhile.
replay::VerifyReport verify_watched(const Loaded& loaded, replay::VerifyOptions options) {
    std::atomic<std::uint64_t> done{0};
    options.ticks_done = &done;
    Progress progress(loaded.recording.name(), loaded.recording.tick_count() / std::max(1u, options.shards));
    auto report = std::async(std::launch::async,
                             [&] { return replay::verify(loaded.recording, loaded.game.get(), options); });
    while (report.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready) progress.at(done);
    return report.get();
}

Exit exit_of(replay::Verdict verdict) {
    switch (verdict) {
    case replay::Verdict::good:
        return Exit::good;
    case replay::Verdict::diverged:
        return Exit::check_failed;
    case replay::Verdict::incomplete:
    case replay::Verdict::vacuous:
    case replay::Verdict::unusable:
        break;
    }
    return Exit::bad_input;
}

json::Value to_json(const std::string& file, const replay::VerifyReport& report) {
    json::Value json = {{"file", file},
                        {"verdict", replay::name_of(report.verdict)},
                        {"ticks", report.ticks},
                        {"hashes_compared", report.hashes_compared},
                        {"keyframes_compared", report.keyframes_compared},
                        {"first_bad_tick", nullptr},
                        {"sentence", report.sentence}};
    if (report.first_bad_tick) json["first_bad_tick"] = *report.first_bad_tick;
    return json;
}

replay::VerifyReport verify_file(const std::string& file, const Args& args, Shard shard) {
    replay::VerifyOptions options;
    options.jobs = args.jobs;
    options.threads = args.threads;
    options.shard = shard.part;
    options.shards = shard.parts;
    const Result<Loaded> loaded = load_quietly(file, args.limits.limits());
    if (loaded) return verify_watched(*loaded, options);
    replay::VerifyReport report;
    report.sentence = loaded.error().message;
    return report;
}

/// Verifies every file; the result is that of the worst file.
Result<Exit> verify_all(const Args& args) {
    const Result<Shard> shard = parse_shard(args.shard);
    if (!shard) return shard.error();
    Exit worst = Exit::good;
    json::Value all = json::Value::array();
    for (const std::string& file : args.files) {
        const replay::VerifyReport report = verify_file(file, args, *shard);
        const Exit exit = exit_of(report.verdict);
        worst = std::max(worst, exit);
        if (exit == Exit::bad_input)
            print_notice(report.sentence);
        else if (!args.json)
            print_line(report.sentence);
        all.push_back(to_json(file, report));
    }
    if (args.json) std::printf("%s\n", all.dump(2).c_str());
    return worst;
}

} // namespace

void add_verify(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "verify",
                      "Re-simulate recordings, compare every tick's hash and every keyframe.", describe,
                      verify_all);
}

} // namespace lockstone::cli
