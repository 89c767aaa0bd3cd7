// Bodies that joints pull hard turn as if they were larger.
//
// The lever r of a force f turns with the body: when the body is turned by a, the force turns it back with the torque
// - ((r . f) 1 - r f^T) a. So a link of a chain under load swings at w^2 = (r . f) / (m K^2), and where w h is above 2 each substep makes the
// swing larger; with 1000 kg on links of 1 kg from a quarter of that on. With the torque at the end of the substep instead of at its start any
// load would be stable; that is the same as a larger moment of inertia, m K^2 + h^2 (r . f).
// source: Tournier, Nesme, Gilles, Faure, Stable Constrained Dynamics, SIGGRAPH 2015
// This is done for each principal axis: the pulls of all joints are added up and doubled, and only the part beyond a quarter of m K^2
// counts, so that most bodies stay as they are.
#pragma once

#include "solve/joints/joint.h"

#include <cstdint>
#include <span>

namespace lockstone::solve {

/// Joint::weak_a and weak_b, once for joints that stay as they are: of their masses, their levers, and the length of a substep.
void find_weak_forces(std::span<Joint> joints, const BodyColumns& columns, const StepConstants& step,
                      const SolverBodies& bodies);

/// After begin_step() and before rows are made: radii of gyration for this tick by the forces of the last one.
void stiffen_bodies(std::span<const Joint> joints, std::span<const JointMemory> memory,
                    const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies,
                    Tasks* tasks = nullptr);

/// Whether a pull f [N] at a lever r [m] is left out: true only where |f| |r| < m (k rate)^2 / 32, and always below 0.73 of that, where f
/// is a micronewton or more and r a micrometre. k: the least radius of gyration [m], above 0; rate: substeps per second.
bool is_too_weak(Vec3 f, Vec3 r, Real k, Real mass, std::int64_t rate);
/// No less than |v|, 32 fraction bits, and at most 1 / 6 and 13 steps more: a + 7 b / 16 + 6 c / 16, a >= b >= c.
std::uint64_t length_above(Vec3 v);
/// A pull f with a length_above() of at most this is_too_weak(); of others, above 0.97 of what is too weak, that is to be asked.
std::uint64_t weak_force(Vec3 r, Real k, Real mass, std::int64_t rate);
/// Whether a length_above() is so far above a weak_force() that the pull is not too weak for certain.
bool is_strong(std::uint64_t force, std::uint64_t weak);

} // namespace lockstone::solve
