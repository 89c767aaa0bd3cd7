// One tick: a pure function of the state and the commands since the last tick. tick.cpp has the order of its phases.
#pragma once

#include "lockstone/journal.h"
#include "play/character/character.h"
#include "play/fluids/fluids.h"
#include "play/vehicle/vehicle_driver.h"
#include "solve/bodies/solver_body.h"
#include "solve/contacts/contact_solver.h"
#include "solve/contacts/pressed.h"
#include "solve/joints/joint.h"
#include "tick/contacts.h"
#include "tick/events.h"
#include "tick/islands.h"
#include "tick/joints.h"
#include "tick/pairs.h"
#include "tick/sweep.h"

#include <vector>

namespace lockstone::sim {

/// Scratch memory of a tick, grouped by the phase that writes it. No later tick depends on it, with two exceptions:
/// the contact table, which is a copy of the state's, and hints, which change speed only.
struct TickScratch {
    TickScratch() { bodies.kernel = solve::kernels_of(best_simd())->bodies; }
    void reserve(const WorldRows& rows) {
        bodies.reserve(rows.bodies);
        islands.reserve(rows.bodies);
        pair_scratch.reserve(rows);
        table.reserve(rows.contacts);
        contact_scratch.reserve(rows.contacts), found.reserve(rows.contacts);
        near.ended.reserve(rows.contacts), contacts.reserve(rows.contacts, rows.bodies);
        pressed.reserve(rows.bodies, rows.contacts), wheel_loads.reserve(rows.bodies);
    }

    CharacterScratch characters;

    PairScratch pair_scratch;
    NearPairs near;

    ContactCopy table; ///< the last tick's, then this tick's; the tick writes it to the state at its end
    ContactScratch contact_scratch;
    FoundContacts found;

    PosesBefore pose_before;
    JointList joints;
    FieldsOfTick fields;

    solve::StepConstants step{};
    solve::StepSettings step_of{}; ///< the settings of `step`; ticks_per_second is 0 before the first tick
    solve::SolverBodies bodies;
    std::vector<solve::Load> wheel_loads;
    solve::PressedBodies pressed;
    solve::ContactSolver contacts;
    solve::JointSolver joint_solver{*solve::kernels_of(best_simd())->joints};
    VehicleDriver vehicles;
    solve::VehicleSolver vehicle_solver;
    FluidSolver fluids;

    SweepScratch sweep;
    std::vector<JointId> broken;
    IslandScratch islands;

    base::Paths paths; ///< of the last tick, once it has ended
};

/// Results of the last tick that are not part of the state.
struct TickOutput {
    std::vector<Event> events;
    ContactPoints contact_points;
    std::vector<PhaseHash> phase_hashes; ///< filled only if TickHooks::phase_hashes is set

    void reserve(const WorldRows& rows) { contact_points.reserve(std::size_t{4} * rows.contacts); }
};

struct TickHooks {
    Tasks* tasks = nullptr; ///< null: one thread does all work
    PhaseObserver* observer = nullptr;
    bool phase_hashes = false;
};

/// Overwrites with a byte all scratch memory that every tick writes before it reads it. Caches keep their values.
/// (poison.cpp)
void poison_scratch(Model& w, PlacedShapes& placed, QueryScratch& query, TickScratch& scratch,
                    std::byte with);

void tick(Model& w, PlacedShapes& placed, QueryScratch& query, TickScratch& scratch, TickOutput& out,
          const TickHooks& hooks);

} // namespace lockstone::sim
