// Interfaces that are told what happens to a world: for recorders, for profilers, for finding where two runs part.
#pragma once

#include "lockstone/command.h"

#include <cstdint>

namespace lockstone {

/// Sees every command that was applied and every tick, in order. The one recording hook.
class Journal {
  public:
    virtual ~Journal() = default;
    virtual void on_command(std::uint64_t tick,
                            const Command& command) = 0; ///< applied before tick `tick` runs
    virtual void on_tick(std::uint64_t tick,
                         std::uint64_t hash) = 0; ///< tick ran; hash of the state after it
    /// The state was replaced, by whatever means but a tick or a command: the next tick is `tick`.
    virtual void on_restore(std::uint64_t tick) = 0;
};

/// Hash of the whole state after one phase of a tick, for finding where two runs part.
struct PhaseHash {
    const char* phase; ///< the name that PhaseObserver receives
    std::uint64_t hash;
};

/// Is told what a tick has done, for profilers. It is handed no state and hands nothing back: no bit can depend on it.
class PhaseObserver {
  public:
    virtual ~PhaseObserver() = default;
    /// This phase is over; it began at the last call. Where all passes over contacts are one run, and what comes between them, they are told as one
    /// "solve_contacts".
    virtual void on_phase(const char* phase) = 0;
};

} // namespace lockstone
