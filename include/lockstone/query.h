// Questions to a world that change nothing: casts, overlaps, distances.
//
//   if (auto hit = world.cast_ray({eye, 50_r * forward})) aim_at(hit->point);
//   std::vector<QueryHit> hits;
//   world.cast_ray_all({eye, way}, {.mask = enemies}, hits);           sorted by distance, then shape id, then feature
//
// Answers are pure functions of the state and come in a total order. They see the world as it is between ticks:
// commands since the last tick count. Each shape gives one hit, its first.
//
// What makes no sense gets an empty answer: a way longer than query_length_max, a geometry that `validate` refuses or whose
// asset is not there, one with triangles or a plane as what is cast, dead ids. A rotation is normalised first.
//
// Of a mesh or height field only the surface counts, and of a one-sided triangle (all those of height fields) only the front.
// Planes and convex shapes are solid: what starts inside hits at once, with fraction 0 and a zero normal.
#pragma once

#include "lockstone/command.h"

namespace lockstone {

inline constexpr Real query_length_max = Real(16000); ///< [m]

struct QueryFilter {
    std::uint32_t category =
        0xffffffffu; ///< a shape is seen when (category & shape.mask) and (mask & shape.category)
    std::uint32_t mask = 0xffffffffu;
    std::uint32_t kinds = 7;   ///< bit 0: static, 1: kinematic, 2: dynamic bodies
    std::uint32_t sensors = 0; ///< 1: sensors are seen too
    BodyId ignore{};           ///< this body's shapes are not seen
    /// 0: a cast does not see a shape that it overlaps where it starts, even where its way leads into another part of that shape
    std::uint32_t overlaps = 1;
};

struct Ray {
    Vec3 from;        ///< world [m]
    Vec3 translation; ///< to the end [m], at most query_length_max long; zero asks what is at the point
};

struct QueryHit {
    ShapeId shape;
    BodyId body;
    Real distance;   ///< casts: travelled [m]; nearest points: between the surfaces, 0 when they overlap
    Unit fraction;   ///< casts: of the translation
    Vec3 point;      ///< on the shape's surface, world [m]
    UnitVec3 normal; ///< of the shape's surface; zero when they overlap at the start
    std::uint32_t feature; ///< triangle of a mesh or height field as baked, part of a compound, else 0
    SurfacePart part;
};

/// Where two shapes are nearest to each other.
struct ShapeDistance {
    Real distance;   ///< [m]; 0 when they overlap
    Vec3 on_a, on_b; ///< world [m]; the same point when they overlap
    UnitVec3 normal; ///< from a to b; zero when they overlap
};

/// Order of several hits: distance, shape id, feature.
constexpr bool operator<(const QueryHit& a, const QueryHit& b) {
    if (a.distance != b.distance) return a.distance < b.distance;
    if (a.shape != b.shape) return a.shape < b.shape;
    return a.feature < b.feature;
}

} // namespace lockstone
