// Fuzz target: arbitrary bytes as a recording, read and played. recording_check.h describes the inputs.
#include "fuzz/checks/recording_check.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::RecordingOutcome outcome;
    const std::string complaint = fuzz::check_recording(std::as_bytes(std::span(data, size)), outcome);
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "recording: %s\n", complaint.c_str());
    std::abort();
}
