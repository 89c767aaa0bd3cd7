// What finding islands and moving rows between awake and asleep needs from call to call: memory only.
#pragma once

#include "model/contact_rows.h"

#include <cstdint>
#include <vector>

namespace lockstone::sim {

struct SleepScratch {
    std::vector<std::uint32_t> parent;      ///< of the islands' trees, by awake row
    std::vector<std::uint32_t> still_ticks; ///< least of the island, by root; 0: held awake
    std::vector<BodyId> leaving;
    std::vector<std::uint32_t> first, last; ///< body slot + 1 of the ring so far, by root
    ContactList here, moving,
        there; ///< rows of one table, those that leave it, those of the table they go to
};

} // namespace lockstone::sim
