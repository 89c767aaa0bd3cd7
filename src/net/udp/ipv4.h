// IPv4 addresses in NetAddress.
#pragma once

#include "lockstone/net.h"

#include <algorithm>
#include <array>
#include <span>

namespace lockstone::net {

/// NetAddress keeps an IPv4 address in its last four bytes, after these bytes: as an IPv4-mapped IPv6 address.
/// source: RFC 4291, 2.5.5.2
inline constexpr std::array<std::uint8_t, 12> ipv4_mapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};

inline bool is_ipv4(const NetAddress& address) {
    return std::ranges::equal(ipv4_mapped, std::span(address.ip).first<12>());
}

} // namespace lockstone::net
