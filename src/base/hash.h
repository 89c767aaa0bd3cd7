// XXH3-64, the one hash of the library. hash.cpp is the only file that includes xxhash.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace lockstone::base {

std::uint64_t xxh3(std::span<const std::byte> bytes, std::uint64_t seed = 0);
std::uint64_t xxh3(std::string_view text, std::uint64_t seed = 0);

/// Hashes bytes that arrive in pieces: the digest equals xxh3 of their concatenation. Lives on the stack and never
/// allocates. Integers are hashed as little-endian bytes.
class HashStream {
  public:
    HashStream() : HashStream(0) {}
    explicit HashStream(std::uint64_t seed);

    void add(std::span<const std::byte> bytes);
    void add(std::uint32_t value);
    void add(std::uint64_t value);
    std::uint64_t digest() const;

  private:
    alignas(64) std::byte storage[640]; ///< an XXH3_state_t; hash.cpp checks its size
};

} // namespace lockstone::base
