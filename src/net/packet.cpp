#include "net/packet.h"

#include "base/bytes.h"

#include <algorithm>

namespace lockstone::net {

using base::load_little_endian, base::store_little_endian;

std::optional<NetFault> length_fault(Bytes datagram) {
    if (datagram.empty()) return NetFault::truncated;
    const Lengths lengths = lengths_of(kind_of(datagram[0]));
    if (lengths.most == 0) return NetFault::malformed;
    if (datagram.size() < lengths.least) return NetFault::truncated;
    if (datagram.size() > lengths.most) return NetFault::oversized;
    return {};
}

Hello read_hello(Bytes datagram) {
    return {std::to_integer<std::uint8_t>(datagram[1]), load_little_endian<std::uint32_t>(&datagram[2]),
            load_little_endian<std::uint64_t>(&datagram[6])};
}

void write_hello(Space to, std::byte first, std::uint32_t match, std::uint64_t nonce) {
    std::ranges::fill(to, std::byte{0});
    to[0] = first, to[1] = std::byte{net_version};
    store_little_endian(match, &to[2]);
    store_little_endian(nonce, &to[6]);
}

Cookie read_cookie(Bytes datagram) {
    return {std::to_integer<std::uint8_t>(datagram[1]), load_little_endian<std::uint64_t>(&datagram[2]),
            load_little_endian<std::uint64_t>(&datagram[10])};
}

void write_cookie(Space to, std::byte first, std::uint64_t nonce, std::uint64_t cookie) {
    to[0] = first, to[1] = std::byte{net_version};
    store_little_endian(nonce, &to[2]);
    store_little_endian(cookie, &to[10]);
}

} // namespace lockstone::net
