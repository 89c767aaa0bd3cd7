// The command line. Each file holds a group of commands and adds its subcommands to one parser.
#pragma once

#include "lockstone/result.h"
#include "lockstone/tasks.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// Only command_line.cpp includes CLI11: its header takes longer to compile than a command.
namespace CLI {
class App;
class Option;
} // namespace CLI

namespace lockstone::cli {

/// The exit status. Scripts rely on these numbers.
enum class Exit : int {
    good = 0,
    check_failed = 1, ///< divergence, mismatch
    bad_input = 2,    ///< usage, files; one sentence on stderr explains it
};

/// The action of the chosen subcommand; it runs after all arguments are parsed. An Error means bad input.
using Work = std::function<Result<Exit>()>;

void add_scenes(CLI::App& app, Work& work);
void add_run(CLI::App& app, Work& work);
void add_replay(CLI::App& app, Work& work); ///< the commands replay and info
void add_verify(CLI::App& app, Work& work);
void add_diff(CLI::App& app, Work& work);
void add_branch(CLI::App& app, Work& work);
void add_repair(CLI::App& app, Work& work);
void add_format(CLI::App& app, Work& work); ///< prints the tables of replay/FORMAT.md
void add_self_test(CLI::App& app, Work& work);
void add_synctest(CLI::App& app, Work& work);
void add_match(CLI::App& app, Work& work);
void add_bench(CLI::App& app, Work& work);     ///< only with LOCKSTONE_BUILD_BENCH
void add_cook(CLI::App& app, Work& work);      ///< only with LOCKSTONE_BUILD_COOK
void add_relay(CLI::App& app, Work& work);     ///< only with LOCKSTONE_BUILD_NET
void add_broadcast(CLI::App& app, Work& work); ///< only with LOCKSTONE_BUILD_NET
void add_compare(CLI::App& app, Work& work);   ///< only with LOCKSTONE_BUILD_REFERENCE

/// Adds a subcommand: `describe` adds its options, `act` runs after all options are parsed.
void add_subcommand(CLI::App& app, Work& work, const std::string& name, const std::string& sentence,
                    const std::function<void(CLI::App&)>& describe, Work act);

/// Adds a subcommand whose arguments live in an Args: `describe` adds options that fill it, `act` reads it. The Args
/// lives as long as the parser.
template <class Args>
void add_command(CLI::App& app, Work& work, const std::string& name, const std::string& sentence,
                 void (*describe)(CLI::App&, Args&), Result<Exit> (*act)(const Args&)) {
    const auto args = std::make_shared<Args>();
    add_subcommand(
        app, work, name, sentence, [&](CLI::App& command) { describe(command, *args); },
        [args, act] { return act(*args); });
}

/// A handle to an option of the parser, for further settings.
class Option {
  public:
    explicit Option(CLI::Option* added) : option(added) {}
    const Option& required() const;
    const Option& show_default() const;                                ///< shows the default in --help
    const Option& one_of(const std::vector<std::string>& names) const; ///< another value is bad usage
    const Option& hide() const;                                        ///< leaves the option out of --help
    const Option& type_name(const std::string& name) const;            ///< the name of the value in --help

  private:
    CLI::Option* option;
};

Option add_text(CLI::App& command, const std::string& name, std::string& value, const std::string& sentence);
/// An option with any number of values.
Option add_texts(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                 const std::string& sentence);
Option add_flag(CLI::App& command, const std::string& name, bool& value, const std::string& sentence);

/// An option whose value is a whole number from `low` to `high`, in decimal digits. The parser's own conversion would
/// accept -1 as 2^64 - 1.
Option add_number(CLI::App& command, const std::string& name, std::uint64_t& value,
                  const std::string& sentence, std::uint64_t low = 0, std::uint64_t high = UINT64_MAX);
Option add_number(CLI::App& command, const std::string& name, std::uint32_t& value,
                  const std::string& sentence, std::uint32_t low = 0, std::uint32_t high = UINT32_MAX);
Option add_number(CLI::App& command, const std::string& name, std::optional<std::uint64_t>& value,
                  const std::string& sentence);

/// An option with several numbers, separated by commas.
Option add_numbers(CLI::App& command, const std::string& name, std::vector<int>& values,
                   const std::string& sentence, int low, int high);

/// An option whose value is a number from `low` to `high`; not-a-number is an error.
Option add_real(CLI::App& command, const std::string& name, double& value, const std::string& sentence,
                double low, double high);
Option add_real(CLI::App& command, const std::string& name, std::optional<double>& value,
                const std::string& sentence, double low, double high);

/// The option --threads, from 1 to workers_max.
void add_threads(CLI::App& command, std::uint32_t& threads);
/// The worker threads for World::set_tasks; null for one thread.
std::unique_ptr<Tasks> tasks_of(std::uint32_t threads);

int run_command_line(int argc, char** argv);

} // namespace lockstone::cli
