// UdpTransport and UdpWatchDoor: an endpoint or a door together with a UDP socket.
#include "net/packet.h"

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

// ---- a door for spectators -----------------------------------------------------------------------------------------

UdpWatchDoor::UdpWatchDoor(WatchDoor made, UdpSocket opened, std::uint64_t now_ms)
    : watchers(std::make_unique<WatchDoor>(std::move(made))), wire(std::move(opened)), now(now_ms) {}

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

const std::string& UdpWatchDoor::open_lobby(const NetKey& secret, std::uint64_t now_ms) {
    // This lobby only gives places at the door: it has no seats for players and no rooms. The higher rate
    // is for many spectators who share one address and connect within seconds.
    lobby = std::make_unique<Relay>(
        secret, RelayDef{.matches_max = 0, .hellos_per_source = 64, .rooms_max = 0}, now_ms);
    return lobby->show(*watchers);
}

void UdpWatchDoor::poll(std::uint64_t now_ms) {
    now = now_ms;
    const auto is_for_lobby = [&](std::span<const std::byte> datagram) {
        const auto kind = datagram.empty() ? net::Kind::hello : net::kind_of(datagram[0]);
        return lobby != nullptr && (kind == net::Kind::relay_hello || kind == net::Kind::lobby_request);
    };
    for (std::uint32_t i = 0; i < datagrams_per_poll; ++i) {
        const auto arrived = wire.receive();
        if (!arrived) break;
        if (is_for_lobby(arrived->bytes))
            lobby->receive(arrived->from, arrived->bytes, now);
        else
            watchers->receive(arrived->from, arrived->bytes, now);
        flush();
    }
    watchers->poll(now);
    if (lobby) lobby->poll(now);
    flush();
}

void UdpWatchDoor::flush() {
    while (const auto datagram = watchers->next_outgoing()) wire.send(datagram->to, datagram->bytes);
    while (const auto datagram = lobby ? lobby->next_outgoing() : std::nullopt)
        wire.send(datagram->to, datagram->bytes);
}

void UdpWatchDoor::send(PeerId to, std::span<const std::byte> bytes) {
    watchers->send(to, bytes, now);
    flush();
}

std::optional<Datagram> UdpWatchDoor::receive() { return watchers->next_packet(); }

} // namespace lockstone
