// Pairs of shapes side by side in lanes: where B is in A's frame, whether the manifolds of the last tick serve again, and
// the contacts that come of them. The kernel of an instruction set is in src/solve/pairs.
#pragma once

#include "solve/contacts/contact.h"
#include "solve/contacts/contact_memory.h"

namespace lockstone::solve {

/// Six numbers, which lanes are filled with at once.
struct Six {
    std::int64_t v[3], u[3];
};

/// Two shapes that are near.
struct PairLane {
    Six way; ///< v: from A's origin to B's, u: from the centre of A's body to B's origin; world axes, 32 fraction bits
    Six kept; ///< v: of B's origin in A's frame when the manifolds were made; u: from the centre of B's body to B's origin; 24
    Six given; ///< v: of B's origin in A's frame, where `is_given`: of planes, along which nothing counts; 24
    const Quat *rotation_a, *rotation_b;     ///< A's and B's axes in the world
    const Quat* made_rotation;               ///< B's axes in A's, when the manifolds were made
    const Rotation* axes_a;                  ///< those of `rotation_a`
    const Velocity *velocity_a, *velocity_b; ///< of their bodies
    // Lengths with 24 fraction bits, and masks of 0 and -1.
    std::int32_t limit; ///< most that B may have moved for the manifolds to serve: recycling_limit()
    std::int32_t reach; ///< of B's points from its origin; below 128 m
    /// Between two bodies: points that would move further in half a tick stay where they are
    std::int32_t step_max;
    std::int32_t advances;  ///< mask: points are moved on to the middle of the tick
    std::int32_t on_ground; ///< mask: they go with B, not as the mean of both
    std::int32_t is_given;  ///< mask
    std::int32_t unused[2];
};

/// A lane: a pair, and one of its manifolds where it has some.
struct PairRow {
    const PairLane* pair;
    const ContactMemory* memory;
};

/// What a kernel finds.
struct PairPlace {
    /// Of B's origin in A's frame [m], 24 fraction bits; relative_position_max: too far away
    std::int64_t position[3];
    Quat rotation; ///< B's axes in A's
};
/// A manifold that serves, as the solver wants it.
struct PairContact {
    UnitVec3 normal; ///< from A to B, world axes
    std::int32_t unused;
    std::array<ContactPoint, 4> points; ///< without impulses
};

/// What is asked for.
enum class PairWork : std::uint8_t {
    place,   ///< where B is
    recycle, ///< that, whether the manifold of the last tick serves, and its contact
    fresh,   ///< the contact of a manifold that was made just now
};

struct PairPass {
    PairWork work;
    const PairRow* rows;
    std::uint32_t count;
    Unit half_tick;       ///< [s]
    PairPlace* place;     ///< by row
    PairContact* contact; ///< by row, of manifolds that serve
    /// By row: 1 where B has moved by no more than the limit, and all that a lane holds fits
    std::uint8_t* serves;
};

/// All rows of a pass.
struct PairKernel {
    void (*find)(const PairPass& pass);
};

} // namespace lockstone::solve
