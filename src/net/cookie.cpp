#include "net/cookie.h"

#include "base/bytes.h"

#include <algorithm>

namespace lockstone::net {
namespace {

constexpr std::uint64_t epoch_ms = 4096;

std::uint64_t cookie_of(const NetKey& key, const NetAddress& from, std::uint8_t slot, std::uint64_t nonce,
                        std::uint64_t epoch) {
    std::array<std::byte, 35> bytes;
    std::ranges::copy(std::as_bytes(std::span(from.ip)), bytes.begin());
    base::store_little_endian(from.port, bytes.data() + 16);
    bytes[18] = std::byte{slot};
    base::store_little_endian(nonce, bytes.data() + 19);
    base::store_little_endian(epoch, bytes.data() + 27);
    return short_hash(key, bytes);
}

} // namespace

std::uint64_t CookieJar::bake(const NetAddress& from, std::uint8_t slot, std::uint64_t nonce,
                              std::uint64_t now_ms) const {
    return cookie_of(key, from, slot, nonce, now_ms / epoch_ms);
}

bool CookieJar::is_good(std::uint64_t cookie, const NetAddress& from, std::uint8_t slot, std::uint64_t nonce,
                        std::uint64_t now_ms) const {
    const std::uint64_t epoch = now_ms / epoch_ms;
    return cookie == cookie_of(key, from, slot, nonce, epoch) ||
           (epoch > 0 && cookie == cookie_of(key, from, slot, nonce, epoch - 1));
}

} // namespace lockstone::net
