// Bodies that spin fast ("followed" bodies) are turned in every substep.
//
// All other bodies keep K for a tick, and finish_step() applies their gyroscopic turn after it. A top on a joint
// would then fall for a tick as if it did not spin, be held with a wrong arm, and be turned at the end: an error of
// first order in the tick. Bodies that spin at 80 rad/s and hit the floor gain up to 30 times their energy that way.
// For followed bodies, u has a part g that is no momentum:
//
//   u = m + g      K m   angular momentum per mass, changed by impulses alone;  g: precession
//   K^-1 u = w     w = R diag(radii^-2) R^T K m, R at the middle of the coming substep
//
// g is computed again after each move. Rows therefore use the speed that the body is going to have, and the momentum
// gets no rounding errors. Impulses act at the ends of substeps and turns at their middles, as in the leapfrog
// method: second order. A top at 30 rad/s nods by 0.1 degrees, without growth, instead of by 1.4 degrees in a minute.
//
// Bodies of joints are followed even if they turn slowly. Their rows use the present levers. With the K of the start
// of the tick, a pull along a link that has turned by a tenth of a radian would spin the link about itself, five
// times as strongly as the link responds, and chains would come apart in the middle. While joints are solved, u is
// therefore K' w, with K' for the present rotation (turn_in, turn_out).
//
// Contacts keep the rows of the start of the tick. A limb that has turned responds up to six times as strongly as
// these rows predict, and every pass would add speed instead of removing it. For a body with joints, the change of u
// by contacts is therefore taken as a change of velocity, and the momentum is set to match it (note_u,
// keep_velocity).
//
// A body that turns as if it were larger (joint_stiffness.h) conserves no momentum: its u is K w. Between substeps
// the gyroscopic torque of the real body acts on the enlarged inertia. With the torque of the enlarged body, a link
// that rolls off a wall at 50 rad/s shakes its chain apart.
//
// Turns of half a substep within 1/4 rad about each axis use series, in lanes (../bodies/followed_kernel.h). u' = K'
// K^-1 u takes one matrix per substep; changes by joints are converted back by its inverse and, as momentum, by its
// transpose.
// source: Hairer, Lubich, Wanner, Geometric Numerical Integration, VII.5 (rigid bodies, splitting and midpoint rule)
#pragma once

#include "solve/bodies/solver_body.h"
#include "solve/contacts/contact.h"

#include <span>

namespace lockstone::solve {

/// Finds the bodies to follow in this tick, and their g. Call after stiffen_bodies() and before rows are made. A body
/// is followed if gyroscopic torque acts on it and it turns about some axis by more than half a radian in the tick
/// and is not thin; with a joint, thin or not, by more than a sixteenth.
void follow_turns(const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies, Tasks* tasks);

/// Turns followed bodies by their u for a substep, and computes g for the next one. |u| must be within the tip speed
/// limit.
void advance_turns(const StepConstants& step, SolverBodies& bodies, Tasks* tasks);

/// Between turn_in() and turn_out(), u of followed bodies with joints is K' w, and changes of u are momentum.
void turn_in(const StepConstants& step, SolverBodies& bodies);
void turn_out(SolverBodies& bodies);

/// Between note_u() and keep_velocity(), changes of u of followed bodies with joints are velocity.
void note_u(SolverBodies& bodies);
void keep_velocity(SolverBodies& bodies);

/// keep_velocity() for elastic impacts; call note_energies() before them. A body gets at most the energy that the
/// impulses gave according to the rows, which are those of the start of the tick.
void note_energies(SolverBodies& bodies);
void keep_energies(SolverBodies& bodies);

/// Sets FollowedTurn::meets_still: for bodies without joints that touch only still bodies.
void find_still_contacts(std::span<const Contact> contacts, SolverBodies& bodies);
/// Call before and after a pass over contacts. The rows have the inertia of the start of the tick. By such rows the
/// impulses of a pass may add energy to a body that turns by a radian within the tick, up to four times its energy in one
/// tick. A body that touches only still bodies gets a part of these impulses, with which its energy is as before. Other
/// bodies get all impulses, since a part of the impulse of a pair would change the momentum of the pair.
void note_speeds(SolverBodies& bodies);
void limit_speeds(SolverBodies& bodies);

/// Before and after a pass over contacts: note_u() and note_speeds(); keep_velocity() and limit_speeds().
inline void begin_contacts(SolverBodies& bodies) { note_u(bodies), note_speeds(bodies); }
inline void end_contacts(SolverBodies& bodies) { keep_velocity(bodies), limit_speeds(bodies); }

/// Computes FollowedTurn::spin, the angular velocity of the momentum K m at the present rotation.
void find_spins(const StepConstants& step, SolverBodies& bodies);
/// Sets g to zero, for a body whose u was shortened. `turn` as in BodyInertia.
void forget_precession(SolverBodies& bodies, std::uint32_t turn);

} // namespace lockstone::solve
