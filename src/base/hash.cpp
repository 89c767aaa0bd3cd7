#include "base/hash.h"

#include "base/bytes.h"

// Header-only use: there is no library to link, so the core cross-compiles on every system that has the header.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <new>

namespace lockstone::base {

static_assert(sizeof(XXH3_state_t) <= sizeof(HashStream) && alignof(XXH3_state_t) <= alignof(HashStream));

namespace {
XXH3_state_t* state_in(std::byte* storage) { return std::launder(reinterpret_cast<XXH3_state_t*>(storage)); }
const XXH3_state_t* state_in(const std::byte* storage) {
    return std::launder(reinterpret_cast<const XXH3_state_t*>(storage));
}
} // namespace

std::uint64_t xxh3(std::span<const std::byte> bytes, std::uint64_t seed) {
    static constexpr std::byte nothing{};
    return XXH3_64bits_withSeed(bytes.empty() ? &nothing : bytes.data(), bytes.size(), seed);
}

std::uint64_t xxh3(std::string_view text, std::uint64_t seed) {
    return xxh3(std::as_bytes(std::span(text.data(), text.size())), seed);
}

// The reset fills `storage`; zeroing all of it first would cost more than hashing a small column.
HashStream::HashStream(std::uint64_t seed) {
    XXH3_state_t* state = new (storage) XXH3_state_t;
    XXH3_INITSTATE(state);
    XXH3_64bits_reset_withSeed(state, seed);
}

void HashStream::add(std::span<const std::byte> bytes) {
    if (!bytes.empty()) XXH3_64bits_update(state_in(storage), bytes.data(), bytes.size());
}

void HashStream::add(std::uint32_t value) {
    std::byte bytes[4];
    store_little_endian(value, bytes);
    add(std::span<const std::byte>(bytes));
}

void HashStream::add(std::uint64_t value) {
    std::byte bytes[8];
    store_little_endian(value, bytes);
    add(std::span<const std::byte>(bytes));
}

std::uint64_t HashStream::digest() const { return XXH3_64bits_digest(state_in(storage)); }

} // namespace lockstone::base
