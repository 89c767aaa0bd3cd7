// Drops contact points that are too far apart to touch within the tick.
#pragma once

#include "collide/narrow_phase.h"
#include "scene/placed_shapes.h"

namespace lockstone::sim {

/// The motion of the body of the narrow phase's B relative to that of A, world axes.
struct PairMotion {
    SpeedVec3 at_b;    ///< at B's origin [m/s]
    SpeedVec3 turning; ///< [rad/s]

    PairMotion(const Velocity& a, const Velocity& b, LengthVec3 from_a, LengthVec3 from_b)
        : at_b((b.linear + cross<Speed>(b.angular, from_b)) - (a.linear + cross<Speed>(a.angular, from_a))),
          turning(b.angular - a.angular) {}
};

/// Points within this separation are always kept.
inline constexpr Separation kept_always = to<Separation>(margin_least);

inline bool has_far_points(const collide::Manifold& manifold) {
    bool is_far = false;
    for (std::uint32_t k = 0; k < manifold.count; ++k)
        is_far = is_far || manifold.points[k].separation > kept_always;
    return is_far;
}

/// Moves the points of a gap onto the surface of B (`on_b`) or of A, from the middle of the gap. The gap may be wider than
/// a thin shape is thick. A lever to the middle of the gap then gives friction an arm about the long axis that the body
/// does not have, and a pole whose end reaches the floor within a tick spins about its axis with many times its energy.
inline void put_on_surface(bool on_b, collide::Manifold& manifold) {
    for (std::uint32_t k = 0; k < manifold.count; ++k) {
        collide::ManifoldPoint& point = manifold.points[k];
        if (point.separation <= Separation{}) continue;
        const Separation by = on_b ? half(point.separation) : -half(point.separation);
        for (int axis = 0; axis < 3; ++axis)
            point.position[axis] += to<Length>(mul<Separation>(by, manifold.normal[axis]));
    }
}

template <class Keeps> void keep_points(collide::Manifold& manifold, const Keeps& keeps) {
    std::uint32_t kept = 0;
    for (std::uint32_t k = 0; k < manifold.count; ++k) {
        const collide::ManifoldPoint point = manifold.points[k];
        if (keeps(point)) manifold.points[kept++] = point;
    }
    while (manifold.count > kept) manifold.points[--manifold.count] = {};
}

/// Keeps the points of a manifold that are within `margin_least`, or farther by no more than they close within a tick
/// with the velocities at its begin: n . (v + w x r) is n . v + (n x w) . r. (`level` and `tilt` in the code are the
/// two terms n . v and n x w.) The margin of a pair covers motion in any direction, so most points of shapes that
/// slide along each other or move apart are of no use.
/// The second-order term of a rotation, w^2 r t^2 / 2, points towards the body's own centre, so it moves convex
/// shapes apart; gravity adds 1.4 mm in a sixtieth of a second.
inline void keep_closing_points(const PairMotion& motion, const Rotation& axes_a, Unit half_tick,
                                collide::Manifold& manifold) {
    const UnitVec3 normal = lockstone::mul<Unit>(axes_a, manifold.normal);
    const Speed level = dot<Speed>(motion.at_b, normal);
    const SpeedVec3 tilt = mul_transposed<Speed>(axes_a, cross<Speed>(normal, motion.turning));
    constexpr int coarser = Speed::fraction_bits + Unit::fraction_bits - 1 - Separation::fraction_bits;
    keep_points(manifold, [&](const collide::ManifoldPoint& point) {
        const std::int64_t parts = std::int64_t{level.raw} + dot<Speed>(tilt, point.position).raw,
                           closes = std::max<std::int64_t>(-parts, 0) * half_tick.raw >> coarser;
        return point.separation.raw <= kept_always.raw + closes;
    });
}

/// Does this for all manifolds of a pair. If two convex shapes keep no point, their normal becomes the hint for the
/// next tick.
inline void keep_closing_points(const PairMotion& motion, const Rotation& axes_a, Unit half_tick,
                                bool are_convex, collide::Manifolds& manifolds) {
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < manifolds.count; ++i) {
        keep_closing_points(motion, axes_a, half_tick, manifolds.items[i]);
        if (manifolds.items[i].count == 0) continue;
        if (kept != i) manifolds.items[kept] = manifolds.items[i];
        ++kept;
    }
    if (kept == 0 && manifolds.count != 0 && are_convex) manifolds.apart = manifolds.items[0].normal;
    manifolds.count = kept;
}

/// Keeps the points of two convex shapes whose separation is at most `separation`. Sets the same hint.
inline void keep_deep_points(collide::Manifolds& manifolds, Separation separation) {
    keep_points(manifolds.items[0],
                [&](const collide::ManifoldPoint& point) { return point.separation <= separation; });
    if (manifolds.items[0].count != 0) return;
    manifolds.apart = manifolds.items[0].normal;
    manifolds.count = 0;
}

} // namespace lockstone::sim
