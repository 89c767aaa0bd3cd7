// An example: a session over ENet, behind the same Transport interface. ENet has no encryption and no authentication
// (its own words), so use it in trusted networks only. The example shows that a session works over any transport.
//
//   net_enet            two machines on 127.0.0.1 play rollback-arena; exit status 0: all confirmed hashes are equal
#include "net/net_player.h"

#include <enet/enet.h>

#include <cstdio>
#include <deque>

using namespace lockstone;

namespace {

/// One link to one peer. Packets are unsequenced, because a session needs the newest packet, not the missing ones.
class EnetTransport final : public Transport {
  public:
    EnetTransport(PeerId self, std::uint16_t port) : peer_id(1 - self) {
        ENetAddress local{};
        enet_address_set_host(&local, "127.0.0.1");
        local.port = port;
        host = enet_host_create(&local, 1, 1, 0, 0);
    }
    EnetTransport(const EnetTransport&) = delete;
    EnetTransport& operator=(const EnetTransport&) = delete;
    ~EnetTransport() override {
        if (host) enet_host_destroy(host);
    }
    bool is_open() const { return host != nullptr; }
    std::uint16_t port() const { return host->address.port; }
    void connect(std::uint16_t to) {
        ENetAddress there{};
        enet_address_set_host(&there, "127.0.0.1");
        there.port = to;
        enet_host_connect(host, &there, 1, 0);
    }
    void poll() {
        ENetEvent event;
        while (enet_host_service(host, &event, 0) > 0) {
            if (event.type == ENET_EVENT_TYPE_CONNECT) peer = event.peer;
            if (event.type == ENET_EVENT_TYPE_DISCONNECT) peer = nullptr;
            if (event.type != ENET_EVENT_TYPE_RECEIVE) continue;
            const auto bytes = std::as_bytes(std::span(event.packet->data, event.packet->dataLength));
            if (waiting.size() < 256) waiting.emplace_back(bytes.begin(), bytes.end());
            enet_packet_destroy(event.packet);
        }
    }
    void send(PeerId to, std::span<const std::byte> bytes) override {
        if (to != peer_id || !peer) return;
        ENetPacket* packet = enet_packet_create(bytes.data(), bytes.size(), ENET_PACKET_FLAG_UNSEQUENCED);
        if (packet && enet_peer_send(peer, 0, packet) != 0) enet_packet_destroy(packet);
        enet_host_flush(host);
    }
    std::optional<Datagram> receive() override {
        if (waiting.empty()) return {};
        taken = std::move(waiting.front());
        waiting.pop_front();
        return Datagram{peer_id, taken};
    }

  private:
    PeerId peer_id;
    ENetHost* host = nullptr;
    ENetPeer* peer = nullptr;
    std::deque<std::vector<std::byte>> waiting;
    std::vector<std::byte> taken;
};

int play() {
    constexpr std::uint64_t ticks = 300;
    EnetTransport a(0, 0), b(1, 0);
    if (!a.is_open() || !b.is_open())
        return std::fprintf(stderr, "net_enet: cannot listen at 127.0.0.1\n"), 2;
    b.connect(a.port());
    const auto game = make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 2}).value();
    test::NetPlayer one(*game, 0, 2, a), other(*game, 1, 2, b);
    for (std::uint64_t frame = 0;
         frame < 4 * ticks && (one.hashes.size() < ticks || other.hashes.size() < ticks); ++frame) {
        a.poll(), one.frame(frame * 16, ticks);
        b.poll(), other.frame(frame * 16, ticks);
    }
    const bool agree = one.hashes.size() == ticks && one.hashes == other.hashes;
    std::printf("%zu and %zu ticks confirmed, %s\n", one.hashes.size(), other.hashes.size(),
                agree ? "all agree" : "they differ");
    return agree ? 0 : 1;
}

} // namespace

int main() {
    if (enet_initialize() != 0) return 2;
    const int status = play();
    enet_deinitialize();
    return status;
}
