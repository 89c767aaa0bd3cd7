// One contact point in the resolver: sections 2.3 and 4.3.2 of the thesis (formulas 4 to 6, listings 5 and 6), with its
// names.
//
// The listings call functions that they do not print (the internals, friction, the change of positions). These follow
// the book from which their names and the pages of reference [6] come: I. Millington, Game Physics Engine Development,
// 2nd ed. 2010, chapters 14 and 15.
#pragma once

#include "reference/engine/rigid_body.h"

#include <array>

namespace reference::LOCKSTONE_REFERENCE_BUILD {

/// How one iteration moves a body: a translation `linear` and a rotation `angular` [m], [rad], or changes of the
/// velocities.
struct Change {
    V3 linear, angular;
};

struct Collision {
    Collision(const Contact& contact, std::span<Rigidbody> all, const Resolver& settings);

    std::array<Rigidbody*, 2> bodies;
    std::array<int, 2> indices; ///< of the bodies
    V3 point;
    V3 contact_normal;   ///< n, from the second body to the first
    M3 contact_to_world; ///< columns: n and two tangents
    Number penetration;  ///< p [m]
    Number friction, restitution;
    std::array<V3, 2> relative_contact_position; ///< r, from each body's centre of mass
    V3 contact_velocity; ///< of the first body relative to the second, in the contact's axes [m/s]
    Number desired_delta_velocity{}; ///< v_d along n [m/s], formula 6

    void calculate_internals(Number duration);
    void calculate_desired_delta_velocity(Number duration);
    /// Moves the bodies apart by p along n, in linear and angular shares.
    std::array<Change, 2> apply_position_change();
    /// Listing 6. Returns the changes, which listing 7 needs.
    std::array<Change, 2> apply_velocity_change();

  private:
    V3 frictionless_impulse() const; ///< listing 5
    V3 friction_impulse() const;
    M3 velocity_per_impulse() const;

    Number bounce_speed_min, angular_limit;
};

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
