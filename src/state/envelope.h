// The frame around the bytes of a state: magic, version and size in front, a checksum at the end.
#pragma once

#include "base/bytes.h"

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace lockstone {

struct Envelope {
    std::string_view magic; ///< seven letters and a line feed, which reveals a changed line end
    std::string_view noun;  ///< "image": the name of the bytes in error sentences
};
inline constexpr Envelope image_envelope{"LSSTATE\n", "image"};
inline constexpr Envelope delta_envelope{"LSDELTA\n", "delta"};

inline constexpr std::size_t envelope_head_bytes = 20, envelope_checksum_bytes = 8;

/// Writes the magic, version 1, and a size that seal_envelope() fills in. `out` must be empty.
void begin_envelope(const Envelope& envelope, std::vector<std::byte>& out);
void seal_envelope(std::vector<std::byte>& out);
/// Checks the magic, version, size and checksum. On an error the reader holds the sentence.
void check_envelope(const Envelope& envelope, base::ByteReader& in, std::span<const std::byte> bytes);

} // namespace lockstone
