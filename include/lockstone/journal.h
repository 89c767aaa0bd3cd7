// Observers of a world: for recorders, for profilers, and to find the first difference of two runs.
#pragma once

#include "lockstone/command.h"

#include <cstdint>

namespace lockstone {

/// Receives every applied command and every tick, in order: World::set_journal().
class Journal {
  public:
    virtual ~Journal() = default;
    /// A command was applied before tick `tick`. The command is valid during the call.
    virtual void on_command(std::uint64_t tick, const Command& command) = 0;
    /// Tick `tick` has run; `hash` is that of the state after it.
    virtual void on_tick(std::uint64_t tick, std::uint64_t hash) = 0;
    /// A restore has replaced the state; the next tick is `tick`.
    virtual void on_restore(std::uint64_t tick) = 0;
};

/// Hash of the whole state after a phase of a tick.
struct PhaseHash {
    const char* phase;  ///< name of the phase, as for PhaseObserver. Static string
    std::uint64_t hash; ///< of the state
};

/// Receives the end of each phase of a tick, for profilers: World::observe_phases(). It has no access to the
/// state.
class PhaseObserver {
  public:
    virtual ~PhaseObserver() = default;
    /// A phase has ended; it began at the last call. `phase`: static string. If a tick solves all substeps of
    /// its contacts in one run, they are one phase "solve_contacts".
    virtual void on_phase(const char* phase) = 0;
};

} // namespace lockstone
