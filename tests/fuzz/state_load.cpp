// Fuzz target: arbitrary bytes as a world's state, a portable image or a delta. state_check.h describes the inputs.
#include "fuzz/checks/state_check.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    bool loaded = false;
    const std::string complaint = fuzz::check_state_load(std::as_bytes(std::span(data, size)), loaded);
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "state: %s\n", complaint.c_str());
    std::abort();
}
