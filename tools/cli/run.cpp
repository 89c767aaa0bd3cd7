// The command `lockstone run`.
#include "cli/input_source.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/scene_choice.h"
#include "cli/text.h"
#include "cli/world_report.h"
#include "replay/recorder.h"

#include <cstdio>
#include <optional>

namespace lockstone::cli {
namespace {

struct Args {
    SceneChoice choice;
    std::uint64_t ticks = 600;
    std::uint32_t threads = 1;
    std::string simd;
    std::string input, record, hashes, report;
    std::uint64_t keyframe_ticks = replay::keyframe_ticks_default;
};

void describe(CLI::App& command, Args& args) {
    describe_scene(command, args.choice);
    add_number(command, "--ticks", args.ticks, "number of ticks to run");
    add_threads(command, args.threads);
    add_text(command, "--simd", args.simd,
             "instruction set: scalar, sse41, avx2, avx512, neon or wasm128; default: the best of this "
             "machine; the hashes do not depend on it");
    add_text(command, "--input", args.input,
             "file with the inputs of the players: text (see tools/README.md) or a recording; default: "
             "inputs scripted from the seed");
    add_text(command, "--record", args.record, "write a recording (.lsr) to this file");
    add_number(command, "--keyframes", args.keyframe_ticks,
               "number of ticks between keyframes of the recording; 0: only the first keyframe");
    add_text(command, "--hashes", args.hashes,
             "write a line for each tick to this file: tick, tab, root hash after the tick");
    add_text(command, "--report", args.report, "write measurements of the run to this file as JSON");
}

/// The results of a run besides its last state.
struct Outputs {
    std::optional<replay::FileSink> sink;
    std::optional<replay::InputRecorder> recorder;
    std::optional<WorldReport> report;
    std::string hashes;
};

Status open_outputs(const Args& args, const Started& started, Outputs& out) {
    if (!args.report.empty()) out.report.emplace(started.world);
    if (args.record.empty()) return {};
    Result<replay::FileSink> sink = replay::FileSink::create(args.record);
    if (!sink) return sink.error();
    out.sink.emplace(std::move(*sink));
    replay::RecorderOptions options;
    options.options = {{"scene", args.choice.scene}, {"seed", std::to_string(args.choice.options.seed)}};
    options.keyframe_ticks = args.keyframe_ticks;
    Result<replay::InputRecorder> recorder =
        replay::InputRecorder::begin(*out.sink, *started.game, started.world, options);
    if (!recorder) return recorder.error();
    out.recorder.emplace(std::move(*recorder));
    return {};
}

/// An error of the scene's rules, with its tick.
Error fail_at(std::uint64_t tick, const Error& error) {
    return {"tick " + std::to_string(tick) + ": the game's rules fail: " + error.message};
}

Status run_tick(Started& started, InputSource& source, Outputs& out, bool want_hashes) {
    World& world = started.world;
    const std::uint64_t tick = world.tick_count();
    const std::span<const PlayerInput> inputs = source.at(tick);
    const auto before = Clock::now();
    if (Status s = started.game->advance(world, inputs); !s) return fail_at(tick, s.error());
    const double took = microseconds_since(before);
    if (out.report) out.report->add_tick(took, world);
    if (want_hashes) out.hashes += std::to_string(tick) + '\t' + hash_text(world.hash()) + '\n';
    return out.recorder ? out.recorder->after_tick(world, inputs) : Status{};
}

Status close_outputs(const Args& args, Started& started, Outputs& out) {
    if (out.recorder)
        if (Status s = out.recorder->close(); !s) return s;
    if (!args.hashes.empty())
        if (Status s = write_file(args.hashes, out.hashes); !s) return s;
    if (!out.report) return {};
    json::Value json = {{"scene", started.game->name()}, {"ticks", started.world.tick_count()}};
    json.update(out.report->json(started.world));
    return write_file(args.report, json.dump(2) + '\n');
}

Result<Exit> run(const Args& args) {
    // Checks the outputs before the run, so that an output that cannot be written is reported at once.
    if (Status s = check_outputs({args.record, args.hashes, args.report}, {args.input}); !s) return s.error();
    Result<Started> started = start(args.choice);
    if (!started) return started.error();
    const std::unique_ptr<Tasks> tasks = tasks_of(args.threads);
    started->world.set_tasks(tasks.get());
    if (Status s = choose_simd(args.simd, started->world); !s) return s.error();
    Result<InputSource> source =
        args.input.empty()
            ? Result<InputSource>(InputSource::scripted(*started->game, args.choice.options.seed))
            : InputSource::open(*started->game, args.input);
    if (!source) return source.error();
    Outputs out;
    if (Status s = open_outputs(args, *started, out); !s) return s.error();
    const Interrupt interrupt;
    {
        Progress progress(args.choice.scene, args.ticks);
        for (std::uint64_t tick = 0; tick < args.ticks && !interrupt.came(); ++tick) {
            if (Status s = run_tick(*started, *source, out, !args.hashes.empty()); !s) return s.error();
            progress.at(tick + 1);
        }
    }
    if (Status s = close_outputs(args, *started, out); !s) return s.error();
    std::printf("%s: %llu ticks, hash %s\n", started->game->name().c_str(),
                static_cast<unsigned long long>(started->world.tick_count()),
                hash_text(started->world.hash()).c_str());
    interrupt.follow();
    return Exit::good;
}

} // namespace

void add_run(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "run", "Run a scene; write a recording, hashes or a report of it.", describe,
                      run);
}

} // namespace lockstone::cli
