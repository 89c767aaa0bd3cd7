// A relay for spectators: hundreds of machines watch, and a player's machine sends the match once.
//
//   a player's machine:  SpectatorHost host(session_def, transport_to_the_relay);
//                        host.set_states(&runner.inspector());
//   the relay:           const SpectatorRelayDef hosts{.hosts = {0, 1}};
//                        auto relay = make_spectator_relay(session_def, hosts, players, watchers).value();
//                        each frame: relay->poll();
//   a watching machine:  make_spectator_session(session_def, relay_peer, transport), as of any host
//
// Example: `lockstone broadcast`, a relay over UDP for matches of the demo (tools/cli/match/broadcast.cpp).
//
// The relay has no game and no world. It requests confirmed ticks and at intervals a state from one host,
// stores both in bounded memory, and sends them to all spectators. So the traffic of a player does not depend
// on the spectators. If its host sends nothing new for three seconds, the relay continues with the next one.
//
// Spectators compare the hash of each tick with their own. A relay, like any host, can show a consistent
// false match; a second entry of WatchDef::hosts detects it.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

/// Settings of a SpectatorRelay.
struct SpectatorRelayDef {
    /// Machines with a SpectatorHost, 1..16, in order of preference; ids of the transport `to_hosts`.
    std::vector<PeerId> hosts;
    std::uint32_t watchers_max = 1024; ///< limit of spectators; others get no answer
    std::uint64_t silence_polls = 600; ///< a spectator is removed after this silence [polls]
    std::uint32_t delay_ticks = 0;     ///< delay of spectators behind the relay [ticks]
    /// Capacity of the log [ticks], at least 1024. A full log drops its older half; later spectators begin at
    /// a state.
    std::uint32_t log_ticks_max = 72'000;
    /// Interval of state requests [polls], at least 120; 0: never. It limits the ticks that a late spectator
    /// runs.
    std::uint32_t state_polls = 3600;
    std::uint32_t state_bytes_max = 16u << 20; ///< larger states are refused [bytes], 1..64 MiB
};

/// A relay between SpectatorHosts and spectators. One thread at a time.
class SpectatorRelay {
  public:
    virtual ~SpectatorRelay() = default;
    /// Receives from both sides, requests ticks, sends to spectators. Call it 60 times a second.
    virtual void poll() = 0;

    /// Numbers of a relay.
    struct Counters {
        std::uint64_t first_tick = 0,        ///< first tick in the log
            next_tick = 0;                   ///< tick after the last in the log
        std::uint64_t state_tick = 0;        ///< tick of the stored state; 0: none
        std::uint32_t watchers = 0;          ///< spectators at present
        PeerId host = 0;                     ///< the current host
        std::uint64_t host_changes = 0,      ///< changes of the host
            states_refused = 0;              ///< states with a wrong hash or size
        std::uint64_t bytes_to_watchers = 0, ///< bytes sent to spectators
            bytes_to_hosts = 0;              ///< bytes sent to hosts
        std::uint64_t log_bytes = 0;         ///< memory of the log [bytes]
        std::uint64_t packets_dropped = 0;   ///< packets of hosts: unknown sender, damaged, not requested
    };
    virtual Counters counters() const = 0; ///< The present numbers.
};

/// A relay. `def`: as on the players' machines; `self` is ignored. The transports are not owned. Errors: a
/// field out of range.
Result<std::unique_ptr<SpectatorRelay>> make_spectator_relay(const SessionDef& def,
                                                             const SpectatorRelayDef& relay,
                                                             Transport& to_hosts, Transport& to_watchers);

} // namespace lockstone
