// Bodies that spin are turned substep by substep.
//
// Other bodies keep K for a tick, and their gyroscopic turn is made after it (finish_step). A top on a joint would so
// fall for a tick as if it did not spin, be held with a wrong arm, and be turned at last: an error of first order in the
// tick. What spins at 80 rad/s and hits the floor gained up to 30 times its energy. Followed, u has a part that is no
// momentum:
//
//   u = m + g      K m   angular momentum per mass, changed by impulses alone;  g: precession
//   K^-1 u = w     w = R diag(radii^-2) R^T K m, R at the middle of the coming substep
//
// g is found anew after each move, so rows see the speed that the body will have, and no rounding enters the momentum.
// Impulses act at the ends of substeps and turns at their middles, as in the leapfrog: second order. A top at 30 rad/s
// nods by 0.1 degrees, without growing, instead of by 1.4 in a minute.
//
// What joints hold is followed from small turns on. Their rows have the levers of now, and with the K of the start of the
// tick a pull along a link that has turned by a tenth of a radian spins it about itself, five times as strongly as it would
// answer: chains came apart in the middle. So while joints are solved u is K' w, K' of where the body is now (turn_in, turn_out).
// Contacts keep rows of the start, to which a limb that has turned answers up to six times as strongly as they say, and every
// pass adds speed instead of taking it away. What they give a body that joints hold is taken for a change of
// velocity, and momentum for what belongs to it (note_u, keep_velocity).
// A body that turns as if it were larger (joint_stiffness.h) has no momentum that would be kept: its u is K w, and between
// substeps the gyroscopic torque of the body as it is acts on the body as it answers. With the torque of the larger one a
// link that rolled off a wall at 50 rad/s shakes its chain apart.
// Turns of half a substep within 1/4 rad about each axis follow series, in lanes (../bodies/followed_kernel.h); u' = K' K^-1 u
// by one matrix a substep, and what joints add goes back by its inverse and, as momentum, by its transpose.
// source: Hairer, Lubich, Wanner, Geometric Numerical Integration, VII.5 (rigid bodies, splitting and midpoint rule)
#pragma once

#include "solve/bodies/solver_body.h"

namespace lockstone::solve {

/// After stiffen_bodies() and before rows are made: finds the bodies that are followed in this tick, and their g. These
/// are those that feel gyroscopic torque and turn about some axis by half a radian in the tick or more, or by a sixteenth
/// where a joint holds them.
void follow_turns(const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies, Tasks* tasks);

/// Turns followed bodies by their u for a substep and finds g for the next one. |u| is within the tip speed limit.
void advance_turns(const StepConstants& step, SolverBodies& bodies, Tasks* tasks);

/// From here to turn_out(), u of followed bodies that joints hold is K' w; what is added to that is momentum.
void turn_in(const StepConstants& step, SolverBodies& bodies);
void turn_out(SolverBodies& bodies);

/// What is added to u of followed bodies that joints hold between these two is velocity.
void note_u(SolverBodies& bodies);
void keep_velocity(SolverBodies& bodies);

/// FollowedTurn::spin: angular velocity of the momentum K m where the body is now.
void find_spins(const StepConstants& step, SolverBodies& bodies);
/// Of a body whose u was shortened; `turn` as in BodyInertia.
void forget_precession(SolverBodies& bodies, std::uint32_t turn);

} // namespace lockstone::solve
