// Detects shapes that pass each other. Example: a ball rolls over the joint of two flush boxes. The contact normal at
// the edge of the second box points against the ball's motion, like that of a wall, but the ball passes above it.
#pragma once

#include "collide/narrow_phase.h"
#include "lockstone/math/math.h"
#include "scene/placed_shapes.h"

#include <algorithm>

namespace lockstone::sim {

/// The motion of a shape within a tick, in the axes of the other shape's body.
struct PassingWay {
    SpeedVec3 velocity; ///< of its origin [m/s]
    SpeedVec3 turning;  ///< [rad/s]
    Length rim; ///< radius of the points that its rotation moves, about its origin, without its rounding [m]
};

/// The radius of the points of a shape that its rotation moves. Zero for a sphere; for a capsule the half length of
/// its segment.
inline Length rim_of(const PlacedShapes::Shape& shape) {
    const Geometry& g = shape.solid.geometry;
    if (g.kind == ShapeKind::sphere) return {};
    if (g.kind == ShapeKind::capsule) return g.half_extent.y;
    return shape.reach > Coordinate(128) ? Length::max() : to<Length>(shape.reach);
}

/// Returns true if B passes A within the tick and does not enter it deeper than `graze`. That is so if a direction at
/// right angles to their relative motion separates the two now: straight motion keeps the distance along that
/// direction, so it separates them until the tick ends. The function tries the parts of `normal` (of their manifold,
/// in A's axes) and of the axes of both shapes that are at right angles to the motion.
/// Returns false if it finds no such direction, for kinds that collide::are_parted() does not support, and for motion
/// that closes by less than `graze`: then B slides along A, and the manifold carries it.
inline bool pass_each_other(const collide::PlacedSolid& a, const collide::PlacedSolid& b, UnitVec3 normal,
                            const PassingWay& way, Length graze, Unit half_tick) {
    constexpr Unit head_on = decimal<Unit>("0.06"); // the sine of the angle between motion and direction
    constexpr Length spare_of_parting = decimal<Length>("0.001");
    const Real time = to<Real>(half_tick) * Real(2);
    const UnitVec3 ahead = mul_transposed<Unit>(a.axes, normalized(way.velocity));
    const Unit along = dot<Unit>(normal, ahead);
    if (to<Real>(-along) * to<Real>(length(way.velocity)) * time < to<Real>(graze)) return false;
    const auto parts = [&](UnitVec3 direction) {
        const UnitVec3 across = direction - scale<Unit>(ahead, dot<Unit>(direction, ahead));
        if (length(across) < head_on) return false;
        const UnitVec3 outward = dot<Unit>(across, normal) < Unit{} ? -across : across,
                       parting = normalized(outward);
        const Speed turns = length(cross<Speed>(lockstone::mul<Unit>(a.axes, parting), way.turning));
        const Real turned = to<Real>(turns) * to<Real>(way.rim) * time;
        return turned < Real(1) &&
               collide::are_parted(a, b, parting, to<Length>(turned) - graze - spare_of_parting);
    };
    if (parts(normal)) return true;
    const auto in_a = [&](UnitVec3 direction) { return mul_transposed<Unit>(a.axes, direction); };
    const auto has_faces = [](const collide::PlacedSolid& s) {
        return s.solid.geometry.kind >= ShapeKind::cylinder;
    };
    for (const collide::PlacedSolid* s : {&a, &b})
        if (has_faces(*s) && (parts(in_a(s->axes.y)) || parts(in_a(s->axes.x)) || parts(in_a(s->axes.z))))
            return true;
    return false;
}

} // namespace lockstone::sim
