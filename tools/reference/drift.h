// Float drift: how far builds of one engine part from each other, tick by tick, and that ours do not.
#pragma once

#include "reference/side_by_side.h"

#include <optional>
#include <string>
#include <vector>

namespace reference {

/// Two builds of one engine from the same start.
struct DriftLine {
    std::string name;          ///< "float, fused"
    std::string against;       ///< "float"
    std::vector<double> apart; ///< by tick: the farthest that a body is from its counterpart [m]
    /// The first tick after which any bit of a place or a turn differs
    std::optional<std::uint64_t> parts_at;
    /// The first tick after which they are farther apart than this.
    std::optional<std::uint64_t> apart_by(double metres) const;
};

/// Of two builds of the thesis' engine.
lockstone::Result<DriftLine> drift_of(const lockstone::Game& game, Settings settings, Build build,
                                      Build against, std::uint64_t ticks);
/// Of ours: the best instruction set and one thread against the plainest and three threads, hashes compared.
lockstone::Result<DriftLine> our_drift(const lockstone::Game& game, std::uint64_t ticks);
/// Every pair that this machine can run: fused against plain in double and in single precision, -ffast-math against plain, the
/// twin that should not part, and ours, which is the last.
lockstone::Result<std::vector<DriftLine>> all_drifts(const lockstone::Game& game, const Settings& settings,
                                                     std::uint64_t ticks);

} // namespace reference
