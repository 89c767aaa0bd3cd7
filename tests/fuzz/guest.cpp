// Fuzz target: packets of those who watch, come in or ask about a desync. The inputs are described in guest_check.h.
#include "fuzz/checks/guest_check.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string complaint = fuzz::check_guest_packet(std::as_bytes(std::span(data, size)));
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "guest: %s\n", complaint.c_str());
    std::abort();
}
