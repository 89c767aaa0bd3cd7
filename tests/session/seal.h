// Writes a valid checksum into a changed packet, so that the change reaches the checks after the checksum.
#pragma once

#include "session/link/message.h"

#include "base/bytes.h"
#include "base/hash.h"

namespace lockstone::test {

/// Takes packets of both forms. Sequence numbers and ticks are below 65,536, as the packet holds them.
inline void seal(std::vector<std::byte>& packet, std::uint32_t match) {
    if (packet.size() < 9) return;
    const std::span body(packet.data(), packet.size() - 4);
    const bool is_short = (std::to_integer<unsigned>(packet[0]) & 0x80u) != 0;
    base::HashStream left_out;
    left_out.add(match);
    left_out.add(std::uint32_t{base::load_little_endian<std::uint16_t>(packet.data() + 1)});
    left_out.add(std::uint32_t{base::load_little_endian<std::uint16_t>(packet.data() + 3)});
    const std::uint64_t sum = base::xxh3(body, is_short ? left_out.digest() : 0);
    base::store_little_endian(static_cast<std::uint32_t>(sum), packet.data() + body.size());
}

} // namespace lockstone::test
