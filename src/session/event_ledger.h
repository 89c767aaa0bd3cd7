// Publication of events that rollbacks may change.
//
// A tick may run many times, and each run replaces the events of the tick. publish() compares the published
// events with the present ones and reports the difference: predicted, confirmed or cancelled. If a later
// run restores a cancelled event, this is a new event with a new id: so each id has exactly one end.
#pragma once

#include "lockstone/session.h"

#include <compare>

namespace lockstone::session {

class EventLedger {
  public:
    /// `window`: capacity [ticks]; ticks t and t + window must never be unconfirmed at the same time.
    explicit EventLedger(std::uint32_t window);

    /// Makes `tick` the next tick. If unconfirmed ticks remain, the program ends.
    void begin_at(std::uint64_t tick);
    /// Replaces the events of tick `tick` after a run. A World returns events in the order of precedes().
    /// Events of another simulation that are out of order are sorted here, and of equal ones the first is
    /// kept.
    void record(std::uint64_t tick, std::span<const Event> events);
    /// Appends to `out` what changed since the last call. Ticks below `confirmed_end` are final.
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
    std::uint64_t first_open = 0;         ///< ticks below are confirmed and published
    std::uint64_t end = 0;                ///< ticks below have run
    std::uint64_t next_id = 0;
};

} // namespace lockstone::session
