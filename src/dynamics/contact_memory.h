// What a pair's manifolds keep of the tick before.
#pragma once

#include "dynamics/rows.h"

#include <cstdint>
#include <span>

namespace lockstone::dynamics {

/// What the fresh manifolds of a pair have taken: a bit for each old point, four a manifold, and one for its friction.
struct Taken {
    std::uint32_t points = 0, friction = 0;
};

/// Hands the impulses of a pair's old manifolds to a fresh one. A point takes those of the old point with its feature;
/// if there is none, those of the nearest old point that is left, if that is near. When two edges nearly coincide, the
/// feature of a corner flips from one body's to the other's while the corner stays: a tower that forgets those impulses
/// rocks. What is taken once is not taken again; friction goes with the first point.
/// Old manifolds whose normal differs by more than 20 degrees have nothing to give.
void carry_impulses(std::span<const ContactMemory> old, Taken& taken, ContactMemory& fresh);

/// How B has moved in A's frame since a manifold was made, to first order.
struct Shift {
    LengthVec3 moved; ///< [m]
    UnitVec3 turned;  ///< rotation vector [rad]
};

/// True when the shapes stand to each other as they did when the manifold was made, to within 0.1 mm for everything
/// within `reach` of B's origin, and nothing further away counts as near now: the manifold is good for this tick too.
bool still_good(const ContactMemory& memory, CoordinateVec3 position, Quat rotation, Coordinate reach,
                Length margin, Shift& shift);

/// Separation of a point of the manifold after the shift.
Separation separation_after(const ContactMemory& memory, std::uint32_t point, const Shift& shift);

} // namespace lockstone::dynamics
