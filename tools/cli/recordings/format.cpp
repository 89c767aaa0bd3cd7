// The command `lockstone format`: prints the tables of replay/FORMAT.md.
#include "cli/commands.h"
#include "cli/recordings/format_tables.h"

#include <cstdio>

namespace lockstone::cli {
namespace {

struct Args {};
void describe(CLI::App&, Args&) {}

Result<Exit> print(const Args&) {
    std::fputs(format_tables().c_str(), stdout);
    return Exit::good;
}

} // namespace

void add_format(CLI::App& app, Work& work) {
    add_command<Args>(
        app, work, "format",
        "Print the tables of replay/FORMAT.md, made from the descriptions of commands and state.", describe,
        print);
}

} // namespace lockstone::cli
