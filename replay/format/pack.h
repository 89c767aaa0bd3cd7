// Packed bytes and planes, as FORMAT.md specifies them: simple, exact, and fast enough to be always on.
#pragma once

#include "lockstone/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace lockstone::replay {

/// The most bytes per packed byte: two bytes become at most 130.
inline constexpr std::uint64_t unpack_ratio_max = 65;

/// Appends the packed form of `bytes`; never longer than bytes + bytes / 128 + 1.
void pack(std::span<const std::byte> bytes, std::vector<std::byte>& out);

/// Unpacks all of `packed` to exactly `size` bytes; allocates no more than `packed` can expand to. Errors are
/// sentences without the name of the file: "the 3 packed bytes hold 7 bytes, 12 are announced".
Result<std::vector<std::byte>> unpack(std::span<const std::byte> packed, std::uint64_t size);

/// Returns success if `unpack` would succeed, without its memory.
Status check_packed(std::span<const std::byte> packed, std::uint64_t size);

/// Appends a table of rows of `row_bytes` as planes: every row xor the row before it, then byte 0 of all rows, byte 1
/// ...
void append_planes(std::span<const std::byte> table, std::size_t row_bytes, std::vector<std::byte>& out);

/// The inverse: converts planes to the table, which has the same size.
std::vector<std::byte> read_planes(std::span<const std::byte> planes, std::size_t row_bytes);

} // namespace lockstone::replay
