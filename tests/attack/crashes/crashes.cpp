// Recorders that are killed at a random time, or stopped by a full disk.
#include "attack/attack.h"
#include "lockstone/math/random.h"
#include "replay/branch.h"
#include "support/small_recording.h"

#include <csignal>
#include <filesystem>

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

using namespace attack;
using lockstone::Random;
using namespace lockstone;
using namespace lockstone::replay;
using test::must;

constexpr std::uint64_t keyframe_ticks = 20;

/// Data that a recorder writes into shared memory before it is killed.
struct Told {
    std::uint64_t ticks_flushed;
};

/// Records until it is killed or the disk is full. Stores the number of flushed ticks in its last argument.
[[noreturn]] void record(const std::string& path, std::uint32_t block_ticks, Told& told) {
    const test::SmallGame game;
    World world = must(game.start());
    Result<FileSink> sink = FileSink::create(path);
    if (!sink) std::_Exit(3);
    Result<InputRecorder> recorder = InputRecorder::begin(
        *sink, game, world, {.keyframe_ticks = keyframe_ticks, .block_ticks = block_ticks});
    if (!recorder) std::_Exit(4);
    for (;;) {
        const test::SmallInputs inputs(test::SmallGame::script(world.tick_count()));
        must(game.advance(world, inputs.list));
        if (const Status status = recorder->after_tick(world, inputs.list); !status) {
            if (status.error().message.find(path) != 0 || recorder->close()) std::_Exit(5);
            std::_Exit(0);
        }
        // A block is written when it is full, and before a keyframe.
        const std::uint64_t now = world.tick_count(), keyframe = now / keyframe_ticks * keyframe_ticks;
        told.ticks_flushed = keyframe + (now - keyframe) / block_ticks * block_ticks;
    }
}

/// Reads, verifies and repairs the file that the recorder left.
std::string check_rest(const std::string& path, const Told& told, Figures& figures) {
    const test::SmallGame game;
    const Result<Recording> rest = Recording::open(path, OnDamage::recover_cut);
    if (!rest) {
        ++figures["unreadable"];
        return told.ticks_flushed == 0 ? "" : "not readable: " + rest.error().message;
    }
    ++figures["readable"];
    figures["ticks"] += rest->tick_count();
    if (rest->complete()) return "called complete";
    if (rest->end_tick() < told.ticks_flushed)
        return std::to_string(told.ticks_flushed) + " ticks were flushed, " +
               std::to_string(rest->end_tick()) + " are left";
    const VerifyReport report = verify(*rest, &game);
    if (report.verdict != Verdict::incomplete) return "the verdict is not incomplete: " + report.sentence;
    if (rest->tick_count() == 0) return {};
    MemorySink whole;
    if (const Status status = repair(*rest, whole); !status)
        return "cannot be repaired: " + status.error().message;
    const Recording repaired = must(test::read(whole.bytes));
    const VerifyReport again = verify(repaired, &game);
    return again.good() && again.ticks == rest->tick_count() ? "" : "repaired, but: " + again.sentence;
}

std::string crash(Random& random, const Options& options, Told& told, Figures& figures) {
    const std::string path =
        (std::filesystem::temp_directory_path() / ("attack-" + std::to_string(getpid()) + ".lsr")).string();
    std::filesystem::remove(path);
    const bool disk_full = random.below(3) == 0;
    const std::uint32_t block_ticks = 1u << random.below(6);
    const std::uint32_t disk = random.below(60000), wait_us = random.below(60000);
    told = {};
    const pid_t pid = fork();
    if (pid == 0) {
        if (disk_full) {
            const rlimit most{disk, disk};
            std::signal(SIGXFSZ, SIG_IGN);
            setrlimit(RLIMIT_FSIZE, &most);
        }
        record(path, block_ticks, told);
    }
    if (!disk_full) {
        usleep(wait_us);
        kill(pid, SIGKILL);
    }
    int status = 0;
    waitpid(pid, &status, 0);
    ++figures[disk_full ? "disk full" : "killed"];
    if (disk_full && WIFEXITED(status) && WEXITSTATUS(status) == 4) return {}; // not even a header
    if (disk_full && status != 0) return "a full disk is not told";
    if (options.planted == "lost" && std::filesystem::exists(path)) { told.ticks_flushed += 100; }
    std::string wrong;
    if (std::filesystem::exists(path)) wrong = check_rest(path, told, figures);
    std::filesystem::remove(path);
    return wrong;
}

} // namespace

int main(int argc, char** argv) {
    const Options options = read_options("crashes", argc, argv);
    void* const memory =
        mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return 2;
    Told& told = *new (memory) Told{};
    return run(options, [&](std::uint64_t i, Figures& figures) {
        Random random = Random::seeded(options.seed, 1 + i);
        return crash(random, options, told, figures);
    });
}
