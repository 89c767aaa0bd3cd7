#include "lockstone/net.h"

namespace lockstone {

UdpTransport::UdpTransport(Endpoint made, UdpSocket opened, std::uint64_t now_ms)
    : peer(std::move(made)), wire(std::move(opened)), now(now_ms) {}

Result<UdpTransport> UdpTransport::open(const ConnectToken& token, const EndpointDef& def,
                                        const NetAddress& local, std::uint64_t now_ms) {
    Result<Endpoint> endpoint = Endpoint::create(token, def, now_ms);
    if (!endpoint) return endpoint.error();
    Result<UdpSocket> socket = UdpSocket::open(local);
    if (!socket) return socket.error();
    return UdpTransport(std::move(*endpoint), std::move(*socket), now_ms);
}

void UdpTransport::poll(std::uint64_t now_ms) {
    now = now_ms;
    for (std::uint32_t i = 0; i < datagrams_per_poll; ++i) {
        const auto arrived = wire.receive();
        if (!arrived) break;
        peer.receive(arrived->from, arrived->bytes, now);
        flush();
    }
    peer.poll(now);
    flush();
}

void UdpTransport::flush() {
    while (const auto datagram = peer.next_outgoing()) wire.send(datagram->to, datagram->bytes);
}

void UdpTransport::send(PeerId to, std::span<const std::byte> bytes) {
    peer.send(to, bytes, now);
    flush();
}

std::optional<Datagram> UdpTransport::receive() { return peer.next_packet(); }

// ---- a door --------------------------------------------------------------------------------------------------------

UdpWatchDoor::UdpWatchDoor(WatchDoor made, UdpSocket opened, std::uint64_t now_ms)
    : watchers(std::move(made)), wire(std::move(opened)), now(now_ms) {}

Result<UdpWatchDoor> UdpWatchDoor::open(const WatchDoorDef& def, const NetAddress& local,
                                        std::uint64_t now_ms) {
    Result<UdpSocket> socket = UdpSocket::open(local);
    if (!socket) return socket.error();
    WatchDoorDef at = def;
    if (at.address.port == 0) at.address = socket->local_address();
    Result<WatchDoor> door = WatchDoor::create(at, now_ms);
    if (!door) return door.error();
    return UdpWatchDoor(std::move(*door), std::move(*socket), now_ms);
}

void UdpWatchDoor::poll(std::uint64_t now_ms) {
    now = now_ms;
    for (std::uint32_t i = 0; i < datagrams_per_poll; ++i) {
        const auto arrived = wire.receive();
        if (!arrived) break;
        watchers.receive(arrived->from, arrived->bytes, now);
        flush();
    }
    watchers.poll(now);
    flush();
}

void UdpWatchDoor::flush() {
    while (const auto datagram = watchers.next_outgoing()) wire.send(datagram->to, datagram->bytes);
}

void UdpWatchDoor::send(PeerId to, std::span<const std::byte> bytes) {
    watchers.send(to, bytes, now);
    flush();
}

std::optional<Datagram> UdpWatchDoor::receive() { return watchers.next_packet(); }

} // namespace lockstone
