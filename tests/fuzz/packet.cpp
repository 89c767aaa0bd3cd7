// Fuzz target: arbitrary packets to a session during a match. packet_check.h describes the inputs.
#include "fuzz/checks/packet_check.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::PacketOutcome outcome;
    const std::string complaint = fuzz::check_packets(std::as_bytes(std::span(data, size)), outcome);
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "packet: %s\n", complaint.c_str());
    std::abort();
}
