// The command `lockstone self-test`.
#include "cli/commands.h"
#include "cli/text.h"
#include "lockstone/prove.h"
#include "lockstone/testing.h"

#include <cstdio>

namespace lockstone::cli {
namespace {

struct Args {
    bool hashes = false;
};

void describe(CLI::App& command, Args& args) {
    add_flag(command, "--hashes", args.hashes, "print the hashes of this build, which tools/refresh stores");
}

Result<Exit> print_hashes() {
    const Result<std::vector<std::uint64_t>> hashes = testing::self_test_hashes();
    if (!hashes) return hashes.error();
    for (const std::uint64_t hash : *hashes) std::printf("%s\n", hash_text(hash).c_str());
    return Exit::good;
}

Result<Exit> act(const Args& args) {
    if (args.hashes) return print_hashes();
    if (const Status same = self_test(); !same) {
        std::printf("%s\n", same.error().message.c_str());
        return Exit::check_failed;
    }
    std::string sets;
    for (const Simd level : every_simd)
        if (has_simd(level)) sets += std::string(sets.empty() ? "" : ", ") + std::string(name_of(level));
    std::printf("%u worlds, %u ticks each, agree with the stored hashes: %s\n", testing::self_test_worlds,
                testing::self_test_ticks, sets.c_str());
    return Exit::good;
}

} // namespace

void add_self_test(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "self-test",
                      "Run small worlds on this machine and compare their hashes with the stored ones.",
                      describe, act);
}

} // namespace lockstone::cli
