// The command line: one file per group of commands, each adding its subcommands to one parser.
#pragma once

#include "lockstone/result.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <memory>

namespace lockstone::cli {

/// The exit status that scripts rely on.
enum class Exit : int {
    good = 0,
    check_failed = 1, ///< divergence, mismatch
    bad_input = 2,    ///< usage, files; one sentence on stderr
};

/// What the chosen subcommand does once all arguments are read. An Error is bad input.
using Work = std::function<Result<Exit>()>;

void add_scenes(CLI::App& app, Work& work);
void add_run(CLI::App& app, Work& work);
void add_replay(CLI::App& app, Work& work); ///< replay, info
void add_verify(CLI::App& app, Work& work);
void add_diff(CLI::App& app, Work& work);
void add_branch(CLI::App& app, Work& work);
void add_synctest(CLI::App& app, Work& work);
void add_match(CLI::App& app, Work& work);
void add_bench(CLI::App& app, Work& work);

/// A subcommand whose arguments live as long as the parser: `describe` adds options that fill the Args, `act` runs.
template <class Args>
void add_command(CLI::App& app, Work& work, const std::string& name, const std::string& sentence,
                 void (*describe)(CLI::App&, Args&), Result<Exit> (*act)(const Args&)) {
    CLI::App* command = app.add_subcommand(name, sentence);
    const auto args = std::make_shared<Args>();
    describe(*command, *args);
    command->callback([&work, args, act] { work = [args, act] { return act(*args); }; });
}

int run_command_line(int argc, char** argv);

} // namespace lockstone::cli
