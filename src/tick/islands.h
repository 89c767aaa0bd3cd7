// Islands: bodies that touch or are joined, and so fall asleep and wake together. model/sleep.h defines which bodies
// are awake.
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
    std::vector<std::uint32_t> parent;      ///< parents in the trees that form the islands, by awake row
    std::vector<std::uint32_t> still_ticks; ///< least value of the island, by root; 0: the island stays awake
    std::vector<std::uint32_t> first, last; ///< first and last body slot + 1 of the ring so far, by root
    std::vector<BodyId> touched, resting;   ///< results of wake_touched() and find_resting()

    void reserve(std::size_t bodies) {
        for (std::vector<std::uint32_t>* list : {&parent, &still_ticks, &first, &last}) list->reserve(bodies);
        touched.reserve(bodies), resting.reserve(bodies);
    }
};

/// Wakes islands that an awake body touches. Returns true if there were any; then bounds and pairs have to be found
/// again.
bool wake_touched(Model& w, const PlacedShapes& placed, std::span<const NearPair> near,
                  ContactScratch& contacts, IslandScratch& scratch);

/// The connections between bodies in a tick.
struct Links {
    std::span<const solve::ContactHead> contacts;
    std::span<const solve::Joint> joints;
    std::span<const solve::Standing> standing;
};
/// The motion in the tick that velocities do not show.
struct Motion {
    const PosesBefore& before;
    std::span<const std::uint32_t> afloat; ///< rows of bodies that cross the surface of a fluid, ascending
};
/// Counts how long bodies have been still, and stores in `resting` those that rest from now on. These are the bodies
/// of islands that were still for long enough, which are linked to rings and lose their velocities, and motionless
/// bodies that belong to no island.
void find_resting(Model& w, const Links& links, const Motion& motion, IslandScratch& scratch);
/// Moves the rows of these bodies and of their joints and contacts to the resting part of the tables, and reports the
/// bodies.
void put_to_sleep(Model& w, PlacedShapes& placed, std::span<const BodyId> resting,
                  std::vector<Event>& events);

} // namespace lockstone::sim
