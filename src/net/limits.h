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
/// The bytes that identify a sender's network: the first 24 bits of IPv4, the first 48 of IPv6.
Bytes network_of(const NetAddress& address);

/// How many entries of one table a source and its network may have.
struct Quota {
    std::uint32_t all, per_source, per_network;
};
/// The entries that a table has now: in all, of a source, of its network.
struct Taken {
    std::uint64_t all = 0, of_source = 0, of_network = 0;
};
/// Counts the entries of a table whose opener, `opener_of(entry)`, is in the source and in the network of `from`.
template <class Table, class OpenerOf>
Taken count_taken(const Table& table, const NetAddress& from, const OpenerOf& opener_of) {
    Taken taken{table.size()};
    for (const auto& entry : table) {
        const NetAddress& opener = opener_of(entry);
        taken.of_source += std::ranges::equal(source_of(opener), source_of(from)) ? 1u : 0u;
        taken.of_network += std::ranges::equal(network_of(opener), network_of(from)) ? 1u : 0u;
    }
    return taken;
}
/// True if the source may have one entry more. The last quarter of a table is kept for sources that have none.
bool has_place(const Taken& taken, const Quota& quota);

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
