// Turns without torque, at any spin and for bodies of any thinness: for turns in which few rounds of the midpoint rule
// do not converge.
//
//   w = e_1 J_1 m_1 + e_2 J_2 m_2 + e_3 J_3 m_3     e_i principal axes, J_i = 1 / radius_i^2, m_i = e_i . m, m the
//                                                   angular momentum per mass, which is constant
//
// With J_b = J_c a body is a symmetric top, and its turn is exact: about e_a by the time times (J_a - J_b) m_a, then
// about m by the time times J_b |m|. For other bodies the turn by the part (J_c - J_b) m_c e_c comes before and after,
// each for half of the time; b and c are the axes whose J differ least. Each of these turns keeps the momentum, and the
// turns of a symmetric top keep the energy too.
// source: Fasso, Comparison of splitting algorithms for the rigid body, J. Comput. Phys. 189, 2003
#pragma once

#include "lockstone/math/vec.h"
#include "lockstone/math/wide.h"

namespace lockstone::solve {

/// Above this angle [rad] the midpoint rule has not converged. The angle is the turn of a body that has the momentum
/// along the axis of its least radius, minus the turn with the momentum along the axis of its largest radius: in a
/// tick, and in half a substep for followed bodies.
inline constexpr std::int32_t tick_turn_most = 2;
inline constexpr Real half_turn_most = decimal<Real>("0.35");

/// |v|^2, 64 fraction bits.
inline Wide square_of(Vec3 v) {
    const auto square = [](Real x) { return Wide::product(x.raw, x.raw); };
    return square(v.x) + square(v.y) + square(v.z);
}
inline Vec3 times_each(Vec3 v, Vec3 by) { return {v.x * by.x, v.y * by.y, v.z * by.z}; }

class FreeTurn {
    Vec3 radii_inv, rates; ///< 1 / radius, and J, along the principal axes
    Quat principal;
    int a, b, c; ///< the axes a, b, c of the comment at the top

  public:
    FreeTurn(Vec3 radii_inverses, Quat principal_axes);

    /// The rotation after a turn by a momentum from `rotation` for 1 / `per_second` seconds.
    Quat turned(Quat rotation, Vec3 momentum, Real per_second) const;
    /// Like the function above, but with the energy of the start, without the small errors of the steps of the turn.
    Quat turned_exactly(Quat rotation, Vec3 momentum, Real per_second) const;

    enum class Keep { all, not_above };
    /// A momentum near this one and of the same length, with which a body at `rotation` has this energy, or with
    /// Keep::not_above at most this energy.
    Vec3 with_energy(Wide energy, Quat rotation, Vec3 momentum, Keep keep) const;
    /// Like with_energy(). Where no direction of a momentum of this length has so little energy, it shortens the
    /// momentum.
    Vec3 shortened_to_energy(Wide energy, Quat rotation, Vec3 momentum, Keep keep) const;
    /// Twice the energy per mass [m^2/s^2], 64 fraction bits.
    Wide energy(Quat rotation, Vec3 momentum) const;
    Vec3 spin_at(Quat rotation, Vec3 momentum) const;

  private:
    Vec3 tip_speeds(const Rotation& axes, Vec3 momentum) const;
    Rotation axes_at(Quat rotation) const;
    int steps_of(Vec3 momentum, Real per_second) const;
};

} // namespace lockstone::solve
