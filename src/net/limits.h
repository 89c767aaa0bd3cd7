// Rate limits: token buckets, one for each of many sources, in memory of fixed size.
#pragma once

#include "net/crypto.h"

#include <algorithm>

namespace lockstone::net {

/// A token bucket with a capacity of `rate` that gains `rate` in a second.
class Bucket {
  public:
    /// Takes `amount` from the bucket; false: it holds less, and nothing changes.
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
    std::uint64_t level = 0; ///< content [1/1000]
    std::uint64_t filled_ms = 0;
    bool is_new = true;
};

/// The bytes that identify a sender: the address without its port, of IPv6 the first 64 bits, because a
/// sender controls all addresses with these bits.
Bytes source_of(const NetAddress& address);
/// The bytes that identify a sender's network: the first 24 bits of IPv4, the first 48 of IPv6.
Bytes network_of(const NetAddress& address);

/// Limits of a table: entries in all, of a source, and of a network.
struct Quota {
    std::uint32_t all, per_source, per_network;
};
/// Present entries of a table: in all, of a source, of its network.
struct Taken {
    std::uint64_t all = 0, of_source = 0, of_network = 0;
};
/// Counts the entries of a table. An entry belongs to a source or network if `opener_of(entry)` does.
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
/// True if the source may add an entry. The last quarter of a table is reserved for sources without an
/// entry.
bool has_place(const Taken& taken, const Quota& quota);

/// Token buckets for many sources, selected by a secret hash. Sources in one bucket share its rate; the
/// secret prevents that a sender chooses another one's bucket.
class SourceLimit {
  public:
    SourceLimit() : buckets(1024), key(random_key()) {}
    bool take(const NetAddress& from, std::uint64_t rate, std::uint64_t now_ms);

  private:
    std::vector<Bucket> buckets;
    NetKey key;
};

} // namespace lockstone::net
