#include "cli/commands.h"

#include <algorithm>
#include <cstdio>

namespace lockstone::cli {
namespace {

/// One sentence on one line.
int report_bad_input(std::string sentence) {
    std::ranges::replace(sentence, '\n', ' ');
    std::fprintf(stderr, "lockstone: %s\n", sentence.c_str());
    return static_cast<int>(Exit::bad_input);
}

void add_all(CLI::App& app, Work& work) {
    add_scenes(app, work);
    add_run(app, work);
    add_replay(app, work);
    add_verify(app, work);
    add_diff(app, work);
    add_branch(app, work);
    add_synctest(app, work);
    add_match(app, work);
    add_bench(app, work);
}

/// Told before parsing: the parser would only say that a command is missing.
bool is_unknown_command(const CLI::App& app, int argc, char** argv) {
    if (argc < 2 || argv[1][0] == '-') return false;
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    return std::ranges::none_of(commands, [&](const CLI::App* c) { return c->get_name() == argv[1]; });
}

} // namespace

int run_command_line(int argc, char** argv) {
    CLI::App app("Runs, records, replays and verifies deterministic worlds.", "lockstone");
    app.require_subcommand(1);
    app.footer("Exit status: 0 good; 1 a check failed; 2 bad usage or bad input.");
    Work work;
    add_all(app, work);
    if (is_unknown_command(app, argc, argv))
        return report_bad_input(std::string("there is no command '") + argv[1] +
                                "' (lockstone --help lists the commands)");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) { return app.exit(help); } catch (const CLI::ParseError& e) {
        return report_bad_input(std::string(e.what()) + " (lockstone --help lists the commands)");
    }
    const Result<Exit> result = work();
    if (!result) return report_bad_input(result.error().message);
    if (std::fflush(stdout) != 0) return report_bad_input("standard output: cannot write");
    return static_cast<int>(*result);
}

} // namespace lockstone::cli
