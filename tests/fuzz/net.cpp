// Fuzz target: arbitrary datagrams to players and a relay during a match. net_check.h describes the inputs.
#include "fuzz/checks/net_check.h"
#include "fuzz/same_keys.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::draw_the_same_keys();
    fuzz::NetOutcome outcome;
    const std::string complaint = fuzz::check_net(std::as_bytes(std::span(data, size)), outcome);
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "net: %s\n", complaint.c_str());
    std::abort();
}
