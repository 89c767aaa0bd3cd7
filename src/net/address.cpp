// Conversion of addresses from and to text.
#include "lockstone/net.h"

#include "base/text.h"
#include "net/udp/ipv4.h"
#include "net/udp/system_socket.h"

#include <algorithm>
#include <charconv>
#include <cstring>

namespace lockstone {
namespace {

Error not_an_address(std::string_view text) {
    return {base::join("'", text, "' is no address; write 192.0.2.7:7777 or [2001:db8::7]:7777")};
}

} // namespace

Result<NetAddress> parse_address(std::string_view text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string_view::npos) return not_an_address(text);
    std::string host(text.substr(0, colon));
    const std::string_view port = text.substr(colon + 1);
    NetAddress made;
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), made.port);
    if (error != std::errc() || end != port.data() + port.size()) return not_an_address(text);
    if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
        host = host.substr(1, host.size() - 2);
        if (inet_pton(AF_INET6, host.c_str(), made.ip.data()) != 1) return not_an_address(text);
        return made;
    }
    std::ranges::copy(net::ipv4_mapped, made.ip.begin());
    if (inet_pton(AF_INET, host.c_str(), made.ip.data() + 12) != 1) return not_an_address(text);
    return made;
}

std::string to_string(const NetAddress& address) {
    std::array<char, INET6_ADDRSTRLEN> text{};
    if (net::is_ipv4(address)) {
        inet_ntop(AF_INET, address.ip.data() + 12, text.data(), text.size());
        return base::join(text.data(), ":", address.port);
    }
    inet_ntop(AF_INET6, address.ip.data(), text.data(), text.size());
    return base::join("[", text.data(), "]:", address.port);
}

} // namespace lockstone
