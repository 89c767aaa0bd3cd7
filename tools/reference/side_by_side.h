// Runs both engines from the same start: Lockstone plays a game, and the thesis' engine gets the same forces.
//
//   auto both = reference::SideBySide::create(make_compare_scene("two-blocks").value());
//   while (...) { if (!both->tick()) ...; draw(both->ours(), both->theirs()); }
#pragma once

#include "lockstone/input.h"
#include "reference/reference.h"

namespace reference {

/// The measures of both engines after a tick.
struct Sample {
    std::uint64_t tick = 0;
    double separation_max = 0;  ///< the largest distance of a dynamic body from its counterpart [m]
    double separation_mean = 0; ///< mean over all dynamic bodies [m]
    Measures ours, theirs;
    double our_us = 0, their_us = 0;                   ///< wall time of the tick
    bool ours_touched = false, theirs_touched = false; ///< true if there were contacts in the tick
};

class SideBySide {
  public:
    /// Errors: those of Engine::create.
    static lockstone::Result<SideBySide> create(std::unique_ptr<lockstone::Game> game,
                                                const Settings& settings = {}, std::uint64_t seed = 1);
    SideBySide(SideBySide&&) noexcept;
    SideBySide& operator=(SideBySide&&) noexcept;
    ~SideBySide();

    /// Runs one tick of both. Players' inputs are those of lockstone::scripted_input. An error if the thesis' engine
    /// cannot apply a command.
    lockstone::Status tick();
    lockstone::World& ours();
    Engine& theirs();
    const lockstone::Game& game() const;
    Sample sample() const; ///< of the current state; the times are those of the last tick

  private:
    struct Impl;
    explicit SideBySide(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl;
};

} // namespace reference
