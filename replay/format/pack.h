// Packed bytes and planes, as FORMAT.md specifies them: simple, exact, and quick enough to be left on.
#pragma once

#include "lockstone/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace lockstone::replay {

/// The most that one packed byte can stand for: two bytes become at most 130.
inline constexpr std::uint64_t unpack_ratio_max = 65;

/// Appends the packed form of `bytes`; never longer than bytes + bytes / 128 + 1.
void pack(std::span<const std::byte> bytes, std::vector<std::byte>& out);

/// Exactly `size` bytes out of all of `packed`; allocates no more than packed can stand for. Errors are a clause
/// without a subject: "the packed bytes hold 7 bytes, 12 are announced".
Result<std::vector<std::byte>> unpack(std::span<const std::byte> packed, std::uint64_t size);

/// Whether `unpack` would succeed, without the memory that it takes.
Status check_packed(std::span<const std::byte> packed, std::uint64_t size);

/// Appends a table of rows of `row_bytes` as planes: every row xor the one before, then byte 0 of all rows, byte 1 ...
void append_planes(std::span<const std::byte> table, std::size_t row_bytes, std::vector<std::byte>& out);

/// The reverse: planes back to the table, of the same size.
std::vector<std::byte> read_planes(std::span<const std::byte> planes, std::size_t row_bytes);

} // namespace lockstone::replay
