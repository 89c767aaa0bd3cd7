// Pairs of shapes side by side in lanes: the pose of B in A's frame, the test whether the manifolds of the last tick
// are recycled, and their contacts. The kernel of an instruction set is in src/solve/pairs.
#pragma once

#include "solve/contacts/contact.h"
#include "solve/contacts/contact_memory.h"

namespace lockstone::solve {

/// Six numbers that lanes load at once.
struct Six {
    std::int64_t v[3], u[3];
};

/// Two shapes that are near each other.
struct PairLane {
    /// v: from A's origin to B's origin; u: from the centre of A's body to B's origin; world axes, 32 fraction bits
    Six way;
    /// v: position of B's origin in A's frame when the manifolds were made; u: from the centre of B's body to B's
    /// origin; 24 fraction bits
    Six kept;
    /// v: position of B's origin in A's frame, if `is_given`: of planes, along which positions do not matter; 24
    /// fraction bits
    Six given;
    const Quat *rotation_a, *rotation_b;     ///< A's and B's axes in the world
    const Quat* made_rotation;               ///< B's axes in A's frame when the manifolds were made
    const Rotation* axes_a;                  ///< the matrix of `rotation_a`
    const Velocity *velocity_a, *velocity_b; ///< of their bodies
    // Lengths with 24 fraction bits, and masks of 0 and -1.
    std::int32_t limit; ///< largest u of B's move at which the manifolds are recycled: recycling_limit()
    std::int32_t reach; ///< largest distance of B's points from its origin, below 128 m
    /// Between two bodies: points that would move farther than this in half a tick stay where they are
    std::int32_t step_max;
    std::int32_t advances;  ///< mask: points are moved to the middle of the tick
    std::int32_t on_ground; ///< mask: points move with B, and not with the mean of both bodies
    std::int32_t is_given;  ///< mask: `given` is set
    std::int32_t unused[2];
};

/// A lane: a pair, and one of its manifolds if it has any.
struct PairRow {
    const PairLane* pair;
    const ContactMemory* memory;
};

/// The pose that a kernel computes.
struct PairPlace {
    /// Position of B's origin in A's frame [m], 24 fraction bits; relative_position_max means too far away
    std::int64_t position[3];
    Quat rotation; ///< B's axes in A's frame
};
/// A recycled or fresh manifold in the form of the solver.
struct PairContact {
    UnitVec3 normal; ///< from A to B, world axes
    std::int32_t unused;
    std::array<ContactPoint, 4> points; ///< without impulses
};

/// The outputs that a pass computes.
enum class PairWork : std::uint8_t {
    place,   ///< the pose of B
    recycle, ///< the pose, the test whether the manifold of the last tick is recycled, and its contact
    fresh,   ///< the contact of a manifold that was made in this tick
};

struct PairPass {
    PairWork work;
    const PairRow* rows;
    std::uint32_t count;
    Unit half_tick;       ///< [s]
    PairPlace* place;     ///< by row
    PairContact* contact; ///< by row, where `serves` is 1
    /// By row: 1 where the manifold is recycled: B has moved by at most the limit, and all numbers of the lane have
    /// room
    std::uint8_t* serves;
};

/// The kernel handles all rows of a pass.
struct PairKernel {
    void (*find)(const PairPass& pass);
};

} // namespace lockstone::solve
