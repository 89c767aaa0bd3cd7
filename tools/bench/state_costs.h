// Costs of rollback: saving, restoring, hashing and whole rollbacks, beside a memcpy of as many bytes.
#pragma once

#include "bench/contest.h"

namespace lockstone::bench {

/// The costs of a scene at its tick `counted_from`, with `quick` at its third tick.
Json state_costs(const BenchScene& scene, const engines::Contestant& who, bool quick);

/// Ticks, saves, restores and hashes of resting boxes while all, half, a tenth, a hundredth and none of them are awake.
Json awake_costs(bool quick);

} // namespace lockstone::bench
