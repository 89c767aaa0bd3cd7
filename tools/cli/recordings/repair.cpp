// The command `lockstone repair`.
#include "cli/recordings/recording_choice.h"
#include "cli/text.h"
#include "replay/branch.h"

#include <string>

namespace lockstone::cli {
namespace {

struct Args {
    std::string file, out;
    LimitChoice limits;
};

void describe(CLI::App& command, Args& args) {
    add_text(command, "FILE", args.file, "a recording (.lsr) that was cut or damaged").required();
    add_text(command, "-o,--output", args.out, "file to write: a complete recording of the undamaged part")
        .required();
    describe_limits(command, args.limits);
}

Result<Exit> repair(const Args& args) {
    if (Status s = check_outputs({args.out}, {args.file}); !s) return s.error();
    const Result<replay::Recording> recording =
        replay::Recording::open(args.file, replay::OnDamage::recover, args.limits.limits());
    if (!recording) return recording.error();
    if (recording->complete()) return Error{args.file + ": is complete and needs no repair"};
    Result<replay::FileSink> sink = replay::FileSink::create(args.out);
    if (!sink) return sink.error();
    if (Status s = replay::repair(*recording, *sink); !s) return s.error();
    print_line(recording->damage());
    print_line(args.out + ": complete, ticks " + std::to_string(recording->start_tick()) + " to " +
               std::to_string(recording->end_tick()));
    return Exit::good;
}

} // namespace

void add_repair(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "repair",
                      "Make a complete recording from the undamaged part of a cut or damaged one.", describe,
                      repair);
}

} // namespace lockstone::cli
