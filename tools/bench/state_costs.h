// What rollback costs: save, restore, hash, and whole rollbacks, beside a memcpy of the same bytes.
#pragma once

#include "bench/contest.h"

namespace lockstone::bench {

/// Of a scene from the tick that instructions are counted from; with `quick` from the third.
Json state_costs(const BenchScene& scene, const engines::Contestant& who, bool quick);

/// Ticks, saves, restores and hashes of boxes at rest, of which all, half, a tenth, a hundredth and none are awake.
Json awake_costs(bool quick);

} // namespace lockstone::bench
