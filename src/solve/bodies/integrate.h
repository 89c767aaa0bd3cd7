// Free motion: the motion of a body by force fields, gravity and damping in one substep, with the world's integrator.
#pragma once

#include "solve/bodies/solver_body.h"

namespace lockstone::solve {

/// The values of lockstone::Integrator, which a higher layer declares.
enum class Scheme : std::uint32_t { semi_implicit_euler, verlet, velocity_verlet, runge_kutta_4 };

/// The forces of free motion in one tick.
struct FreeMotion {
    Scheme scheme;
    std::span<const FieldRow> fields; ///< of acceleration: no fluids
    /// By body row, the categories of its shapes; empty: no field depends on them
    std::span<const std::uint32_t> categories{};
};

/// Computes the velocities after the substep, before constraints. The difference between a scheme's move and (velocity
/// after) * time goes to SolverBodies::drift, so contacts correct the motion of every scheme.
void integrate_velocities(const FreeMotion& motion, const BodyColumns& columns, const StepConstants& step,
                          SolverBodies& bodies, Tasks* tasks = nullptr);
/// shift += v h + drift, theta += u h.
void integrate_poses(const StepConstants& step, SolverBodies& bodies, Tasks* tasks = nullptr);

/// True if only gravity, forces and damping move bodies, with the solver's own scheme.
bool is_plain_motion(const FreeMotion& motion);
/// These versions handle the bodies `rows` only, in plain motion; none of them is followed.
void integrate_velocities(const StepConstants& step, SolverBodies& bodies,
                          std::span<const std::uint32_t> rows);
void integrate_poses(const StepConstants& step, SolverBodies& bodies, std::span<const std::uint32_t> rows);

/// Acceleration [m/s^2] at a point by all fields that act on a body whose shapes have these categories. Fluids have
/// none.
Vec3 field_acceleration(std::span<const FieldRow> fields, Vec3 point, std::uint32_t categories);
/// The mask of a field that also acts on bodies without shapes.
inline constexpr std::uint32_t every_category = 0xffffffffu;

/// All substeps of the bodies that move and that impulses do not move, for ticks in which no pass reads them: no
/// contact or joint has such a body. `has_begun`: the velocities of the first substep are already integrated.
void move_driven(const StepConstants& step, SolverBodies& bodies, bool has_begun);

} // namespace lockstone::solve
