// The command `lockstone diff`.
#include "replay/diff.h"
#include "cli/recordings/recording_choice.h"
#include "cli/text.h"

#include <sstream>

namespace lockstone::cli {
namespace {

struct Args {
    std::string left, right;
    LimitChoice limits;
};

void describe(CLI::App& command, Args& args) {
    add_text(command, "A", args.left, "a recording (.lsr)").required();
    add_text(command, "B", args.right, "a recording (.lsr) to compare with A").required();
    describe_limits(command, args.limits);
}

Result<Exit> compare(const Args& args) {
    const Result<Loaded> left = load(args.left, args.limits.half()),
                         right = load(args.right, args.limits.half());
    if (!left) return left.error();
    if (!right) return right.error();
    const Result<replay::DiffReport> report =
        replay::diff({left->recording, left->game.get()}, {right->recording, right->game.get()});
    if (!report) return report.error();
    std::istringstream lines(report->text);
    for (std::string line; std::getline(lines, line);) print_line(line);
    return report->states_agree && !report->input_tick ? Exit::good : Exit::check_failed;
}

} // namespace

void add_diff(CLI::App& app, Work& work) {
    add_command<Args>(
        app, work, "diff",
        "Find the first difference of two recordings: tick, phase, column, row, field, both values.",
        describe, compare);
}

} // namespace lockstone::cli
