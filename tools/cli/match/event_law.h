// Checks the order of the event notices that a session sends.
#pragma once

#include "lockstone/session.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>

namespace lockstone::cli {

/// The rule for session events: each id has at most one `predicted`, then exactly one end (confirmed or cancelled). A
/// cancelled event was predicted before.
class EventLaw {
  public:
    void see(const SessionEvent& e) {
        Life& life = lives[e.id];
        if (e.status == EventStatus::predicted)
            broken = broken || life.predicted || life.ended;
        else
            broken = broken || life.ended || (e.status == EventStatus::cancelled && !life.predicted);
        life.predicted = life.predicted || e.status == EventStatus::predicted;
        life.ended = life.ended || e.status != EventStatus::predicted;
        life.tick = e.event.tick;
        ++counts[static_cast<std::size_t>(e.status)];
    }
    /// True if no notice broke the rule and every event of a tick below `confirmed_end` has ended.
    bool holds(std::uint64_t confirmed_end) const {
        if (broken) return false;
        for (const auto& [id, life] : lives) {
            if (life.tick < confirmed_end && !life.ended) return false;
        }
        return true;
    }
    std::uint64_t count(EventStatus status) const { return counts[static_cast<std::size_t>(status)]; }

  private:
    struct Life {
        bool predicted = false, ended = false;
        std::uint64_t tick = 0;
    };
    std::map<std::uint64_t, Life> lives;
    std::array<std::uint64_t, 3> counts{};
    bool broken = false;
};

} // namespace lockstone::cli
