// What the queries of a world keep from call to call: memory, and until when the caches are fresh.
//
// Several threads may ask at once: caches are brought up to the state by one of them, behind a lock, and each has memory of
// its own while it asks. Nothing that is kept shows in an answer.
#pragma once

#include "base/lock.h"
#include "collide/broad/broad_phase.h"
#include "collide/narrow_phase.h"
#include "lockstone/query.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace lockstone::sim {

struct Data;

/// The memory of one who asks.
struct QueryWork {
    collide::BroadPhase::Asker near; ///< shapes whose bounds may be met, by slot
    struct Candidate {
        std::int64_t enter; ///< no hit is nearer [m, 30 fraction bits]
        std::uint32_t slot;
    };
    std::vector<Candidate> candidates;
    collide::NarrowScratch narrow;
};

struct QueryScratch {
    bool is_fresh = false; ///< poses and bounds of the tick's scratch are those of the state, as it was at:
    std::uint64_t tick = 0, commands = 0;
    base::Lock
        lock; ///< of all that const members of World change: this, the caches it is about, the state's hashes
    std::vector<std::unique_ptr<QueryWork>> idle;
};

/// As World's; for phases that ask while a tick runs.
std::optional<QueryHit> cast_ray(Data& w, const Ray& ray, const QueryFilter& filter);
std::optional<QueryHit> cast_shape(Data& w, const Geometry& geometry, const Transform& pose, Vec3 translation,
                                   const QueryFilter& filter);

/// A ball that is moved from a point along a way.
struct BallCast {
    Real radius;
    Vec3 from, way;
};
inline constexpr std::size_t balls_max = 8;
/// As cast_shape() of each ball; of balls that start near each other, what is near is found once. At most balls_max.
void cast_balls(Data& w, std::span<const BallCast> balls, const QueryFilter& filter,
                std::span<std::optional<QueryHit>> hits);

} // namespace lockstone::sim
