// Contacts as the narrow phase leaves them. src/solve/contacts solves them.
#pragma once

#include "solve/bodies/rows.h"

#include <array>

namespace lockstone::solve {

/// A contact as the narrow phase leaves it, in world axes; levers are from each body's centre of mass. Two rows of four, as lanes
/// read and write them.
struct ContactPoint {
    LengthVec3 lever_a;    ///< [m]
    Separation separation; ///< [m]
    LengthVec3 lever_b;    ///< [m]
    Speed impulse;         ///< that the last tick remembered: ContactPointMemory::normal
};
/// Three cache lines with all that the solver needs to prepare a contact: it takes contacts in an order of its own, so anything kept elsewhere
/// would be far apart in memory.
struct alignas(64) Contact {
    Contact() {
    } ///< nothing is set: whoever makes one fills it in, but for points beyond `count`, which nobody uses

    std::uint32_t body_a, body_b; ///< rows of the body columns
    std::uint32_t memory;         ///< row of the contact columns; its points are these points
    std::uint32_t count;
    UnitVec3 normal;            ///< a to b
    Jacobian friction;          ///< combined coefficient
    Unit restitution;           ///< combined
    Unit rolling;               ///< combined rolling resistance [m]
    Speed tangent_1, tangent_2; ///< friction that the last tick remembered, as in ContactMemory
    Length twist;               ///< likewise
    SpeedVec3 surface_velocity; ///< of b's surface against a's, world axes [m/s]
    std::array<ContactPoint, 4> points;
};
static_assert(sizeof(Contact) == 192);

/// All that the order of contacts and islands ask of one.
struct ContactHead {
    std::uint32_t body_a, body_b;
    std::uint32_t kind; ///< bits: ContactOrder::Kind, but for `driven`
};

/// The two tangents of a normal: the same for the same normal, and nearly the same for nearly the same. Friction is
/// remembered along them. If the frame turned by a right angle when a floor tilts by a rounding, that friction would point aside.
struct Tangents {
    UnitVec3 first, second;
};
Tangents tangents_of(UnitVec3 normal);
/// The first tangent is `tangent_from` turned as the pole turns to the normal, unless that is nearly its opposite: n . pole below
/// the limit. Both have length 1. [Unit]
inline constexpr std::int32_t tangent_pole[3] = {306783378, 460175067, 920350134},
                              tangent_from[3] = {920350134, 306783378, -460175067};
inline constexpr std::int64_t tangent_pole_limit = -(std::int64_t{1} << 30) + (1 << 24);

} // namespace lockstone::solve
