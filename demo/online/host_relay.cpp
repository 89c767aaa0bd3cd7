#include "online/host_relay.h"

#include "cli/match/serve_relay.h"
#include "online/gallery.h"

namespace lockstone::demo {

HostRelay::HostRelay(UdpSocket opened)
    : socket_(std::move(opened)), port_(socket_.local_address().port), thread_([this] { serve(); }) {}

Result<std::unique_ptr<HostRelay>> HostRelay::start(std::uint16_t port) {
    Result<UdpSocket> socket = UdpSocket::open({.ip = {}, .port = port});
    if (!socket) return socket.error();
    return std::unique_ptr<HostRelay>(new HostRelay(std::move(*socket)));
}

HostRelay::~HostRelay() {
    over_ = true;
    thread_.join();
}

Invitation HostRelay::invitation() const {
    Invitation made;
    made.relay = parse_address("127.0.0.1:" + std::to_string(port_)).value();
    made.key = public_key_of(secret_);
    return made;
}

void HostRelay::serve() {
    // One room for the match, and one for each watcher of each machine.
    Relay relay(secret_, {.matches_max = 1 + net_players_max * Gallery::watchers_max}, cli::unix_ms());
    while (!over_) cli::serve_relay(relay, socket_, 50);
}

} // namespace lockstone::demo
