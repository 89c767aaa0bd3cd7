// Joining a running match: a machine without a state takes the place of its players, late or after a
// disconnect.
//
//   auto session = make_join_session(session_def, {.life = starts_so_far}, transport).value();
//   WorldSimulation simulation(world, game);                 // any state of the game
//   SessionRunner runner(*session, simulation);
//   each frame: as in any match; inputs are ignored until the notice PlayerJoined of this machine's players
//
// A peer sends the state of a confirmed tick in chunks, then the confirmed ticks since; the machine runs them
// and checks with the other machines that they have the same match. When it has caught up it requests its
// seat, the machines in the match agree on a tick, and its inputs count from that tick on. Its players must
// have left (Session::drop_peer(), timeout) or have been SessionDef::absent; if the others still wait for an
// earlier life of the machine, they drop that first. Departures of other machines do not stop a join. The
// session stops (MatchStopped) if it loses all other machines before the first common confirmed tick, or if
// no machine has its next ticks any more. The machine may then join again with a greater life.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

/// Settings of a join session.
struct JoinDef {
    /// Number of this join, 1..16,777,215: greater each time that this machine joins this match. The others
    /// ignore packets of an older life. A life requests the seat for 4.5 hours (256 requests, at first one in
    /// two seconds); after that the machine must join with a greater life.
    std::uint32_t life = 1;
    std::uint32_t ticks_per_frame = 4;         ///< maximum ticks in a frame during catch-up, 1..64
    std::uint32_t state_bytes_max = 16u << 20; ///< larger states are refused [bytes], 1..64 MiB
    bool lockstep = false;                     ///< true: the match is a lockstep match
};

/// A session that joins a running match. `def`: as on the other machines, with this machine as self. The
/// transport is not owned. Errors: a field out of range, or no player on another machine.
Result<std::unique_ptr<Session>> make_join_session(const SessionDef& def, const JoinDef& join,
                                                   Transport& transport);

} // namespace lockstone
