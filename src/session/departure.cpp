// Leaving. When a machine falls silent, those that remain must end its players' inputs at the same tick, though each
// may have received a different number of them. Every machine tells which players it counts as gone and how far it
// has their inputs; from then on it takes their inputs from the other machines only. Once all that remain count a
// player as gone, the greatest of their ends is the cut: nobody has confirmed a tick beyond it, and the machine that
// has the last inputs passes them on. Between two peers the cut is at once where the inputs end.
#include "session/peer_session.h"

#include <algorithm>

namespace lockstone::session {

void PeerSession::drop_silent_peers() {
    for (PeerLink& link : links) {
        if (link.state != PeerLink::State::connected) continue;
        std::uint32_t local = 0;
        for (const InputQueue& queue : queues) local |= is_local(queue.player()) ? 1u << queue.player() : 0u;
        const bool silent = now - link.heard_ms > def.disconnect_ms;
        const bool dropped_us = (link.gone & local) != 0;
        if (silent || dropped_us) drop(link);
    }
    // What one machine has noticed, all act on.
    for (const PeerLink& witness : links) {
        if (witness.state != PeerLink::State::connected) continue;
        for (PeerLink& link : links) {
            if (link.state != PeerLink::State::connected || &link == &witness) continue;
            for (std::uint32_t p = 0; p < def.players.size(); ++p) {
                if (def.players[p] == link.peer && (witness.gone >> p & 1u) != 0 && !is_gone(p)) drop(link);
            }
        }
    }
}

void PeerSession::drop(PeerLink& link) {
    link.state = PeerLink::State::gone;
    for (std::uint32_t p = 0; p < def.players.size(); ++p) {
        if (def.players[p] == link.peer) gone |= 1u << p;
    }
    send(link); // if it can hear us, it need not wait for our silence
}

void PeerSession::settle_departures() {
    for (std::uint32_t p = 0; p < queues.size(); ++p) {
        if (is_gone(p) && !queues[p].disconnected()) settle_departure(p);
    }
}

void PeerSession::settle_departure(std::uint32_t player) {
    std::uint64_t cut = queues[player].next();
    for (const PeerLink& link : links) {
        if (link.state != PeerLink::State::connected) continue;
        if ((link.gone >> player & 1u) == 0) return; // it may still receive inputs that nobody else has
        cut = std::max(cut, link.next_input[player]);
    }
    if (queues[player].next() < cut) return; // the last inputs are on their way
    queues[player].disconnect_at(cut);
    notices.push_back(PlayerDisconnected{player, def.players[player], cut});
}

} // namespace lockstone::session
