// The command line: one file per group of commands, each adding its subcommands to one parser.
#pragma once

#include "lockstone/result.h"
#include "lockstone/tasks.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// CLI11 is read by command_line.cpp alone: its header takes longer to compile than a command.
namespace CLI {
class App;
class Option;
} // namespace CLI

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
void add_format(CLI::App& app, Work& work); ///< the tables of replay/FORMAT.md
void add_self_test(CLI::App& app, Work& work);
void add_synctest(CLI::App& app, Work& work);
void add_match(CLI::App& app, Work& work);
void add_bench(CLI::App& app, Work& work);     ///< only where LOCKSTONE_BUILD_BENCH is on
void add_cook(CLI::App& app, Work& work);      ///< only where LOCKSTONE_BUILD_COOK is on
void add_relay(CLI::App& app, Work& work);     ///< only where LOCKSTONE_BUILD_NET is on
void add_broadcast(CLI::App& app, Work& work); ///< likewise
void add_compare(CLI::App& app, Work& work);   ///< only where LOCKSTONE_BUILD_REFERENCE is on

/// A subcommand: `describe` adds its options, `act` runs once all are read.
void add_subcommand(CLI::App& app, Work& work, const std::string& name, const std::string& sentence,
                    const std::function<void(CLI::App&)>& describe, Work act);

/// The same for arguments that live as long as the parser: `describe` adds options that fill the Args.
template <class Args>
void add_command(CLI::App& app, Work& work, const std::string& name, const std::string& sentence,
                 void (*describe)(CLI::App&, Args&), Result<Exit> (*act)(const Args&)) {
    const auto args = std::make_shared<Args>();
    add_subcommand(
        app, work, name, sentence, [&](CLI::App& command) { describe(command, *args); },
        [args, act] { return act(*args); });
}

/// An option that has been added.
class Option {
  public:
    explicit Option(CLI::Option* added) : option(added) {}
    const Option& required() const;
    const Option& show_default() const;                                ///< in --help
    const Option& one_of(const std::vector<std::string>& names) const; ///< else bad usage
    const Option& hide() const;                                        ///< from --help
    const Option& type_name(const std::string& name) const;            ///< in --help

  private:
    CLI::Option* option;
};

Option add_text(CLI::App& command, const std::string& name, std::string& value, const std::string& sentence);
/// As many as are given.
Option add_texts(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                 const std::string& sentence);
Option add_flag(CLI::App& command, const std::string& name, bool& value, const std::string& sentence);

/// An option that is a whole number from `low` to `high`: digits and nothing else. The parser's own conversion takes
/// -1 for 2^64 - 1.
Option add_number(CLI::App& command, const std::string& name, std::uint64_t& value,
                  const std::string& sentence, std::uint64_t low = 0, std::uint64_t high = UINT64_MAX);
Option add_number(CLI::App& command, const std::string& name, std::uint32_t& value,
                  const std::string& sentence, std::uint32_t low = 0, std::uint32_t high = UINT32_MAX);
Option add_number(CLI::App& command, const std::string& name, std::optional<std::uint64_t>& value,
                  const std::string& sentence);

/// Several, with commas between them.
Option add_numbers(CLI::App& command, const std::string& name, std::vector<int>& values,
                   const std::string& sentence, int low, int high);

/// A number from `low` to `high`, not-a-number excluded.
Option add_real(CLI::App& command, const std::string& name, double& value, const std::string& sentence,
                double low, double high);
Option add_real(CLI::App& command, const std::string& name, std::optional<double>& value,
                const std::string& sentence, double low, double high);

/// --threads, 1 to workers_max.
void add_threads(CLI::App& command, std::uint32_t& threads);
/// For World::set_tasks: null when one thread is to do it all.
std::unique_ptr<Tasks> tasks_of(std::uint32_t threads);

int run_command_line(int argc, char** argv);

} // namespace lockstone::cli
