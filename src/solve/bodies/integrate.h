// Free motion: what force fields, gravity and damping do to a body in one substep, by the world's integrator.
#pragma once

#include "solve/bodies/solver_body.h"

namespace lockstone::solve {

/// As lockstone::Integrator, which is declared a layer above.
enum class Scheme : std::uint32_t { semi_implicit_euler, verlet, velocity_verlet, runge_kutta_4 };

/// The forces of free motion in one tick.
struct FreeMotion {
    Scheme scheme;
    std::span<const FieldRow> fields; ///< of acceleration: no fluids
    /// By body row, of its shapes; empty: no field looks at them
    std::span<const std::uint32_t> categories{};
};

/// Velocity after the substep, before constraints. What the scheme moves a body beyond (velocity after) * time goes
/// to SolverBodies::drift, so contacts still correct the motion of every scheme.
void integrate_velocities(const FreeMotion& motion, const BodyColumns& columns, const StepConstants& step,
                          SolverBodies& bodies, Tasks* tasks = nullptr);
/// shift += v h + drift, theta += u h.
void integrate_poses(const StepConstants& step, SolverBodies& bodies, Tasks* tasks = nullptr);

/// Whether gravity, forces and damping alone move bodies, by the solver's own scheme.
bool is_plain_motion(const FreeMotion& motion);
/// The same of some bodies in plain motion, of which none is followed.
void integrate_velocities(const StepConstants& step, SolverBodies& bodies,
                          std::span<const std::uint32_t> rows);
void integrate_poses(const StepConstants& step, SolverBodies& bodies, std::span<const std::uint32_t> rows);

/// Acceleration at a point [m/s^2] of all fields that act on a body whose shapes have these categories. Fluids have none.
Vec3 field_acceleration(std::span<const FieldRow> fields, Vec3 point, std::uint32_t categories);
/// The mask of a field that acts on bodies without shapes too.
inline constexpr std::uint32_t every_category = 0xffffffffu;

/// All substeps of the bodies that move and that no impulse moves, where no pass reads them: no contact or joint has them. `has_begun`: the first velocities
/// are integrated.
void move_driven(const StepConstants& step, SolverBodies& bodies, bool has_begun);

} // namespace lockstone::solve
