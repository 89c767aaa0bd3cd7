// Canonical bytes of many rows at once. The byte order of the host is a parameter, so that a test on any machine
// runs the path of the other kind; callers pass std::endian::native.
#pragma once

#include "base/hash.h"
#include "lockstone/state.h"

#include <bit>

namespace lockstone {

static_assert(std::endian::native == std::endian::little || std::endian::native == std::endian::big);

/// Copies whole rows, turning each leaf between `order` and little-endian; its own inverse. Sizes are equal.
void copy_canonical(std::endian order, std::span<const LeafInfo> leaves, std::span<const std::byte> rows,
                    std::span<std::byte> to);

/// XXH3 of the canonical bytes of whole rows, without allocating.
std::uint64_t hash_canonical(std::endian order, std::span<const LeafInfo> leaves,
                             std::span<const std::byte> rows);

} // namespace lockstone
