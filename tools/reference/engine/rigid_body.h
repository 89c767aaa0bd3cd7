// A rigid body and its motion between contacts: sections 2.1 and 4.3.1 of the thesis (listing 4), with its names.
#pragma once

#include "reference/engine/number.h"

#include <vector>

namespace reference::LOCKSTONE_REFERENCE_BUILD {

/// A field of acceleration in the build's number type; see reference::Field.
struct Pull {
    Attraction kind;
    V3 center;
    Number strength, softening;
    V3 acceleration;
};

/// The forces and settings that act on all bodies.
struct Forces {
    Number dt;
    V3 gravity;
    bool gyroscopic;
    std::vector<Pull> fields;
};

struct Rigidbody {
    explicit Rigidbody(const BodyStart& start);

    Number inverse_mass;                    ///< 1 / m [1/kg]; 0: infinite
    V3 inverse_inertia;                     ///< 1 / I about the principal axes [1/(kg m^2)]
    Q4 principal;                           ///< turns the body's axes into the principal axes
    Number linear_damping, angular_damping; ///< d: the share of a velocity that remains after a second
    Number gravity_scale;
    bool in_fields;

    V3 position;                  ///< x, of the centre of mass [m]
    Q4 orientation;               ///< q
    V3 velocity;                  ///< v [m/s]
    V3 rotation;                  ///< w, the angular velocity [rad/s]
    V3 force_accum, torque_accum; ///< F [N], T [N m]
    V3 previous_acceleration;     ///< a of the last step [m/s^2], for the resolver
    M3 inverse_world_inertia;     ///< 1 / I in the world's axes

    bool is_movable() const { return inverse_mass > 0; }
    void add_force_at_point(V3 force, V3 point); ///< listing 4
    void update_derived();                       ///< the end of listing 3: normalises q, turns the inertia

    /// The acceleration at a position, from gravity, fields and F / m (F = m a, formula 5).
    V3 acceleration_at(V3 place, const Forces& forces) const;
    /// 1/I (T - w x I w); the second term only if Law::gyroscopic is set.
    V3 angular_acceleration_at(Q4 turn, V3 spin, const Forces& forces) const;
    V3 velocity_at(V3 relative) const { return velocity + cross(rotation, relative); }
};

/// The function for one step of a body.
using Integrate = void (*)(Rigidbody&, const Forces&);
Integrate integrator_of(Integrator kind);

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
