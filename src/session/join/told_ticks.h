// Ticks of the confirmed timeline as they come from a host: what lies after a gap waits for it, in memory of one size.
#pragma once

#include "session/timeline.h"

#include <algorithm>

namespace lockstone::session {

/// After so many polls in which a host tells nothing new the next one is asked, where there is one.
inline constexpr std::uint32_t host_silence_polls = 180;

class ToldTicks {
  public:
    explicit ToldTicks(std::size_t bytes_of_a_tick)
        : tick_bytes(bytes_of_a_tick), ring(history_ticks * tick_bytes), ticks(history_ticks, never) {}

    /// The next tick is `tick`.
    void begin_at(std::uint64_t tick) { first_missing = tick; }
    /// Takes what is missing below `needed_from` + history_ticks: ticks from `needed_from` on are still read by at().
    void take(const Stretch& stretch, std::uint64_t needed_from) {
        for (std::uint32_t t = 0; t < stretch.count; ++t) {
            const std::uint64_t tick = stretch.first + t;
            if (tick < first_missing || tick >= needed_from + history_ticks) continue;
            std::ranges::copy(stretch.bytes.subspan(t * tick_bytes, tick_bytes),
                              ring.begin() + static_cast<std::ptrdiff_t>(tick % history_ticks * tick_bytes));
            ticks[tick % history_ticks] = tick;
        }
        while (first_missing < needed_from + history_ticks &&
               ticks[first_missing % history_ticks] == first_missing)
            ++first_missing;
    }
    std::uint64_t next() const { return first_missing; } ///< ticks below are here
    /// The bytes of a tick that is here, as Stretch tells: the newest history_ticks.
    std::span<const std::byte> at(std::uint64_t tick) const {
        return std::span(ring).subspan(tick % history_ticks * tick_bytes, tick_bytes);
    }

  private:
    std::size_t tick_bytes;
    std::vector<std::byte> ring;      ///< by tick modulo history_ticks
    std::vector<std::uint64_t> ticks; ///< which tick is there
    std::uint64_t first_missing = 0;
};

} // namespace lockstone::session
