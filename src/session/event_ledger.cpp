#include "session/event_ledger.h"

#include "base/assert.h"

#include <algorithm>

namespace lockstone::session {

EventLedger::EventLedger(std::uint32_t window) : ring(window) {
    constexpr std::size_t usual = 32; // events in a tick; more of them allocate memory, which is kept
    for (std::vector<Entry>& tick : ring) tick.reserve(usual);
    merged.reserve(usual);
}

void EventLedger::begin_at(std::uint64_t tick) {
    LOCKSTONE_ASSERT(first_open == end, "ticks [", first_open, ", ", end, ") are open");
    first_open = end = tick;
}

void EventLedger::record(std::uint64_t tick, std::span<const Event> events) {
    LOCKSTONE_ASSERT(tick >= first_open && tick < first_open + ring.size(), "tick ", tick, ", open from ",
                     first_open);
    const auto are_out_of_order = [](const Event& a, const Event& b) { return !precedes(a, b); };
    if (std::ranges::adjacent_find(events, are_out_of_order) != events.end()) {
        sorted.assign(events.begin(), events.end());
        std::ranges::stable_sort(sorted, precedes);
        sorted.erase(std::unique(sorted.begin(), sorted.end(), are_out_of_order), sorted.end());
        events = sorted;
    }
    std::vector<Entry>& before = entries(tick);
    merged.clear();
    auto old = before.begin();
    for (const Event& event : events) {
        for (; old != before.end() && precedes(old->event, event); ++old) {
            // No longer present: publish() cancels it.
            if (old->told) merged.push_back({old->event, old->id, true, false});
        }
        if (old != before.end() && !precedes(event, old->event)) {
            merged.push_back({event, old->id, old->told, true});
            ++old;
        } else {
            merged.push_back({event, next_id++, false, true});
        }
    }
    for (; old != before.end(); ++old) {
        if (old->told) merged.push_back({old->event, old->id, true, false});
    }
    before.swap(merged);
    end = std::max(end, tick + 1);
}

void EventLedger::publish(std::uint64_t confirmed_end, std::vector<SessionEvent>& out) {
    for (std::uint64_t tick = first_open; tick < end; ++tick)
        publish_tick(entries(tick), tick < confirmed_end, out);
    first_open = std::clamp(confirmed_end, first_open, end);
}

void EventLedger::publish_tick(std::vector<Entry>& tick, bool is_final, std::vector<SessionEvent>& out) {
    for (Entry& entry : tick) {
        if (!entry.present)
            out.push_back({entry.event, EventStatus::cancelled, entry.id});
        else if (is_final)
            out.push_back({entry.event, EventStatus::confirmed, entry.id});
        else if (!entry.told)
            out.push_back({entry.event, EventStatus::predicted, entry.id});
        entry.told = true;
    }
    if (is_final)
        tick.clear();
    else
        std::erase_if(tick, [](const Entry& entry) { return !entry.present; });
}

} // namespace lockstone::session
