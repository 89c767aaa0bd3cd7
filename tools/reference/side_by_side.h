// Both engines from the same start: ours plays a game, the thesis' gets the same forces.
//
//   auto both = reference::SideBySide::create(make_compare_scene("two-blocks").value());
//   while (...) { if (!both->tick()) ...; draw(both->ours(), both->theirs()); }
#pragma once

#include "lockstone/input.h"
#include "reference/reference.h"

namespace reference {

/// What both look like after a tick.
struct Sample {
    std::uint64_t tick = 0;
    double separation_max = 0;  ///< the farthest that a dynamic body is from its counterpart [m]
    double separation_mean = 0; ///< of all dynamic bodies [m]
    Measures ours, theirs;
    double our_us = 0, their_us = 0;                   ///< wall time of the tick
    bool ours_touched = false, theirs_touched = false; ///< whether anything touched in the tick
};

class SideBySide {
  public:
    /// Refuses what Engine::create refuses.
    static lockstone::Result<SideBySide> create(std::unique_ptr<lockstone::Game> game,
                                                const Settings& settings = {}, std::uint64_t seed = 1);
    SideBySide(SideBySide&&) noexcept;
    SideBySide& operator=(SideBySide&&) noexcept;
    ~SideBySide();

    /// One tick of both. Players do what lockstone::scripted_input says. Refuses a command that the thesis' engine cannot
    /// follow.
    lockstone::Status tick();
    lockstone::World& ours();
    Engine& theirs();
    const lockstone::Game& game() const;
    Sample sample() const; ///< now; the times are of the last tick

  private:
    struct Impl;
    explicit SideBySide(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl;
};

} // namespace reference
