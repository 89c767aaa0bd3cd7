#include "net/limits.h"

#include "net/udp/ipv4.h"

namespace lockstone::net {

Bytes source_of(const NetAddress& address) {
    const bool four = is_ipv4(address);
    return std::as_bytes(std::span(address.ip)).subspan(four ? 12 : 0, four ? 4 : 8);
}

Bytes network_of(const NetAddress& address) {
    const Bytes source = source_of(address);
    return source.first(source.size() == 4 ? 3 : 6);
}

bool has_place(const Taken& taken, const Quota& quota) {
    if (taken.all >= quota.all || taken.of_source >= quota.per_source ||
        taken.of_network >= quota.per_network)
        return false;
    return taken.of_source == 0 || taken.all < quota.all - quota.all / 4;
}

bool SourceLimit::take(const NetAddress& from, std::uint64_t rate, std::uint64_t now_ms) {
    return buckets[short_hash(key, source_of(from)) % buckets.size()].take(1, rate, now_ms);
}

} // namespace lockstone::net
