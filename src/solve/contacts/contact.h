// Contacts as the narrow phase writes them. src/solve/contacts solves them.
#pragma once

#include "solve/bodies/rows.h"

#include <array>

namespace lockstone::solve {

/// A point of a contact, in world axes; levers start at each body's centre of mass. Two rows of four numbers, as lanes
/// read and write them.
struct ContactPoint {
    LengthVec3 lever_a;    ///< [m]
    Separation separation; ///< [m]
    LengthVec3 lever_b;    ///< [m]
    Speed impulse;         ///< from the last tick: ContactPointMemory::normal
};
/// Three cache lines with all data that the solver needs to prepare a contact. The solver takes contacts in an order of
/// its own, so data in other tables would be far apart in memory.
struct alignas(64) Contact {
    /// Sets no member. The code that makes a contact sets them all, except points beyond `count`, which are never read.
    Contact() {}

    std::uint32_t body_a, body_b; ///< rows of the body columns
    std::uint32_t memory;         ///< row of the contact columns; its points are these points
    std::uint32_t count;
    UnitVec3 normal;            ///< a to b
    Jacobian friction;          ///< combined coefficient
    Unit restitution;           ///< combined
    Unit rolling;               ///< combined rolling resistance [m]
    Speed tangent_1, tangent_2; ///< friction impulses of the last tick, as in ContactMemory
    Length twist;               ///< the same of the twist
    SpeedVec3 surface_velocity; ///< of b's surface relative to a's, world axes [m/s]
    std::array<ContactPoint, 4> points;
};
static_assert(sizeof(Contact) == 192);

/// The impulses that the points of a contact took in the elastic impacts of a tick.
struct ContactImpact {
    std::uint32_t contact;        ///< index of the Contact
    std::array<Speed, 4> impulse; ///< of points, divided by the reduced mass [m/s]
};

/// The part of a contact that the order of contacts and the islands read.
struct ContactHead {
    std::uint32_t body_a, body_b;
    std::uint32_t kind; ///< bits: ContactOrder::Kind, without `driven`
};

/// The two tangents of a normal. They depend on the normal alone and change little when it changes little. Friction is
/// remembered along them: if the frame turned by a right angle when a floor tilts by a rounding, that friction would
/// point aside.
struct Tangents {
    UnitVec3 first, second;
};
Tangents tangents_of(UnitVec3 normal);
/// The first tangent is `tangent_from`, turned as the pole turns to the normal. This does not hold where the normal is
/// nearly opposite the pole: n . pole below tangent_pole_limit. Both vectors have length 1. [Unit]
inline constexpr std::int32_t tangent_pole[3] = {306783378, 460175067, 920350134},
                              tangent_from[3] = {920350134, 306783378, -460175067};
inline constexpr std::int64_t tangent_pole_limit = -(std::int64_t{1} << 30) + (1 << 24);

} // namespace lockstone::solve
