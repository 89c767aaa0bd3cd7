// Islands: what touches or is joined, and so falls asleep and wakes together. model/sleep.h says who is awake.
#pragma once

#include "lockstone/event.h"
#include "solve/joints/joint.h"
#include "solve/vehicles/vehicle.h"
#include "tick/contacts.h"
#include "tick/events.h"

#include <span>
#include <vector>

namespace lockstone::sim {

struct IslandScratch {
    std::vector<std::uint32_t> parent;      ///< of the islands' trees, by awake row
    std::vector<std::uint32_t> still_ticks; ///< least of the island, by root; 0: held awake
    std::vector<std::uint32_t> first, last; ///< body slot + 1 of the ring so far, by root
    std::vector<BodyId> touched, resting;   ///< what wake_touched() and find_resting() found

    void reserve(std::size_t bodies) {
        for (std::vector<std::uint32_t>* list : {&parent, &still_ticks, &first, &last}) list->reserve(bodies);
        touched.reserve(bodies), resting.reserve(bodies);
    }
};

/// Wakes islands that something awake touches; true when there were any, and bounds and pairs have to be found again.
bool wake_touched(Model& w, const PlacedShapes& placed, std::span<const NearPair> near,
                  ContactScratch& contacts, IslandScratch& scratch);

/// What holds bodies together in a tick.
struct Links {
    std::span<const solve::ContactHead> contacts;
    std::span<const solve::Joint> joints;
    std::span<const solve::Standing> standing;
};
/// The motion of the tick, as far as velocities do not show it.
struct Motion {
    const PosesBefore& before;
    std::span<const std::uint32_t> afloat; ///< rows of bodies that cross the surface of a fluid, ascending
};
/// Counts how long bodies were still, and finds those that rest from now on, into `resting`: bodies of islands that were still for
/// long enough, which are linked to rings and lose their velocities, and bodies that belong to no island.
void find_resting(Model& w, const Links& links, const Motion& motion, IslandScratch& scratch);
/// Moves their rows, and those of their joints and contacts, and reports them.
void put_to_sleep(Model& w, PlacedShapes& placed, std::span<const BodyId> resting,
                  std::vector<Event>& events);

} // namespace lockstone::sim
