// The command `lockstone branch`.
#include "replay/branch.h"
#include "cli/input_source.h"
#include "cli/interrupt.h"
#include "cli/recordings/recording_choice.h"
#include "cli/text.h"

#include <optional>

namespace lockstone::cli {
namespace {

struct Args {
    std::string file, input, out;
    std::uint64_t at = 0;
    std::optional<std::uint64_t> ticks;
    LimitChoice limits;
};

void describe(CLI::App& command, Args& args) {
    add_text(command, "FILE", args.file, "a recording (.lsr)").required();
    add_number(command, "--at", args.at, "tick up to which the recording is copied").required();
    add_text(
        command, "--input", args.input,
        "file with the inputs after that tick: text (see tools/README.md) or a recording; default: no input");
    add_number(
        command, "--ticks", args.ticks,
        "number of ticks to run after the copy; default: with --input up to the recording's end, else 0");
    add_text(command, "-o,--output", args.out, "file to write: the new recording").required();
    describe_limits(command, args.limits);
}

std::uint64_t ticks_after(const Args& args, const replay::Recording& recording) {
    if (args.ticks) return *args.ticks;
    return args.input.empty() ? 0 : recording.end_tick() - args.at;
}

/// The inputs of the players after the branch; empty without players. Reports errors before the first write to the
/// output.
Result<std::optional<InputSource>> inputs_of(const Args& args, const Loaded& loaded) {
    if (loaded.game == nullptr) {
        if (args.input.empty()) return std::optional<InputSource>();
        return Error{args.file + ": holds commands, not inputs; leave out --input"};
    }
    Result<InputSource> source = args.input.empty() ? Result<InputSource>(InputSource::idle(*loaded.game))
                                                    : InputSource::open(*loaded.game, args.input);
    if (!source) return source.error();
    return std::optional<InputSource>(std::move(*source));
}

/// A file that is created when the first bytes arrive. If no bytes arrive, a file of that name stays as it was.
class LateSink final : public replay::Sink {
  public:
    explicit LateSink(std::string where) : path(std::move(where)) {}
    Status append(std::span<const std::byte> bytes) override {
        if (!file) {
            Result<replay::FileSink> created = replay::FileSink::create(path);
            if (!created) return created.error();
            file.emplace(std::move(*created));
        }
        return file->append(bytes);
    }
    Status close() override { return file ? file->close() : Status{}; }

  private:
    std::string path;
    std::optional<replay::FileSink> file;
};

Result<World> branch_with_inputs(const Args& args, const Loaded& loaded, InputSource& source,
                                 replay::Sink& sink, const Interrupt& interrupt) {
    Result<replay::InputBranch> branch = replay::branch_inputs(loaded.recording, *loaded.game, args.at, sink);
    if (!branch) return branch.error();
    for (std::uint64_t left = ticks_after(args, loaded.recording); left > 0 && !interrupt.came(); --left) {
        const std::span<const PlayerInput> inputs = source.at(branch->world.tick_count());
        if (Status s = loaded.game->advance(branch->world, inputs); !s) return s.error();
        if (Status s = branch->recorder.after_tick(branch->world, inputs); !s) return s.error();
    }
    if (Status s = branch->recorder.close(); !s) return s.error();
    return std::move(branch->world);
}

Result<World> branch_without_game(const Args& args, const Loaded& loaded, replay::Sink& sink,
                                  const Interrupt& interrupt) {
    Result<replay::CommandBranch> branch = replay::branch_commands(loaded.recording, args.at, sink);
    if (!branch) return branch.error();
    World world = std::move(branch->world);
    const auto recorder =
        replay::CommandRecorder::resume(std::move(branch->writer), world, replay::keyframe_ticks_default);
    for (std::uint64_t left = ticks_after(args, loaded.recording); left > 0 && !interrupt.came(); --left)
        world.tick();
    if (Status s = recorder->close(); !s) return s.error();
    return world;
}

Result<Exit> branch(const Args& args) {
    if (Status s = check_outputs({args.out}, {args.file, args.input}); !s) return s.error();
    const Result<Loaded> loaded = load(args.file, args.limits.limits());
    if (!loaded) return loaded.error();
    const replay::Recording& recording = loaded->recording;
    if (args.at < recording.start_tick() || args.at > recording.end_tick())
        return Error{args.file + ": holds ticks " + std::to_string(recording.start_tick()) + " to " +
                     std::to_string(recording.end_tick()) + ", not " + std::to_string(args.at)};
    Result<std::optional<InputSource>> source = inputs_of(args, *loaded);
    if (!source) return source.error();
    LateSink sink(args.out);
    const Interrupt interrupt;
    const Result<World> world = *source ? branch_with_inputs(args, *loaded, **source, sink, interrupt)
                                        : branch_without_game(args, *loaded, sink, interrupt);
    if (!world) return world.error();
    print_line(args.out + ": ticks up to " + std::to_string(args.at) + " copied from " + args.file +
               ", ticks up to " + std::to_string(world->tick_count()) + " simulated, hash " +
               hash_text(world->hash()));
    interrupt.follow();
    return Exit::good;
}

} // namespace

void add_branch(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "branch", "Copy a recording up to a tick and continue with other inputs.",
                      describe, branch);
}

} // namespace lockstone::cli
