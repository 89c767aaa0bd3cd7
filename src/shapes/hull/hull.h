// Makes hulls from points: the exact surface, its faces, its mass.
#pragma once

#include "shapes/asset/asset.h"
#include "shapes/hull/convex_hull.h"

namespace lockstone::shapes {

/// Makes a Hull from points; it depends on the corners only, so assets store nothing else. Errors: fewer than
/// four points, points in one plane, more than hull_vertices_max corners, corners further than 100 m from the
/// origin along an axis, and hulls thinner than 2 * shape_size_min across one of their triangles.
Result<Hull> make_hull(std::span<const LengthVec3> points);

/// Fills `faces`, `face_of`, `loops` and `edges` from `vertices`, `triangles` and `extent`. `thickness`: the
/// least thickness across a triangle. Merges neighbouring facets into one face where all their corners are
/// within `face_tolerance` of one facet's plane.
void find_faces(Hull& hull, Length thickness);
/// Fills the patches of the faces from `faces`, `loops`, `vertices` and `inner_radius`.
void find_patches(Hull& hull);
/// The depth of a patch: 1/32 of the inner radius, at most 0.49 mm. A corner inside the outline may be below
/// its face by as much.
Length patch_depth(const Hull& hull);
/// Fills `first_face_at`, `faces_at` and `lanes` from `vertices`, `triangles` and `face_of`.
void index_corners(Hull& hull);
/// 2^-12 of the hull's size, at least 4 steps, at most an eighth of its thickness.
Length face_tolerance(const Hull& hull, Length thickness);

/// The least and the greatest n . v, 54 fraction bits. Below 2^63 for |n| = 1 and vertices within 128 m on each
/// axis.
struct Reach {
    std::int64_t low_54, high_54;
};
Reach reach_along(std::span<const LengthVec3> vertices, UnitVec3 n);

/// Volume, centre and squared gyration radii of a closed surface.
struct SurfaceMass {
    Scaled volume; ///< [m^3]
    Vec3 center;
    Matrix3<I20F44> gyration_squared;
};
SurfaceMass integrate(std::span<const LengthVec3> vertices,
                      std::span<const std::array<std::uint8_t, 3>> triangles);
SurfaceMass integrate(std::span<const LengthVec3> vertices,
                      std::span<const std::array<std::uint32_t, 3>> triangles);

/// The hull grown by a polytope with 26 corners, each at `factor` times the radius from its centre. With factor
/// 1 the corners are on the ball.
ConvexSurface rounded_surface(const Hull& hull, Length radius, Real factor);
/// Volume of a hull grown by a radius [m], by Steiner's formula [m^3].
Scaled rounded_volume(const Hull& hull, Scaled radius);
/// Mass properties of a hull grown by `radius`. The volume is from Steiner's formula. Centre and gyration use
/// the polytope above, with the ball's volume, in place of the ball; their error is about a percent.
SurfaceMass integrate_rounded(const Hull& hull, Length radius);

} // namespace lockstone::shapes
