#include "cli/commands.h"
#include "cli/text.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <new>

#include <fcntl.h>
#include <unistd.h>

namespace lockstone::cli {
namespace {

/// Prints one sentence on one line of stderr and returns the status for bad input. shown() escapes control characters
/// that come from files and arguments.
int report_bad_input(std::string sentence) {
    constexpr std::size_t longest = 4000;
    std::ranges::replace(sentence, '\n', ' ');
    std::fprintf(stderr, "lockstone: %s\n", shown(sentence, longest).c_str());
    return static_cast<int>(Exit::bad_input);
}

/// The exit status of the program: `status`, or bad input if some output was lost. Lines are written as they are
/// printed, so ferror is checked too: the last flush may succeed although an earlier write failed.
int after_output(int status) {
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
    return report_bad_input("standard output: cannot write");
}

/// Opens /dev/null for standard files that the caller has closed. Otherwise the next file that is opened would take the
/// place of standard output, and printed lines would go into it. /dev/null is opened for reading only, so writes to it
/// fail.
void hold_standard_files() {
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(descriptor, F_GETFD) < 0) static_cast<void>(::open("/dev/null", O_RDONLY));
}

void add_all(CLI::App& app, Work& work) {
    add_scenes(app, work);
    add_run(app, work);
    add_replay(app, work);
    add_verify(app, work);
    add_diff(app, work);
    add_branch(app, work);
    add_repair(app, work);
    add_format(app, work);
    add_self_test(app, work);
    add_synctest(app, work);
    add_match(app, work);
#ifdef LOCKSTONE_BENCH
    add_bench(app, work);
#endif
#ifdef LOCKSTONE_COOK
    add_cook(app, work);
#endif
#ifdef LOCKSTONE_NET
    add_relay(app, work);
    add_broadcast(app, work);
#endif
#ifdef LOCKSTONE_REFERENCE
    add_compare(app, work);
#endif
}

/// Checked before parsing, because the parser would only report that a command is missing.
bool is_unknown_command(const CLI::App& app, int argc, char** argv) {
    if (argc < 2 || argv[1][0] == '-') return false;
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    return std::ranges::none_of(commands, [&](const CLI::App* c) { return c->get_name() == argv[1]; });
}

/// Empty if `text` is a number in the range, else an error sentence.
std::string check_number(const std::string& text, std::uint64_t low, std::uint64_t high) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc{} && end == text.data() + text.size() && value >= low && value <= high) return {};
    return "'" + text + "' is not a whole number from " + std::to_string(low) + " to " + std::to_string(high);
}

template <class N>
Option add_checked(CLI::App& command, const std::string& name, N& value, const std::string& sentence,
                   std::uint64_t low, std::uint64_t high) {
    CLI::Option* option = command.add_option(name, value, sentence);
    option->check(
        CLI::Validator([low, high](const std::string& text) { return check_number(text, low, high); }, ""));
    return Option(option);
}

/// Empty if `text` is a number in the range, else an error sentence.
std::string check_real(const std::string& text, double low, double high) {
    double given = 0;
    if (CLI::detail::lexical_cast(text, given) && given >= low && given <= high) return {};
    char range[96];
    std::snprintf(range, sizeof range, "' is not a number from %g to %g", low, high);
    return "'" + text + range;
}

template <class N>
Option add_real_number(CLI::App& command, const std::string& name, N& value, const std::string& sentence,
                       double low, double high) {
    CLI::Option* option = command.add_option(name, value, sentence);
    option->check(
        CLI::Validator([low, high](const std::string& text) { return check_real(text, low, high); }, ""));
    return Option(option);
}

} // namespace

void add_subcommand(CLI::App& app, Work& work, const std::string& name, const std::string& sentence,
                    const std::function<void(CLI::App&)>& describe, Work act) {
    CLI::App* command = app.add_subcommand(name, sentence);
    describe(*command);
    command->callback([&work, act] { work = act; });
}

const Option& Option::required() const {
    option->required();
    return *this;
}

const Option& Option::show_default() const {
    option->capture_default_str();
    return *this;
}

const Option& Option::one_of(const std::vector<std::string>& names) const {
    option->check(CLI::IsMember(names));
    return *this;
}

const Option& Option::hide() const {
    option->group("");
    return *this;
}

const Option& Option::type_name(const std::string& name) const {
    option->type_name(name);
    return *this;
}

Option add_text(CLI::App& command, const std::string& name, std::string& value, const std::string& sentence) {
    return Option(command.add_option(name, value, sentence));
}

Option add_texts(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                 const std::string& sentence) {
    return Option(command.add_option(name, values, sentence));
}

Option add_flag(CLI::App& command, const std::string& name, bool& value, const std::string& sentence) {
    return Option(command.add_flag(name, value, sentence));
}

Option add_number(CLI::App& command, const std::string& name, std::uint64_t& value,
                  const std::string& sentence, std::uint64_t low, std::uint64_t high) {
    return add_checked(command, name, value, sentence, low, high).show_default();
}

Option add_number(CLI::App& command, const std::string& name, std::uint32_t& value,
                  const std::string& sentence, std::uint32_t low, std::uint32_t high) {
    return add_checked(command, name, value, sentence, low, high).show_default();
}

Option add_number(CLI::App& command, const std::string& name, std::optional<std::uint64_t>& value,
                  const std::string& sentence) {
    return add_checked(command, name, value, sentence, 0, UINT64_MAX);
}

Option add_numbers(CLI::App& command, const std::string& name, std::vector<int>& values,
                   const std::string& sentence, int low, int high) {
    return Option(command.add_option(name, values, sentence)->delimiter(',')->check(CLI::Range(low, high)));
}

Option add_real(CLI::App& command, const std::string& name, double& value, const std::string& sentence,
                double low, double high) {
    return add_real_number(command, name, value, sentence, low, high);
}

Option add_real(CLI::App& command, const std::string& name, std::optional<double>& value,
                const std::string& sentence, double low, double high) {
    return add_real_number(command, name, value, sentence, low, high);
}

void add_threads(CLI::App& command, std::uint32_t& threads) {
    add_number(command, "--threads", threads,
               "number of threads that share the work of a tick, 1 to 64; the result does not depend on it",
               1, workers_max);
}

std::unique_ptr<Tasks> tasks_of(std::uint32_t threads) {
    return threads > 1 ? make_worker_pool(threads) : nullptr;
}

int run_command_line(int argc, char** argv) {
    hold_standard_files();
    // Line buffered: a run that is killed leaves the lines that it printed.
    std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
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
    } catch (const CLI::Success& help) {
        return after_output(app.exit(help));
    } catch (const CLI::ParseError& e) {
        const bool has_command = argc > 1 && argv[1][0] != '-';
        return report_bad_input(std::string(e.what()) +
                                (has_command
                                     ? " (lockstone " + std::string(argv[1]) + " --help lists its options)"
                                     : std::string(" (lockstone --help lists the commands)")));
    }
    try {
        const Result<Exit> result = work();
        if (!result) return report_bad_input(result.error().message);
        return after_output(static_cast<int>(*result));
    } catch (const std::bad_alloc&) {
        return report_bad_input("there is not enough memory for this command");
    }
}

} // namespace lockstone::cli
