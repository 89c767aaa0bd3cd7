// Queries: ray casts, shape casts, overlaps and distances. They change no state.
//
//   if (auto hit = world.cast_ray({eye, 50_r * forward})) aim_at(hit->point);
//   std::vector<QueryHit> hits;
//   world.cast_ray_all({eye, 50_r * forward}, {.mask = enemies}, hits);   sorted by distance, id, feature
//
// Results are pure functions of the state in a total order. Commands since the last tick are taken into
// account. Each shape gives at most one hit, its first.
//
// A query with an invalid argument returns an empty result: a translation longer than query_length_max, a
// geometry that validate() refuses or without its asset, a mesh, height field or plane as the moving
// geometry, a dead id. Rotations are normalised first.
//
// Meshes and height fields are surfaces; of a one-sided triangle (all of a height field) only the front is
// hit. Planes and convex shapes are solid: a cast that starts inside hits at once, with fraction 0 and a zero
// normal.
#pragma once

#include "lockstone/command.h"

namespace lockstone {

inline constexpr Real query_length_max = Real(16000); ///< limit of casts and distances [m]

/// Selects the shapes of a query. Groups and pair filters do not apply.
struct QueryFilter {
    /// Category bits of the query: a shape is included if its mask and this have a common bit, and `mask` and
    /// its category too.
    std::uint32_t category = 0xffffffffu;
    std::uint32_t mask = 0xffffffffu; ///< category bits of shapes to include
    std::uint32_t kinds = 7;          ///< included bodies: bit 0 static, bit 1 kinematic, bit 2 dynamic
    std::uint32_t sensors = 0;        ///< 1: includes sensors
    BodyId ignore{};                  ///< excludes the shapes of this body; null: none
    /// 0: a cast ignores each shape that it overlaps at its start, even if it would later hit another part of
    /// it.
    std::uint32_t overlaps = 1;
};

/// A ray segment.
struct Ray {
    Vec3 from;        ///< start, world [m]
    Vec3 translation; ///< from start to end [m], at most query_length_max long; zero: a point test
};

/// A hit of a cast, or the nearest point of World::nearest().
struct QueryHit {
    ShapeId shape; ///< the shape that is hit
    BodyId body;   ///< its body
    /// casts: travelled distance [m]; nearest(): gap between the surfaces [m], 0: overlap
    Real distance;
    Unit fraction;         ///< casts: travelled part of the translation, 0..1; nearest(): 0
    Vec3 point;            ///< on the surface of the shape, world [m]
    UnitVec3 normal;       ///< surface normal of the shape; zero: overlap at the start
    std::uint32_t feature; ///< triangle index of the baked mesh or height field, part of a compound, else 0
    SurfacePart part;      ///< source triangle or cell, and material
};

/// Nearest points of two shapes.
struct ShapeDistance {
    Real distance;   ///< [m]; 0: overlap
    Vec3 on_a,       ///< nearest point on a, world [m]
        on_b;        ///< nearest point on b, world [m]; equal to on_a if they overlap
    UnitVec3 normal; ///< from a to b; zero: overlap
};

/// Order of hits: by distance, shape id, feature.
constexpr bool operator<(const QueryHit& a, const QueryHit& b) {
    if (a.distance != b.distance) return a.distance < b.distance;
    if (a.shape != b.shape) return a.shape < b.shape;
    return a.feature < b.feature;
}

} // namespace lockstone
