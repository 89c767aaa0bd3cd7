// Turns without torque, at any spin and for bodies as thin as they may be: where few rounds of the midpoint rule do not converge.
//
//   w = e_1 J_1 m_1 + e_2 J_2 m_2 + e_3 J_3 m_3     e_i principal axes, J_i = 1 / radius_i^2, m_i = e_i . m,
//                                                   m angular momentum per mass, which stays
//
// With J_b = J_c a body is a symmetric top, and its turn is exact: about e_a by the time times (J_a - J_b) m_a, then about m by the time
// times J_b |m|. Of other bodies the part (J_c - J_b) m_c e_c is turned by before and after, each for half of the time; b and c are those
// axes whose J differ least. Each of these turns keeps the momentum, and of a symmetric top the energy too.
// source: Fasso, Comparison of splitting algorithms for the rigid body, J. Comput. Phys. 189, 2003
#pragma once

#include "lockstone/math/vec.h"
#include "lockstone/math/wide.h"

namespace lockstone::solve {

/// Beyond this the midpoint rule has not converged [rad]: the turn in a time of what has the momentum along the axis of its least radius, less the
/// turn along that of its largest. In a tick, and in half a substep where bodies are followed.
inline constexpr std::int32_t tick_turn_most = 2;
inline constexpr Real half_turn_most = decimal<Real>("0.35");

/// |v|^2, 64 fraction bits.
inline Wide square_of(Vec3 v) {
    const auto square = [](Real x) { return Wide::product(x.raw, x.raw); };
    return square(v.x) + square(v.y) + square(v.z);
}
inline Vec3 times_each(Vec3 v, Vec3 by) { return {v.x * by.x, v.y * by.y, v.z * by.z}; }

class FreeTurn {
    Vec3 radii_inv, rates; ///< 1 / radius and J along the principal axes
    Quat principal;
    int a, b, c; ///< as above

  public:
    FreeTurn(Vec3 radii_inverses, Quat principal_axes);

    /// Where a turn by a momentum for 1 / `per_second` leads from a rotation.
    Quat turned(Quat rotation, Vec3 momentum, Real per_second) const;
    /// Like the function above, with the energy of the start: the steps of the turn have small errors.
    Quat turned_exactly(Quat rotation, Vec3 momentum, Real per_second) const;

    enum class Keep { all, not_above };
    /// A momentum of the same length near this one, with which a body at a rotation has that energy, or no more.
    Vec3 with_energy(Wide energy, Quat rotation, Vec3 momentum, Keep keep) const;
    /// Twice the energy per mass [m^2/s^2], 64 fraction bits.
    Wide energy(Quat rotation, Vec3 momentum) const;
    Vec3 spin_at(Quat rotation, Vec3 momentum) const;

  private:
    Vec3 tip_speeds(const Rotation& axes, Vec3 momentum) const;
    Rotation axes_at(Quat rotation) const;
    int steps_of(Vec3 momentum, Real per_second) const;
};

} // namespace lockstone::solve
