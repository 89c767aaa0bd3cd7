// Rays and moving shapes against solids, distances, and the time of impact of two moving shapes.
//
// A distance travelled has 30 fraction bits inside and 24 in what comes out. Of meshes and height fields only the
// surface counts: a one-sided triangle (of a height field: every one) is met from its front alone.
#pragma once

#include "collide/narrow_phase.h"
#include "shapes/mesh/face.h"

#include <vector>

namespace lockstone::collide {

/// The longest way of a ray or a cast shape [m]; a longer one meets nothing.
inline constexpr Coordinate cast_length_max = Coordinate(16384);

/// Where a ray or a cast shape meets a solid first. In the solid's frame.
struct CastHit {
    Coordinate distance;   ///< travelled [m]
    Unit fraction;         ///< of the translation, 0..1; 0 with a zero normal: they overlap at the start
    CoordinateVec3 point;  ///< on the solid's surface, in its axes from its origin [m]
    UnitVec3 normal;       ///< of the solid's surface, against the motion
    std::uint32_t feature; ///< triangle index or part index; 0
};

/// A ray from `from` along `translation`, both in the solid's frame. A ray that starts inside a convex solid or a plane
/// hits at once, with a zero normal. Sphere, capsule, cylinder, box, plane: closed forms; cone, hull and rounded shapes:
/// Newton's method from outside; triangles: exact predicates, so a ray through a shared edge or corner never slips
/// through. The surface is met within 1e-7 m, of hulls and rounded shapes 1 um, and 4e-9 of the solid's size.
bool cast_ray(const shapes::Solid& solid, CoordinateVec3 from, CoordinateVec3 translation,
              NarrowScratch& scratch, CastHit& hit);

/// A solid without triangles, `moving`, at `pose` (its frame seen from the other's) that moves by `translation` without
/// turning. The surfaces are within 2 um of each other at the hit.
bool cast_shape(const shapes::Solid& solid, const shapes::Solid& moving, const RelativePose& pose,
                CoordinateVec3 translation, NarrowScratch& scratch, CastHit& hit);
struct Line; // cast_line.h
/// The same along a line's way, wherever the line begins.
bool cast_shape(const shapes::Solid& solid, const shapes::Solid& moving, const RelativePose& pose,
                const Line& way, NarrowScratch& scratch, CastHit& hit);
/// The triangles of a solid around a place, kept by one who casts a ball thereabouts again and again. Changes speed only.
struct NearFaces {
    struct Entry {
        shapes::Extent box;
        shapes::Face face;
    };
    Geometry of{}; ///< of the solid, whose asset is named by its content; of a ball: nothing is kept
    shapes::Extent within{};  ///< all whose boxes meet this are kept...
    bool too_many = false;    ///< ... but for these
    std::vector<Entry> faces; ///< ascending
};
/// The same of a ball, along a line in the frame of a solid that has triangles. `near` may be null.
bool cast_ball(const shapes::Solid& solid, const Line& line, std::int64_t radius_24, NearFaces* near,
               NarrowScratch& scratch, CastHit& hit);

/// Nearest points of two solids, at most one of them with triangles or a plane. False when further apart than `limit`.
struct Nearest {
    Coordinate distance;       ///< [m]; 0 when they overlap
    CoordinateVec3 on_a, on_b; ///< in A's frame
    UnitVec3 normal;           ///< from A to B; zero when they overlap
    std::uint32_t feature_a;   ///< triangle or part of A, 0
};
bool nearest_points(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                    Coordinate limit, NarrowScratch& scratch, Nearest& out);

/// One body's way through a tick: from one pose of its centre of mass to another at constant speed.
struct Sweep {
    Transform from, to; ///< world poses of the centre of mass; the rotation follows the shorter arc (nlerp)
    Transform local;    ///< the shape's frame from the centre of mass, in the body's axes
};
/// The body's pose at `fraction` of the way; exactly `from` at 0 and `to` at 1.
Transform body_pose_at(const Sweep& sweep, Unit fraction);
/// The shape's pose at `fraction` of the way.
Transform pose_at(const Sweep& sweep, Unit fraction);

/// The first fraction of the way at which the shapes are `target` apart, by conservative advancement; 1 when never.
/// A pair that starts nearer than `target` gives 0. The result is never later than the true time; the shapes do not
/// overlap at it by more than the rounding.
/// source: Mirtich, Impulse-based Dynamic Simulation, 1996; Catto, Continuous Collision, GDC 2013.
Unit time_of_impact(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b,
                    const Sweep& sweep_b, Length target, NarrowScratch& scratch);

// ---- what stops a fast body ----

/// A shape stops this far from what it hits [m].
inline constexpr Length stop_gap = decimal<Length>("0.002");
/// What a touching body slides on is this much lower for it [m]: so it does not stop at the seams of what it slides on, nor
/// at steps lower than this.
inline constexpr Length seam_height = decimal<Length>("0.006");

/// A limb that is stopped is torn from its joints. So a body that joints hold may enter what it meets, as long as contacts push it out to the
/// side that it came from.
enum class Held : std::uint8_t { not_at_all, by_joints };

/// Appends the directions, in world axes from A to B, in which pieces of A are nearer than stop_gap to B at the start.
void touching_directions(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b,
                         const Sweep& sweep_b, NarrowScratch& scratch, std::vector<UnitVec3>& directions);

/// The fraction of the way at which A stops B, 1 when it does not; never late. For each convex part of B and each piece
/// (part, triangle) of A:
///   apart by more than stop_gap at the start: where the shape comes within stop_gap. A shape that touches something
///     (`touching`) is lifted off it by seam_height, and passes if it meets nothing then. A rounded shape passes, too, that
///     never enters by half of its rounding: contacts push it out.
///   nearer, or passed: where its core, a ball of half its inner radius, comes within stop_gap or half of its distance at
///     the start; where the core overlaps the piece at the start, the same of the core's centre.
/// A body that joints hold is stopped where its core's centre would come within stop_gap, or half of its distance at the start. A plane or a
/// box (not one of a compound) does not stop it where the centre ends no deeper than the inner radius, in front of the middle of the box.
/// One-sided triangles do not stop what starts behind them.
Unit stop_fraction(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b, const Sweep& sweep_b,
                   std::span<const UnitVec3> touching, Held held, NarrowScratch& scratch);

/// Of two bodies' ways: a bound of how far any point of B, within `reach` of B's centre of mass, moves against A [m].
Real relative_motion(const Sweep& a, const Sweep& b, Real reach);

} // namespace lockstone::collide
