// Fuzz target: packets of spectators, of joining machines and about desyncs. guest_check.h describes the inputs.
#include "fuzz/checks/guest_check.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string complaint = fuzz::check_guest_packet(std::as_bytes(std::span(data, size)));
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "guest: %s\n", complaint.c_str());
    std::abort();
}
