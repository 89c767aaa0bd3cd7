// Continuous collision: what moved far in the tick is stopped where it first met something.
//
//   body          static   kinematic   dynamic
//   any, fast     yes      yes         no
//   bullet        yes      yes         yes, other bullets too
//
// Guarantee: the core of a shape (a ball of half its inner radius about its core centre) never passes through what its
// body is swept against, and a shape that was apart from a piece (a convex part, a triangle) stops where it comes within
// collide::stop_gap of it, unless it is rounded and would enter by less than half of its rounding: contacts push it out of
// that. A body that joints hold is torn from them where it is stopped, so there the guarantee is of the core's centre alone, and the
// core's centre may enter a plane or a box as deep as the shape's inner radius: contacts push it out to the side that it came from.
// Against a shape that does not move only the motion towards it ends: a body slides on along it, and a body that is stopped by its core turns about
// that. Velocity is kept: the contacts of the next tick stop it.
//
// Fast: a point of the shape may have moved in the tick, against what it is swept against, by more than half of the
// shape's inner radius. Against what moves: by more than a quarter of it, or a 64th for a bullet that is no ball. Turning counts with the
// shape's reach.
// Slower ones are left to the contacts, whose margin looks further ahead than that.
// Not swept: shapes that may not meet, pairs of bodies that both rest. A sensor stops nothing; find_crossings() reports the bullets that cross it.
#pragma once

#include "tick/events.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace lockstone::sim {

/// A body that was stopped, and where.
struct StoppedBody {
    std::uint32_t row;
    Transform at;
};

struct SweepScratch {
    /// What a worker needs for itself.
    struct alignas(64) Worker {
        collide::BroadPhase::Asker near; ///< shapes near the way
        std::vector<UnitVec3> touching;
        std::vector<StoppedBody> stopped;
    };
    std::vector<Worker> workers;
    std::vector<std::uint32_t> driven; ///< shapes of awake bodies that are not dynamic
    base::Paths paths;                 ///< of the tick
};

/// Poses of fast bodies in the state, from those before the tick and where finish_step put them. A pure function of these.
/// `workers`: memory of the narrow phase.
void sweep_fast_bodies(Model& w, PlacedShapes& placed, const PosesBefore& before,
                       std::span<NarrowWorker> workers, SweepScratch& scratch, Tasks* tasks);

/// Appends sensor_begin and sensor_end for each bullet that entered and left a sensor within the tick: the two overlap neither at its start
/// nor at its end. The same of a sensor that a bullet carries. A pair that overlaps at the start, or that has an event in `events`, gets none.
/// `contacts`: the table after the tick's narrow phase. (crossings.cpp)
void find_crossings(const Model& w, const PlacedShapes& placed, const PosesBefore& before,
                    const ContactList& contacts, NarrowWorker& narrow, SweepScratch& scratch,
                    std::vector<Event>& events);

} // namespace lockstone::sim
