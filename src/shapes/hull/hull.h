// Hulls from points: the exact surface, its faces, its mass.
#pragma once

#include "shapes/asset/asset.h"
#include "shapes/hull/convex_hull.h"

namespace lockstone::shapes {

/// The whole of a Hull follows from its corners, so assets hold nothing else. Refuses fewer than four points, points in one
/// plane, more than hull_vertices_max corners, corners further than 100 m from the origin along an axis, and hulls that
/// are thinner than 2 * shape_size_min across one of their triangles.
Result<Hull> make_hull(std::span<const LengthVec3> points);

/// Fills `faces`, `face_of`, `loops` and `edges` from `vertices`, `triangles` and `extent`. `thickness`: the least across a triangle.
/// Neighbouring facets become one face where all their corners lie within `face_tolerance` of one facet's plane.
void find_faces(Hull& hull, Length thickness);
/// Fills the patches of faces, from `faces`, `vertices` and `inner_radius`.
void find_patches(Hull& hull);
/// The depth of a patch: a 32nd of the inner radius, at most 0.49 mm. A corner within the outline may be below it by as much.
Length patch_depth(const Hull& hull);
/// Fills `first_face_at`, `faces_at` and `lanes` from `vertices`, `triangles` and `face_of`.
void index_corners(Hull& hull);
/// 2^-12 of the hull's size, at least 4 steps, at most an eighth of its thickness.
Length face_tolerance(const Hull& hull, Length thickness);

/// The least and the greatest n . v, 54 fraction bits: below 2^63 for |n| = 1 and vertices within 128 m on each axis.
struct Reach {
    std::int64_t low_54, high_54;
};
Reach reach_along(std::span<const LengthVec3> vertices, UnitVec3 n);

/// Volume, centre and gyration of a closed surface.
struct SurfaceMass {
    Scaled volume; ///< [m^3]
    Vec3 center;
    Matrix3<I20F44> gyration_squared;
};
SurfaceMass integrate(std::span<const LengthVec3> vertices,
                      std::span<const std::array<std::uint8_t, 3>> triangles);
SurfaceMass integrate(std::span<const LengthVec3> vertices,
                      std::span<const std::array<std::uint32_t, 3>> triangles);

/// A hull swollen by a polytope of 26 corners, each `factor` times the radius from its centre: with 1 the corners lie on
/// the ball.
ConvexSurface rounded_surface(const Hull& hull, Length radius, Real factor);
/// Of a hull swollen by a radius [m], by Steiner's formula [m^3].
Scaled rounded_volume(const Hull& hull, Scaled radius);
/// Of a hull swollen by `radius`: the volume by Steiner's formula; for centre and gyration the ball is taken as such a
/// polytope with the ball's volume, which is right to a percent.
SurfaceMass integrate_rounded(const Hull& hull, Length radius);

} // namespace lockstone::shapes
