// Casts of rays and of moving shapes against solids, distances, and the time of impact of two moving shapes.
//
// Distances along a cast have 30 fraction bits inside and 24 in results. Meshes and height fields count as
// surfaces only: a one-sided triangle (in a height field every triangle) is hit from its front only.
#pragma once

#include "collide/narrow_phase.h"
#include "shapes/mesh/face.h"

#include <vector>

namespace lockstone::collide {

/// The longest path of a ray or a cast shape [m]; a longer one hits nothing.
inline constexpr Coordinate cast_length_max = Coordinate(16384);

/// The first hit of a ray or a cast shape on a solid, in the solid's frame.
struct CastHit {
    Coordinate distance;   ///< along the path from its start [m]
    Unit fraction;         ///< of the translation, 0..1; 0 with a zero normal: they overlap at the start
    CoordinateVec3 point;  ///< on the solid's surface, in its axes from its origin [m]
    UnitVec3 normal;       ///< of the solid's surface, opposed to the motion
    std::uint32_t feature; ///< index of the triangle or of the part; else 0
};

/// Casts a ray from `from` along `translation`, both in the solid's frame. A ray that starts inside a convex
/// solid or below a plane hits at once, with a zero normal. Spheres, capsules, cylinders, boxes and planes have
/// closed forms. Cones, hulls and rounded shapes use Newton's method from outside. Triangles use exact
/// predicates, so a ray through a shared edge or corner never slips through. The point is within 1e-7 m of the
/// surface (1 um for hulls and rounded shapes) plus 4e-9 of the solid's size. Returns false and leaves `hit`
/// undefined when nothing is hit.
bool cast_ray(const shapes::Solid& solid, CoordinateVec3 from, CoordinateVec3 translation,
              NarrowScratch& scratch, CastHit& hit);

/// Casts `moving`, a solid without triangles, along `translation` without rotation. `pose`: its frame in the
/// other solid's frame. The surfaces are within 2 um of each other at the hit.
bool cast_shape(const shapes::Solid& solid, const shapes::Solid& moving, const RelativePose& pose,
                CoordinateVec3 translation, NarrowScratch& scratch, CastHit& hit);
struct Line; // cast_line.h
/// As above, with the translation of `way`; its start is replaced by `pose`.
bool cast_shape(const shapes::Solid& solid, const shapes::Solid& moving, const RelativePose& pose,
                const Line& way, NarrowScratch& scratch, CastHit& hit);
/// Cache of the triangles near a place, for a caller that casts a ball there many times. Changes speed only.
struct NearFaces {
    struct Entry {
        shapes::Extent box;
        shapes::Face face;
    };
    /// The geometry that the cache is for; a content hash names its asset. Kind ball: the cache is empty.
    Geometry of{};
    shapes::Extent within{};  ///< the cache holds all triangles whose boxes meet this...
    bool too_many = false;    ///< ... unless there are too many: then it holds none
    std::vector<Entry> faces; ///< in ascending order of index
};
/// Casts a ball along a line in the frame of a solid with triangles. `near` may be null.
bool cast_ball(const shapes::Solid& solid, const Line& line, std::int64_t radius_24, NearFaces* near,
               NarrowScratch& scratch, CastHit& hit);

/// Nearest points of two solids. nearest_points returns false when they are further apart than `limit` [m], and for
/// a B that has triangles or is a plane; A may be any solid.
struct Nearest {
    Coordinate distance;       ///< [m]; 0 when they overlap
    CoordinateVec3 on_a, on_b; ///< in A's frame
    UnitVec3 normal;           ///< from A to B; zero when they overlap
    std::uint32_t feature_a;   ///< index of the triangle or part of A; else 0
};
bool nearest_points(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                    Coordinate limit, NarrowScratch& scratch, Nearest& out);

/// The motion of one body through a tick: from one pose of its centre of mass to another at constant speed.
struct Sweep {
    Transform from, to; ///< world poses of the centre of mass; the rotation follows the shorter arc (nlerp)
    Transform local;    ///< pose of the shape in the frame of the centre of mass, in the body's axes
};
/// The body's pose at `fraction` of the motion; exactly `from` at 0 and `to` at 1.
Transform body_pose_at(const Sweep& sweep, Unit fraction);
/// The shape's pose at `fraction` of the motion.
Transform pose_at(const Sweep& sweep, Unit fraction);

/// The first fraction of the motion at which the shapes are `target` apart, by conservative advancement; 1 when
/// there is none. Returns 0 for a pair that starts nearer than `target`. The result is never later than the
/// true time: at that time the shapes overlap by at most the rounding.
/// source: Mirtich, Impulse-based Dynamic Simulation, 1996; Catto, Continuous Collision, GDC 2013.
Unit time_of_impact(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b,
                    const Sweep& sweep_b, Length target, NarrowScratch& scratch);

// ---- continuous collision: where a fast body stops ----

/// A stopped shape keeps this distance from the shape that it hits [m].
inline constexpr Length stop_gap = decimal<Length>("0.002");
/// A body that touches a surface is lifted by this height for the test [m]: so it does not stop at the seams of
/// the surface on which it slides, nor at steps lower than this.
inline constexpr Length seam_height = decimal<Length>("0.006");

/// A limb that is stopped would be torn from its joints. A body held by joints may therefore enter another
/// shape, as long as contacts push it out to the side from which it came.
enum class Held : std::uint8_t { not_at_all, by_joints };

/// Appends the directions, in world axes from A to B, along which pieces of A are nearer than 1.25 stop_gap to B
/// at the start.
void touching_directions(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b,
                         const Sweep& sweep_b, NarrowScratch& scratch, std::vector<UnitVec3>& directions);

/// The fraction of the motion at which A stops B; 1 when A does not stop B; never later than the true fraction.
/// For each convex part of B and each piece (part or triangle) of A:
/// * When they start apart by more than 1.25 stop_gap, B stops where it comes within stop_gap. Two exceptions:
///   a shape that touches others (`touching`) passes if it meets nothing when lifted off them by seam_height; a
///   rounded shape passes if it never enters the piece by half of its rounding, because contacts push it out.
/// * When they start nearer, or the shape passes, B stops where its core comes within stop_gap, or within half
///   of the core's distance at the start if that is less. The core is a ball of half the inner radius; where it
///   overlaps the piece at the start, the point at its centre.
///
/// A body held by joints stops where its core's centre would come within stop_gap or half of its distance at the
/// start. A plane or a box (except in a compound) does not stop it when the centre starts outside, ends no deeper
/// than the inner radius, and ends on the same side of the box's middle. One-sided triangles do not stop shapes
/// that start behind them.
Unit stop_fraction(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b, const Sweep& sweep_b,
                   std::span<const UnitVec3> touching, Held held, NarrowScratch& scratch);

/// A bound of how far any point of B within `reach` of B's centre of mass moves relative to A [m].
Real relative_motion(const Sweep& a, const Sweep& b, Real reach);

} // namespace lockstone::collide
