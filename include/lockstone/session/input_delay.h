// How long to delay the own input, as the way to the other machines changes.
//
//   InputDelayTuner tuner({.tick_rate = 60});
//   each frame: session->set_input_delay(tuner.update({{session->quality(other)}}));
//
// A longer delay costs the own player time, and saves the others rollbacks: an input that is sent d ticks before it counts and
// takes w ticks on its way is guessed for w - d ticks. Machines tune alone and may differ.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

/// Values beyond the ranges count as the nearest.
struct InputDelayDef {
    std::uint32_t tick_rate = 60; ///< of frames, 1..1000 [1/s]
    /// Up to so many ticks may be guessed: what the others run again, and see change, for the own input.
    std::uint32_t rollback_ticks = 4;
    std::uint32_t least = 1, most = 8; ///< [ticks], 0..32; lockstep needs at least 1
};

/// Rises a tick once the delay has been too short for half a second in all, and falls a tick once it has been too long for five
/// seconds: a way that only trembles moves nothing. Each change repeats or drops one input (Session::set_input_delay).
class InputDelayTuner {
  public:
    explicit InputDelayTuner(const InputDelayDef& def);
    /// Once a frame, with all other machines; those that are not connected do not count. The delay to use from now on [ticks].
    std::uint32_t update(std::span<const PeerQuality> peers);
    std::uint32_t delay() const { return now; }

  private:
    /// Half the slowest round trip, rounded up to ticks, less what may be guessed.
    std::uint32_t wanted(std::span<const PeerQuality> peers) const;

    InputDelayDef def;
    std::uint32_t now;
    std::uint32_t too_short = 0, too_long = 0; ///< frames
};

} // namespace lockstone
