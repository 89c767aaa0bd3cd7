// A relay of what is watched: hundreds of machines watch, and a player's machine sends the match once.
//
//   a player's machine:  SpectatorHost host(session_def, transport_to_the_relay);  host.set_states(&runner.inspector());
//   the relay:           auto relay = make_spectator_relay(session_def, {.hosts = {0, 1}}, to_players, to_watchers).value();
//                        each frame: relay->poll();
//   a watching machine:  make_spectator_session(session_def, relay_peer, transport), as of any host
//
// `lockstone broadcast` is such a relay over UDP, for matches of the demo; tools/cli/match/broadcast.cpp is how one is made.
//
// The relay has neither game nor world. It asks one host for confirmed ticks and, now and then, for a state, as one watcher does, keeps
// both in bounded memory and serves every watcher from there. So what a player sends does not depend on who watches. When its host says
// nothing new for three seconds, it asks the next one from where that ended: the match is watched on when a machine has left.
//
// Watchers compare each tick's hash with their own, as always. A relay that lies consistently can show them another match, as any
// host can; WatchDef::hosts may name a second one that is asked.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

struct SpectatorRelayDef {
    /// On the transport to them: machines that show the match (SpectatorHost), 1..16; asked in this order
    std::vector<PeerId> hosts;
    std::uint32_t watchers_max = 1024; ///< more are not answered
    std::uint64_t silence_polls = 600; ///< of a watcher: then its place is free again
    std::uint32_t delay_ticks = 0;     ///< that watchers see later than the relay
    std::uint32_t log_ticks_max =
        72'000; ///< at least 1024; then the older half is forgotten: who comes later begins with a state
    /// A state is asked for so often, whoever watches; those who come late run at most so many ticks. 0: never. At least 120.
    std::uint32_t state_polls = 3600;
    std::uint32_t state_bytes_max = 16u << 20; ///< of a state, at most 64 MiB; a larger one is not taken
};

class SpectatorRelay {
  public:
    virtual ~SpectatorRelay() = default;
    /// Receives from both sides, asks the host, serves the watchers; call 60 times a second.
    virtual void poll() = 0;

    struct Counters {
        std::uint64_t first_tick = 0, next_tick = 0; ///< ticks [first, next) are kept
        std::uint64_t state_tick = 0;                ///< of the state that is given to who comes; 0: none
        std::uint32_t watchers = 0;
        PeerId host = 0; ///< that is asked
        std::uint64_t host_changes = 0, states_refused = 0;
        std::uint64_t bytes_to_watchers = 0, bytes_to_hosts = 0;
        std::uint64_t log_bytes = 0;       ///< at most log_ticks_max ticks
        std::uint64_t packets_dropped = 0; ///< from hosts: strangers', damaged, or not what was asked for
    };
    virtual Counters counters() const = 0;
};

/// `def` as the players have it; `self` is read by nobody. Not owned: the transports. Errors name the field that is out of range.
Result<std::unique_ptr<SpectatorRelay>> make_spectator_relay(const SessionDef& def,
                                                             const SpectatorRelayDef& relay,
                                                             Transport& to_hosts, Transport& to_watchers);

} // namespace lockstone
