// One turn of a relay's loop. The command `relay` and a demo that hosts a match use it.
#pragma once

#include "cli/match/clock.h"
#include "lockstone/net.h"

namespace lockstone::cli {

/// Waits up to `wait_ms` for datagrams, then forwards or answers at most 256 of them.
inline void serve_relay(Relay& relay, UdpSocket& socket, std::uint32_t wait_ms) {
    socket.wait(wait_ms);
    const std::uint64_t now_ms = unix_ms();
    for (int i = 0; i < 256; ++i) {
        const auto arrived = socket.receive();
        if (!arrived) break;
        relay.receive(arrived->from, arrived->bytes, now_ms);
        while (const auto out = relay.next_outgoing()) socket.send(out->to, out->bytes);
    }
    relay.poll(now_ms);
}

} // namespace lockstone::cli
