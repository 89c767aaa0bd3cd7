// Questions to a world, and the memory that they keep from call to call.
//
// Several threads may ask at once: caches are brought up to the state by one of them, behind a lock, and each has memory of
// its own while it asks. Nothing that is kept shows in an answer.
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

/// The memory of one who asks.
struct QueryWork {
    collide::BroadPhase::Asker near; ///< shapes whose bounds may be met, by slot
    struct Candidate {
        std::int64_t enter, exit; ///< all hits are between them [m, 30 fraction bits]
        std::uint32_t slot;
    };
    std::vector<Candidate> candidates;
    collide::NarrowScratch narrow;
    /// What the last ball was that was cast: of one radius it is always the same.
    struct KnownBall {
        Real radius; ///< 0: none
        shapes::Solid solid;
        Coordinate reach;
    };
    KnownBall ball{};
};

struct QueryScratch {
    /// Guards all that const members of World change: this, the placed shapes, the state's hashes
    base::Lock lock;
    std::vector<std::unique_ptr<QueryWork>> idle;
};

/// What can be asked about: a world's state and where its shapes are.
struct Scene {
    const Model& model;
    PlacedShapes& placed; ///< brought up to the state
    QueryScratch& query;
    Tasks* tasks;
};

/// As World's; for phases that ask while a tick runs.
std::optional<QueryHit> cast_ray(const Scene& scene, const Ray& ray, const QueryFilter& filter);
std::optional<QueryHit> cast_shape(const Scene& scene, const Geometry& geometry, const Transform& pose,
                                   Vec3 translation, const QueryFilter& filter);

bool cast_ray_any(const Scene& scene, const Ray& ray, const QueryFilter& filter);
bool cast_shape_any(const Scene& scene, const Geometry& geometry, const Transform& pose, Vec3 translation,
                    const QueryFilter& filter);
/// These append to `hits` or `shapes`.
void cast_ray_all(const Scene& scene, const Ray& ray, const QueryFilter& filter, std::vector<QueryHit>& hits);
void cast_shape_all(const Scene& scene, const Geometry& geometry, const Transform& pose, Vec3 translation,
                    const QueryFilter& filter, std::vector<QueryHit>& hits);
void overlap(const Scene& scene, const Geometry& geometry, const Transform& pose, const QueryFilter& filter,
             std::vector<ShapeId>& shapes);
std::optional<QueryHit> nearest(const Scene& scene, const Geometry& geometry, const Transform& pose,
                                Real limit, const QueryFilter& filter);
std::optional<ShapeDistance> distance(const Scene& scene, ShapeId a, ShapeId b);

/// Where a cast meets a shape first: of a QueryHit what ticks ask.
struct FirstHit {
    ShapeId shape; ///< null: it meets nothing, and nothing else is set
    BodyId body;
    Real distance; ///< travelled [m]
    Vec3 point;
    UnitVec3 normal;
    std::uint32_t feature;
};

/// A ball that is moved from a point along a way.
struct BallCast {
    Real radius;
    Vec3 from, way;
    collide::NearFaces* near = nullptr; ///< for that which is cast thereabouts again and again
};
inline constexpr std::size_t balls_max = 8;
/// As cast_shape() of each ball; of balls that start near each other, what is near is found once. At most balls_max.
void cast_balls(const Scene& scene, std::span<const BallCast> balls, const QueryFilter& filter,
                std::span<FirstHit> hits);

} // namespace lockstone::sim
