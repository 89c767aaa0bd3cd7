// What stands around the bytes of a state: in front what they are and how many, behind them a checksum.
#pragma once

#include "base/bytes.h"

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace lockstone {

struct Envelope {
    std::string_view magic; ///< seven letters and a line feed, which shows a transfer that rewrote line ends
    std::string_view noun;  ///< "image": what errors call the bytes
};
inline constexpr Envelope image_envelope{"LSSTATE\n", "image"};
inline constexpr Envelope delta_envelope{"LSDELTA\n", "delta"};

inline constexpr std::size_t envelope_head_bytes = 20, envelope_checksum_bytes = 8;

/// Magic, version 1, and a size that seal_envelope fills in. `out` is empty.
void begin_envelope(const Envelope& envelope, std::vector<std::byte>& out);
void seal_envelope(std::vector<std::byte>& out);
/// Whether these are bytes that were once sealed. On any error the reader holds the sentence.
void check_envelope(const Envelope& envelope, base::ByteReader& in, std::span<const std::byte> bytes);

} // namespace lockstone
