// What the queries of a world keep from call to call: memory, and until when the caches are fresh.
#pragma once

#include "lockstone/query.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace lockstone::sim {

struct Data;

struct QueryScratch {
    bool is_fresh = false; ///< poses and bounds of the tick's scratch are those of the state, as it was at:
    std::uint64_t tick = 0, commands = 0;
    std::vector<std::uint32_t> slots; ///< of shapes whose bounds may be met
    struct Candidate {
        std::int64_t enter; ///< no hit is nearer [m, 30 fraction bits]
        std::uint32_t slot;
    };
    std::vector<Candidate> candidates;
};

/// As World's; for phases that ask while a tick runs.
std::optional<QueryHit> cast_ray(Data& w, const Ray& ray, const QueryFilter& filter);
std::optional<QueryHit> cast_shape(Data& w, const Geometry& geometry, const Transform& pose, Vec3 translation,
                                   const QueryFilter& filter);

} // namespace lockstone::sim
