// Continuous collision: a body that moved far in the tick is stopped where it first met another shape.
//
//   body          static   kinematic   dynamic
//   any, fast     yes      yes         no
//   bullet        yes      yes         yes, other bullets too
//
// Guarantee: the core of a shape (a ball of half its inner radius about its core centre) never passes through a shape
// against which its body is swept. A shape that was apart from a piece (a convex part, a triangle) stops where it
// comes within collide::stop_gap of it. Exception: a rounded shape that would enter by less than half of its rounding
// is not stopped; contacts push it out.
// A body with joints would be torn from them where it is stopped. So for such a body only the centre of the core is
// guaranteed, and that centre may enter a plane or a box as deep as the shape's inner radius: contacts push it out to
// the side from which it came.
// Against a shape that does not move, only the motion towards it ends: the body slides on along it, and a body that
// is stopped by its core turns about the core. The velocity is kept: the contacts of the next tick stop the body.
//
// A shape is fast if one of its points may have moved in the tick, relative to the other shape, by more than half of
// the shape's inner radius. Against moving shapes the limit is a quarter of that radius, or a 64th for a bullet that
// is no ball. Rotation counts with the shape's reach. Slower shapes are left to the contacts, whose margin reaches
// further than that.
// Not swept: shapes that may not collide, and pairs of bodies that both rest. A sensor stops nothing;
// find_crossings() reports the bullets that cross it.
#pragma once

#include "tick/events.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace lockstone::sim {

/// A stopped body and the pose at which it stopped.
struct StoppedBody {
    std::uint32_t row;
    Transform at;
};

struct SweepScratch {
    /// Scratch memory of one worker.
    struct alignas(64) Worker {
        collide::BroadPhase::Asker near; ///< shapes near the path
        std::vector<UnitVec3> touching;
        std::vector<StoppedBody> stopped;
    };
    std::vector<Worker> workers;
    std::vector<std::uint32_t> driven; ///< shapes of awake bodies that are not dynamic
    base::Paths paths;                 ///< of the tick
};

/// Replaces the poses of fast bodies in the state by those where they stop. A pure function of the poses before the
/// tick and the poses that finish_step() stored.
/// `workers`: scratch memory of the narrow phase.
void sweep_fast_bodies(Model& w, PlacedShapes& placed, const PosesBefore& before,
                       std::span<NarrowWorker> workers, SweepScratch& scratch, Tasks* tasks);

/// Appends sensor_begin and sensor_end for each bullet that entered and left a sensor within the tick, that is, that
/// overlaps the sensor neither at the start of the tick nor at its end. Does so too for a sensor that is part of a
/// bullet. A pair that overlaps at the start, or that has an event in `events`, gets none.
/// `contacts`: the table after the tick's narrow phase. (crossings.cpp)
void find_crossings(const Model& w, const PlacedShapes& placed, const PosesBefore& before,
                    const ContactList& contacts, NarrowWorker& narrow, SweepScratch& scratch,
                    std::vector<Event>& events);

} // namespace lockstone::sim
