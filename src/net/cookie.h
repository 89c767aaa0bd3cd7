// Proof that a sender receives what is sent to its address, without remembering anything of it. Source: RFC 2522 (Photuris).
#pragma once

#include "net/crypto.h"

namespace lockstone::net {

class CookieJar {
  public:
    CookieJar() : key(random_key()) {}
    /// For who sent `nonce` from `from`, in the name of `slot`. Good for 4 to 8 seconds.
    std::uint64_t bake(const NetAddress& from, std::uint8_t slot, std::uint64_t nonce,
                       std::uint64_t now_ms) const;
    bool is_good(std::uint64_t cookie, const NetAddress& from, std::uint8_t slot, std::uint64_t nonce,
                 std::uint64_t now_ms) const;

  private:
    NetKey key;
};

} // namespace lockstone::net
