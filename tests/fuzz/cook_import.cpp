// Fuzz target: arbitrary bytes as a model file. The importer must return an error sentence or a soup that passes the
// checks.
//
// The reader runs in this process, from memory. A failure that would end the importing process (tools/cook/import.h) is
// no fault of this project and must not end the run. A failed assertion within assimp becomes an exception below. After
// a crash or an endless loop libFuzzer's -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1 continues.
// `lockstone cook` returns an error sentence for the remaining inputs.
//
// The alarm of libFuzzer's -timeout prints a stack and dumps the input before it ends the process. If it interrupts the
// library within malloc, it waits for the allocator's lock forever, and so does the parent process. So a thread that
// allocates nothing ends the process when one input takes too long.
//
// The first byte of an input selects the format; the rest is the file.
#include "cook/import.h"
#include "cook/read/read_model.h"
#include "cook_input.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include <unistd.h>

namespace Assimp {
/// Replaces the library's own function, which aborts.
void aiAssertViolation(const char* failed, const char* file, int line);
void aiAssertViolation(const char* failed, const char*, int) { throw std::runtime_error(failed); }
} // namespace Assimp

namespace {

using namespace lockstone;
using namespace lockstone::cook;

std::string complaint(std::span<const std::byte> file, const char* extension) {
    const Result<Soup> soup = read_model(file, extension);
    if (!soup) return soup.error().message.empty() ? "an error without a sentence" : "";
    if (soup->triangles.empty()) return "a model without triangles";
    if (!check(*soup, import_coordinate_max).empty()) return {}; // `import_model` refuses this soup
    return check(compacted(welded(*soup)), import_coordinate_max).empty() ? "" : "welding breaks it";
}

/// The numbers of inputs begun and ended. They are equal between two inputs.
std::atomic<std::uint64_t> begun = 0;
std::atomic<std::uint64_t> ended = 0;

constexpr auto longest_input = std::chrono::seconds(8);
constexpr int timeout_status = 70; // libFuzzer's, which -ignore_timeouts=1 recognizes

/// Ends the process when one input runs longer than `longest_input`.
void watch() {
    std::uint64_t watched = 0; // the input that ran at the last check
    for (;;) {
        std::this_thread::sleep_for(longest_input);
        const std::uint64_t now = begun;
        if (now == watched && ended != now) _exit(timeout_status);
        watched = now;
    }
}

} // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    std::thread(watch).detach();
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    ++begun;
    std::string wrong;
    try {
        wrong = complaint(std::as_bytes(std::span(data + 1, size - 1)),
                          fuzz::import_extensions[data[0] % fuzz::import_extensions.size()]);
    } catch (const std::exception&) {} // the importing process returns it as a sentence
    ++ended;
    if (wrong.empty()) return 0;
    std::fprintf(stderr, "ERROR: cook import: %s\n", wrong.c_str());
    std::abort();
}
