// How much in a time: token buckets, one for each of many sources in memory that does not grow.
#pragma once

#include "net/crypto.h"

#include <algorithm>

namespace lockstone::net {

/// Holds `rate` at most and gains `rate` a second.
class Bucket {
  public:
    bool take(std::uint64_t amount, std::uint64_t rate, std::uint64_t now_ms) {
        const std::uint64_t passed = std::min<std::uint64_t>(now_ms - std::min(now_ms, filled_ms), 1000);
        level = is_new ? rate * 1000 : std::min(rate * 1000, level + passed * rate);
        is_new = false;
        filled_ms = std::max(filled_ms, now_ms);
        if (level < amount * 1000) return false;
        level -= amount * 1000;
        return true;
    }

  private:
    std::uint64_t level = 0; ///< [1/1000]
    std::uint64_t filled_ms = 0;
    bool is_new = true;
};

/// The bytes that identify a sender: the address without its port; of IPv6 the first 64 bits, since a sender owns all addresses that begin with them.
Bytes source_of(const NetAddress& address);

/// A bucket for each source, found by a secret hash: sources that share one share its rate, and nobody can choose with whom.
class SourceLimit {
  public:
    SourceLimit() : buckets(1024), key(random_key()) {}
    bool take(const NetAddress& from, std::uint64_t rate, std::uint64_t now_ms);

  private:
    std::vector<Bucket> buckets;
    NetKey key;
};

} // namespace lockstone::net
