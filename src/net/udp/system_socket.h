// System sockets with one interface for BSD sockets and Winsock. No other file distinguishes the two.
#pragma once

#ifdef _WIN32
#ifndef NOMINMAX
#define NOMINMAX
#endif
#define WIN32_LEAN_AND_MEAN
#include <winsock2.h>
#include <ws2tcpip.h>
#else
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#endif

#include <cstdint>
#include <string>
#include <system_error>

namespace lockstone::net::sockets {

#ifdef _WIN32
using Handle = SOCKET;
using Length = int;
constexpr Handle no_handle = INVALID_SOCKET;

/// Initialises Winsock before the first socket of the program; false: no sockets are available.
inline bool is_ready() {
    static const bool ready = [] {
        WSADATA data;
        return WSAStartup(MAKEWORD(2, 2), &data) == 0;
    }();
    return ready;
}
inline int last_error() { return WSAGetLastError(); }
inline bool would_wait() { return last_error() == WSAEWOULDBLOCK; }
inline bool never_wait(Handle socket) {
    u_long on = 1;
    return ioctlsocket(socket, static_cast<long>(FIONBIO), &on) == 0;
}
inline void close(Handle socket) { closesocket(socket); }
inline void wait(Handle socket, std::uint32_t milliseconds) {
    WSAPOLLFD waited{socket, POLLRDNORM, 0};
    WSAPoll(&waited, 1, static_cast<int>(milliseconds));
}
#else
using Handle = int;
using Length = std::size_t;
constexpr Handle no_handle = -1;

inline bool is_ready() { return true; }
inline int last_error() { return errno; }
inline bool would_wait() { return errno == EAGAIN || errno == EWOULDBLOCK; }
inline bool never_wait(Handle socket) { return ::fcntl(socket, F_SETFL, O_NONBLOCK) == 0; }
inline void close(Handle socket) { ::close(socket); }
inline void wait(Handle socket, std::uint32_t milliseconds) {
    pollfd waited{socket, POLLIN, 0};
    ::poll(&waited, 1, static_cast<int>(milliseconds));
}
#endif

inline std::string last_sentence() { return std::system_category().message(last_error()); }

} // namespace lockstone::net::sockets
