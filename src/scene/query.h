// Queries of a world, and the scratch memory that is kept between them.
//
// Thread-safe: several threads may query at once. One of them updates the caches to the state, behind a lock, and
// each query has its own scratch memory. Kept memory changes no result.
#pragma once

#include "base/lock.h"
#include "collide/query/cast.h"
#include "lockstone/query.h"
#include "scene/placed_shapes.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace lockstone::sim {

/// Scratch memory of one query.
struct QueryWork {
    collide::BroadPhase::Asker near; ///< shapes whose bounds may be hit, by slot
    struct Candidate {
        std::int64_t enter, exit; ///< all hits lie between them [m, 30 fraction bits]
        std::uint32_t slot;
    };
    std::vector<Candidate> candidates;
    collide::NarrowScratch narrow;
    /// Cache of the last ball that was cast: balls of equal radius are equal.
    struct KnownBall {
        Real radius; ///< 0: none
        shapes::Solid solid;
        Coordinate reach;
    };
    KnownBall ball{};
};

struct QueryScratch {
    /// Guards everything that const members of World change: this struct, the placed shapes, the hashes of the state.
    base::Lock lock;
    std::vector<std::unique_ptr<QueryWork>> idle;
};

/// The input of a query: the state of a world, and its placed shapes.
struct Scene {
    const Model& model;
    PlacedShapes& placed; ///< updated to the state by each query
    QueryScratch& query;
    Tasks* tasks;
};

/// Like World's queries, for phases of a tick.
std::optional<QueryHit> cast_ray(const Scene& scene, const Ray& ray, const QueryFilter& filter);
std::optional<QueryHit> cast_shape(const Scene& scene, const Geometry& geometry, const Transform& pose,
                                   Vec3 translation, const QueryFilter& filter);

bool cast_ray_any(const Scene& scene, const Ray& ray, const QueryFilter& filter);
bool cast_shape_any(const Scene& scene, const Geometry& geometry, const Transform& pose, Vec3 translation,
                    const QueryFilter& filter);
/// The next three append to `hits` or `shapes`.
void cast_ray_all(const Scene& scene, const Ray& ray, const QueryFilter& filter, std::vector<QueryHit>& hits);
void cast_shape_all(const Scene& scene, const Geometry& geometry, const Transform& pose, Vec3 translation,
                    const QueryFilter& filter, std::vector<QueryHit>& hits);
void overlap(const Scene& scene, const Geometry& geometry, const Transform& pose, const QueryFilter& filter,
             std::vector<ShapeId>& shapes);
std::optional<QueryHit> nearest(const Scene& scene, const Geometry& geometry, const Transform& pose,
                                Real limit, const QueryFilter& filter);
std::optional<ShapeDistance> distance(const Scene& scene, ShapeId a, ShapeId b);

/// The first hit of a cast: the fields of QueryHit that ticks need.
struct FirstHit {
    ShapeId shape; ///< null: no hit, and no other field is set
    BodyId body;
    Real distance; ///< travelled [m]
    Vec3 point;
    UnitVec3 normal;
    std::uint32_t feature;
};

/// A ball that moves from a point along a path.
struct BallCast {
    Real radius;
    Vec3 from, way;
    collide::NearFaces* near = nullptr; ///< a cache for balls that are cast at one place again and again
};
inline constexpr std::size_t balls_max = 8;
/// Like cast_shape() for each ball. The search for near shapes runs once for all balls, so they should start near
/// each other. At most balls_max.
void cast_balls(const Scene& scene, std::span<const BallCast> balls, const QueryFilter& filter,
                std::span<FirstHit> hits);

} // namespace lockstone::sim
