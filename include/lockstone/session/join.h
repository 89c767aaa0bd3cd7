// Coming late, or back: a machine without any state takes its own seat in a match that goes on.
//
//   auto session = make_join_session(session_def, {.life = starts_so_far}, transport).value();
//   WorldSimulation simulation(world, game);                 // any state: it is replaced
//   SessionRunner runner(*session, simulation);
//   each frame: as in any match; until the notice PlayerJoined tells of this machine's players, inputs are not taken
//
// A peer sends the state at a confirmed tick in chunks, then what was confirmed since, and the machine runs after it; all others are
// asked whether it is their match too. When it is level it asks for its seat, all who play agree on a tick, and from that tick on
// its inputs count. It comes in where its players have left (Session::drop_peer, silence), or were SessionDef::absent; a machine
// that asks while the others still wait for what it was before is dropped first, at once. Whoever else goes meanwhile, those who stay let it in;
// where it loses all of them before a tick was confirmed with them it stops (MatchStopped), and may come again with a greater life. So it
// does where no machine has the ticks any more that it needs next: it was too long on its way.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

struct JoinDef {
    /// 1..16,777,215, greater each time that this machine joins this match: the others ignore packets of an older life. A life requests the seat
    /// with 256 tickets, one in two seconds at first and fewer later, for 4.5 hours. A machine that is not admitted by then has to join with a
    /// greater life.
    std::uint32_t life = 1;
    std::uint32_t ticks_per_frame = 4; ///< 1..64: that are run at most while it is behind
    std::uint32_t state_bytes_max =
        16u << 20;         ///< of the state, at most 64 MiB; a larger one is refused (StateRefused)
    bool lockstep = false; ///< as the others do
};

/// `def` as the others have it, with this machine as self. Errors name the field that is out of range.
Result<std::unique_ptr<Session>> make_join_session(const SessionDef& def, const JoinDef& join,
                                                   Transport& transport);

} // namespace lockstone
