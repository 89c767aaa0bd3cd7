// Stateless proof that a sender receives datagrams at its address. Source: RFC 2522 (Photuris).
#pragma once

#include "net/crypto.h"

namespace lockstone::net {

/// Makes and checks cookies with a secret key. It stores no data of senders.
class CookieJar {
  public:
    CookieJar() : key(random_key()) {}
    /// A cookie for the sender of `nonce` at address `from`, for `slot`. Valid for 4 to 8 seconds.
    std::uint64_t bake(const NetAddress& from, std::uint8_t slot, std::uint64_t nonce,
                       std::uint64_t now_ms) const;
    /// True for a valid cookie of the same sender, slot and nonce.
    bool is_good(std::uint64_t cookie, const NetAddress& from, std::uint8_t slot, std::uint64_t nonce,
                 std::uint64_t now_ms) const;

  private:
    NetKey key;
};

} // namespace lockstone::net
