// Which events the game was told of, and which of them proved true.
//
// A tick may run many times. Each run replaces the tick's events; publish() compares what was told with what is there
// now, and tells the difference: predicted, confirmed or cancelled. A cancelled event that a later run brings back is
// a new one with a new id, so that every id has exactly one end.
#pragma once

#include "lockstone/session.h"

#include <compare>

namespace lockstone::session {

class EventLedger {
  public:
    /// Ticks t and t + window must never be unconfirmed at once.
    explicit EventLedger(std::uint32_t window);

    /// The next tick is `tick`: what was there before is over. Nothing is open (asserted).
    void begin_at(std::uint64_t tick);
    /// Tick `tick` has run (again) and shows these events. A World gives them in the order of precedes(); events of a game's own simulation
    /// that are out of order are sorted, and of equal ones the first counts.
    void record(std::uint64_t tick, std::span<const Event> events);
    /// Ticks below `confirmed_end` will not run again. Appends what changed since the last call to `out`.
    void publish(std::uint64_t confirmed_end, std::vector<SessionEvent>& out);

  private:
    struct Entry {
        Event event;
        std::uint64_t id;
        bool told;    ///< published as predicted
        bool present; ///< in the latest run of the tick
    };
    std::vector<Entry>& entries(std::uint64_t tick) { return ring[tick % ring.size()]; }
    void publish_tick(std::vector<Entry>& tick, bool is_final, std::vector<SessionEvent>& out);

    std::vector<std::vector<Entry>> ring; ///< by tick modulo window, ordered by identity
    std::vector<Entry> merged;            ///< scratch
    std::vector<Event> sorted;            ///< scratch
    std::uint64_t first_open = 0;         ///< ticks below are confirmed and told
    std::uint64_t end = 0;                ///< ticks below have run
    std::uint64_t next_id = 0;
};

} // namespace lockstone::session
