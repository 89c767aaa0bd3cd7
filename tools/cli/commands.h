// The command line: one file per group of commands, each adding its subcommands to one parser.
#pragma once

#include "lockstone/result.h"
#include "lockstone/tasks.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

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
void add_repair(CLI::App& app, Work& work);
void add_synctest(CLI::App& app, Work& work);
void add_match(CLI::App& app, Work& work);
void add_bench(CLI::App& app, Work& work);
void add_cook(CLI::App& app, Work& work); ///< only where LOCKSTONE_BUILD_COOK is on

/// A subcommand whose arguments live as long as the parser: `describe` adds options that fill the Args, `act` runs.
template <class Args>
void add_command(CLI::App& app, Work& work, const std::string& name, const std::string& sentence,
                 void (*describe)(CLI::App&, Args&), Result<Exit> (*act)(const Args&)) {
    CLI::App* command = app.add_subcommand(name, sentence);
    const auto args = std::make_shared<Args>();
    describe(*command, *args);
    command->callback([&work, args, act] { work = [args, act] { return act(*args); }; });
}

/// An option that is a whole number from `low` to `high`: digits and nothing else. The parser's own conversion takes
/// -1 for 2^64 - 1.
CLI::Option* add_number(CLI::App& command, const std::string& name, std::uint64_t& value,
                        const std::string& sentence, std::uint64_t low = 0, std::uint64_t high = UINT64_MAX);
CLI::Option* add_number(CLI::App& command, const std::string& name, std::uint32_t& value,
                        const std::string& sentence, std::uint32_t low = 0, std::uint32_t high = UINT32_MAX);
CLI::Option* add_number(CLI::App& command, const std::string& name, std::optional<std::uint64_t>& value,
                        const std::string& sentence);

/// --threads, 1 to workers_max.
void add_threads(CLI::App& command, std::uint32_t& threads);
/// For World::set_tasks: null when one thread is to do it all.
std::unique_ptr<Tasks> tasks_of(std::uint32_t threads);

int run_command_line(int argc, char** argv);

} // namespace lockstone::cli
