// Adaptive input delay: follows the latency to the other machines.
//
//   InputDelayTuner tuner({.tick_rate = 60});
//   each frame: session->set_input_delay(tuner.update({{session->quality(other)}}));
//
// A longer delay costs this player response time and saves the others rollbacks: with a delay of d ticks and
// a latency of w ticks the others predict w - d ticks. Each machine tunes its own delay.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

/// Settings of an InputDelayTuner. Values out of range are clamped.
struct InputDelayDef {
    std::uint32_t tick_rate = 60;     ///< frames for each second [1/s], 1..1000
    std::uint32_t rollback_ticks = 4; ///< ticks that the others may predict
    std::uint32_t least = 1,          ///< minimum delay [ticks], 0..most; lockstep: at least 1
        most = 8;                     ///< maximum delay [ticks], 0..32
};

/// Computes the input delay. It rises by a tick after it was too short for half a second in total, and falls
/// by a tick after it was too long for five seconds without a break, so jitter has no effect. Each change
/// repeats or drops an input (Session::set_input_delay()).
class InputDelayTuner {
  public:
    explicit InputDelayTuner(const InputDelayDef& def); ///< Starts with the minimum delay.
    /// Returns the delay to use [ticks]. Call it in each frame with all other machines; those without a
    /// connection are ignored.
    std::uint32_t update(std::span<const PeerQuality> peers);
    std::uint32_t delay() const { return now; } ///< The present delay [ticks].

  private:
    /// Half the slowest round trip, rounded up to ticks, minus rollback_ticks; clamped to least..most.
    std::uint32_t wanted(std::span<const PeerQuality> peers) const;

    InputDelayDef def;
    std::uint32_t now;
    std::uint32_t too_short = 0, too_long = 0; ///< frames
};

} // namespace lockstone
