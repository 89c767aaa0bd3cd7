// UdpSocket: a non-blocking UDP socket.
#include "lockstone/net.h"

#include "base/text.h"
#include "net/udp/ipv4.h"
#include "net/udp/system_socket.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace lockstone {

namespace sockets = net::sockets;

namespace {

// Buffer of the system in each direction: enough for some frames of a relay under full load.
constexpr int buffer_bytes = 1 << 20;

Error system_error(std::string_view what, const NetAddress& local) {
    return {base::join("cannot ", what, " ", to_string(local), ": ", sockets::last_sentence())};
}

sockaddr_in6 ipv6_of(const NetAddress& address) {
    sockaddr_in6 made{};
    made.sin6_family = AF_INET6;
    made.sin6_port = htons(address.port);
    std::memcpy(&made.sin6_addr, address.ip.data(), address.ip.size());
    return made;
}

sockaddr_in ipv4_of(const NetAddress& address) {
    sockaddr_in made{};
    made.sin_family = AF_INET;
    made.sin_port = htons(address.port);
    std::memcpy(&made.sin_addr, address.ip.data() + 12, 4);
    return made;
}

NetAddress address_of(const sockaddr_storage& from) {
    NetAddress made;
    if (from.ss_family == AF_INET6) {
        sockaddr_in6 in{};
        std::memcpy(&in, &from, sizeof in);
        std::memcpy(made.ip.data(), &in.sin6_addr, made.ip.size());
        made.port = ntohs(in.sin6_port);
    } else {
        sockaddr_in in{};
        std::memcpy(&in, &from, sizeof in);
        made.ip[10] = made.ip[11] = 0xff;
        std::memcpy(made.ip.data() + 12, &in.sin_addr, 4);
        made.port = ntohs(in.sin_port);
    }
    return made;
}

template <class Address> const sockaddr* generic(const Address& address) {
    return reinterpret_cast<const sockaddr*>(&address);
}
template <class Address> sockaddr* generic(Address& address) { return reinterpret_cast<sockaddr*>(&address); }

sockets::Handle handle_of(std::intptr_t kept) { return static_cast<sockets::Handle>(kept); }

void set_option(sockets::Handle socket, int level, int option, int value) {
    ::setsockopt(socket, level, option, reinterpret_cast<const char*>(&value), sizeof value);
}

bool are_zero(std::span<const std::uint8_t> bytes) {
    return std::ranges::all_of(bytes, [](std::uint8_t b) { return b == 0; });
}

/// Maps an IPv4 address for a socket with IPv6; 0.0.0.0 becomes the IPv6 address for all interfaces.
NetAddress as_ipv6(NetAddress address) {
    if (net::is_ipv4(address) && are_zero(std::span(address.ip).last<4>())) address.ip = {};
    return address;
}

} // namespace

UdpSocket::UdpSocket(std::intptr_t made)
    : handle(made), buffer(std::make_unique<std::array<std::byte, 2048>>()) {}

Result<UdpSocket> UdpSocket::open(const NetAddress& local) {
    if (!sockets::is_ready()) return system_error("have sockets for", local);
    sockets::Handle made = ::socket(AF_INET6, SOCK_DGRAM, 0);
    const bool ipv6 = made != sockets::no_handle;
    if (!ipv6) made = ::socket(AF_INET, SOCK_DGRAM, 0);
    if (made == sockets::no_handle) return system_error("make a socket for", local);
    UdpSocket opened(static_cast<std::intptr_t>(made));
    opened.is_ipv6 = ipv6;
    if (!ipv6 && !net::is_ipv4(local) && !are_zero(local.ip))
        return Error{base::join("cannot listen at ", to_string(local), ": this machine has no IPv6")};
    if (ipv6) set_option(made, IPPROTO_IPV6, IPV6_V6ONLY, 0);
    set_option(made, SOL_SOCKET, SO_RCVBUF, buffer_bytes);
    set_option(made, SOL_SOCKET, SO_SNDBUF, buffer_bytes);
    const sockaddr_in6 six = ipv6_of(as_ipv6(local));
    const sockaddr_in four = ipv4_of(local);
    const int bound =
        ipv6 ? ::bind(made, generic(six), sizeof six) : ::bind(made, generic(four), sizeof four);
    if (bound != 0) return system_error("listen at", local);
    if (!sockets::never_wait(made)) return system_error("read without waiting at", local);
    return opened;
}

UdpSocket::UdpSocket(UdpSocket&& other) noexcept
    : handle(std::exchange(other.handle, -1)), is_ipv6(other.is_ipv6), buffer(std::move(other.buffer)) {}

UdpSocket& UdpSocket::operator=(UdpSocket&& other) noexcept {
    std::swap(handle, other.handle), std::swap(is_ipv6, other.is_ipv6), std::swap(buffer, other.buffer);
    return *this;
}

UdpSocket::~UdpSocket() {
    if (handle >= 0) sockets::close(handle_of(handle));
}

NetAddress UdpSocket::local_address() const {
    sockaddr_storage own{};
    socklen_t size = sizeof own;
    if (::getsockname(handle_of(handle), generic(own), &size) != 0) return {};
    return address_of(own);
}

void UdpSocket::send(const NetAddress& to, std::span<const std::byte> bytes) {
    const sockaddr_in6 six = ipv6_of(to);
    const sockaddr_in four = ipv4_of(to);
    const auto data = reinterpret_cast<const char*>(bytes.data());
    const auto size = static_cast<sockets::Length>(bytes.size());
    // A datagram that the system does not accept now is lost, as on any network; so is one to an IPv6 address on a
    // machine without IPv6.
    if (!is_ipv6 && !net::is_ipv4(to)) return;
    [[maybe_unused]] const auto sent =
        is_ipv6 ? ::sendto(handle_of(handle), data, size, 0, generic(six), sizeof six)
                : ::sendto(handle_of(handle), data, size, 0, generic(four), sizeof four);
}

std::optional<UdpSocket::Arrived> UdpSocket::receive() {
    // recvfrom() also reports errors of earlier sends (such as a closed port); they do not end the loop.
    for (int tries = 0; tries < 16; ++tries) {
        sockaddr_storage from{};
        socklen_t size = sizeof from;
        const auto got = ::recvfrom(handle_of(handle), reinterpret_cast<char*>(buffer->data()),
                                    static_cast<sockets::Length>(buffer->size()), 0, generic(from), &size);
        if (got >= 0) return Arrived{address_of(from), {buffer->data(), static_cast<std::size_t>(got)}};
        if (sockets::would_wait()) return {};
    }
    return {};
}

void UdpSocket::wait(std::uint32_t milliseconds) { sockets::wait(handle_of(handle), milliseconds); }

} // namespace lockstone
