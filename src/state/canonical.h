// Converts many rows to canonical bytes at once. The byte order of the host is a parameter, so that a test on any
// machine can run the code for the other order; callers pass std::endian::native.
#pragma once

#include "base/hash.h"
#include "lockstone/state.h"

#include <bit>

namespace lockstone {

static_assert(std::endian::native == std::endian::little || std::endian::native == std::endian::big);

/// Copies whole rows and converts each leaf between `order` and little-endian. The function is its own inverse. Sizes
/// are equal.
void copy_canonical(std::endian order, std::span<const LeafInfo> leaves, std::span<const std::byte> rows,
                    std::span<std::byte> to);

/// XXH3 of the canonical bytes of whole rows, without allocating.
std::uint64_t hash_canonical(std::endian order, std::span<const LeafInfo> leaves,
                             std::span<const std::byte> rows);

} // namespace lockstone
