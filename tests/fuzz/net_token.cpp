// Fuzz target: arbitrary bytes as a token or a pass, sealed or not.
#include "fuzz/checks/net_check.h"
#include "fuzz/same_keys.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::draw_the_same_keys();
    const std::string complaint = fuzz::check_token(std::as_bytes(std::span(data, size)));
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "net token: %s\n", complaint.c_str());
    std::abort();
}
