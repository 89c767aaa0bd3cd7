#pragma once
/// Converts the time of pictures to whole ticks.

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lockstone::demo {

/// A fixed-step accumulator. It adds real time, returns whole ticks, and keeps the rest, which is the position of the
/// picture between two ticks. Speed changes the added time, never the length of a tick.
class StepClock {
  public:
    /// Maximum per picture: a slow machine shows slow motion, not a frozen window.
    static constexpr int steps_max = 8;

    /// The number of ticks to run now. `tick_rate` [1/s].
    int advance(float seconds, std::uint32_t tick_rate) {
        if (paused_) {
            const int steps = single_steps_;
            single_steps_ = 0;
            if (steps != 0) rest_ = 1;
            return steps;
        }
        rest_ += seconds * speed() * static_cast<float>(tick_rate);
        const float whole = std::floor(rest_);
        rest_ -= whole;
        return static_cast<int>(std::min(whole, static_cast<float>(steps_max)));
    }

    /// 0 the state before the last tick, 1 the state after it.
    float alpha() const { return rest_; }

    bool paused() const { return paused_; }
    void set_paused(bool paused) { paused_ = paused; }
    /// Pauses, and runs one more tick.
    void single_step() { paused_ = true, ++single_steps_; }

    float speed() const { return std::ldexp(1.0f, speed_exponent_); }
    /// A clock at this position that is neither paused nor slowed.
    StepClock at_full_speed() const {
        StepClock clock;
        clock.rest_ = rest_;
        return clock;
    }
    void slower() { speed_exponent_ = std::max(speed_exponent_ - 1, -5); }
    void faster() { speed_exponent_ = std::min(speed_exponent_ + 1, 3); }

  private:
    float rest_ = 0; ///< [ticks]
    bool paused_ = false;
    int single_steps_ = 0;
    int speed_exponent_ = 0;
};

} // namespace lockstone::demo
