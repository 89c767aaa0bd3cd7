// Buffer of fixed size for ticks of the confirmed timeline from a host. Ticks after a gap stay in it until
// the gap is filled.
#pragma once

#include "session/timeline.h"

#include <algorithm>

namespace lockstone::session {

/// A listener changes to the next host after so many polls without new ticks, if it has another host.
inline constexpr std::uint32_t host_silence_polls = 180;

/// Ring of received ticks. The format of a tick is that of Stretch::bytes.
class ToldTicks {
  public:
    explicit ToldTicks(std::size_t bytes_of_a_tick)
        : tick_bytes(bytes_of_a_tick), ring(history_ticks * tick_bytes), ticks(history_ticks, never) {}

    /// Makes `tick` the first missing one.
    void begin_at(std::uint64_t tick) { first_missing = tick; }
    /// Stores the missing ticks below `needed_from` + history_ticks. at() may still read ticks from
    /// `needed_from` on, so their slots are not reused.
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
    std::uint64_t next() const { return first_missing; } ///< all ticks below have arrived
    /// The bytes of an arrived tick; the ring holds the newest history_ticks.
    std::span<const std::byte> at(std::uint64_t tick) const {
        return std::span(ring).subspan(tick % history_ticks * tick_bytes, tick_bytes);
    }

  private:
    std::size_t tick_bytes;
    std::vector<std::byte> ring;      ///< [history_ticks] by tick modulo history_ticks
    std::vector<std::uint64_t> ticks; ///< the tick in each slot
    std::uint64_t first_missing = 0;
};

} // namespace lockstone::session
