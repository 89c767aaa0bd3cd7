#pragma once
/// The bar along the lower edge. It shows the current time of a replay and lets the mouse change it.

#include "page.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lockstone::demo {

/// The result of checking a tick of a recording.
enum class TickCheck : std::uint8_t {
    unknown,   ///< not simulated yet
    bit_exact, ///< the re-simulated state has the recorded hash
    differs,
};

struct TimelineContent {
    std::uint64_t start = 0, end = 0, now = 0; ///< times: the state before that tick
    std::uint32_t tick_rate = 60;
    std::vector<std::uint64_t> keyframes;
    std::span<const TickCheck> checks; ///< of tick start + i
};

class Timeline {
  public:
    /// The time at which the mouse holds the bar; empty while it does not.
    std::optional<std::uint64_t> drag(const Input& input, const Moment& moment,
                                      const TimelineContent& content);
    void draw(Frame& frame, const Moment& moment, const TimelineContent& content) const;
    /// The height of the bar at the picture's lower edge [design px].
    static constexpr float height = 58;

  private:
    static void draw_checks(Frame& frame, const Moment& moment, const TimelineContent& content);
    bool dragging_ = false;
};

} // namespace lockstone::demo
