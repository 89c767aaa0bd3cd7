// Bodies that joints pull hard turn as if they were larger.
//
// The lever r of a force f turns with the body. When the body has turned by a, the force turns it back with the
// torque - ((r . f) 1 - r f^T) a. A link of a chain under load therefore swings with w^2 = (r . f) / (m K^2). If w h
// is above 2, each substep makes the swing larger; with 1000 kg on links of 1 kg this begins at a quarter of that
// value. With the torque at the end of the substep instead of at its start, any load would be stable. That torque is
// equivalent to a larger moment of inertia, m K^2 + h^2 (r . f).
// source: Tournier, Nesme, Gilles, Faure, Stable Constrained Dynamics, SIGGRAPH 2015
// This is done for each principal axis. The pulls of all joints are added up and doubled, and only the part beyond a
// quarter of m K^2 counts, so that most bodies stay unchanged.
#pragma once

#include "solve/joints/joint.h"

#include <cstdint>
#include <span>

namespace lockstone::solve {

/// Computes Joint::weak_a and weak_b. They depend only on masses, levers and the length of a substep, so joints that
/// stay the same keep them.
void find_weak_forces(std::span<Joint> joints, const BodyColumns& columns, const StepConstants& step,
                      const SolverBodies& bodies);

/// Sets the radii of gyration for this tick from the joint forces of the last one. Call after begin_step() and before
/// rows are made.
void stiffen_bodies(std::span<const Joint> joints, std::span<const JointMemory> memory,
                    const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies,
                    Tasks* tasks = nullptr);

/// True if a pull f [N] at a lever r [m] can be ignored. It returns true only if |f| |r| < m (k rate)^2 / 32, and
/// always below 0.73 of that if |f| is at least a micronewton and |r| a micrometre. k: the smallest radius of
/// gyration [m], above 0; rate: substeps per second.
bool is_too_weak(Vec3 f, Vec3 r, Real k, Real mass, std::int64_t rate);
/// An upper bound of |v|, 32 fraction bits, at most 1 / 6 and 13 units too large: a + 7 b / 16 + 6 c / 16 with the
/// absolute values of the components, a >= b >= c.
std::uint64_t length_above(Vec3 v);
/// Threshold for length_above(f): at or below it, is_too_weak() is true for the pull f. Above it the caller has to
/// call is_too_weak(). The threshold is at least 0.97 of the largest force that is_too_weak() accepts.
std::uint64_t weak_force(Vec3 r, Real k, Real mass, std::int64_t rate);
/// True if `force` (a length_above()) exceeds `weak` (a weak_force()) by so much that is_too_weak() is certainly
/// false.
bool is_strong(std::uint64_t force, std::uint64_t weak);

} // namespace lockstone::solve
