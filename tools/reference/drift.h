// Float drift: how far builds of the thesis' engine diverge tick by tick, and that builds of Lockstone do not.
#pragma once

#include "reference/side_by_side.h"

#include <optional>
#include <string>
#include <vector>

namespace reference {

/// A comparison of two builds of one engine from the same start.
struct DriftLine {
    std::string name;          ///< "float, fused"
    std::string against;       ///< "float"
    std::vector<double> apart; ///< by tick: the largest distance of a body from its counterpart [m]
    /// The first tick after which any bit of a position or a rotation differs.
    std::optional<std::uint64_t> parts_at;
    /// The first tick after which a body is farther than `metres` from its counterpart.
    std::optional<std::uint64_t> apart_by(double metres) const;
};

/// Compares two builds of the thesis' engine.
lockstone::Result<DriftLine> drift_of(const lockstone::Game& game, Settings settings, Build build,
                                      Build against, std::uint64_t ticks);
/// Compares two runs of Lockstone: the best instruction set with one thread, and the scalar one with three threads.
/// Hashes are compared.
lockstone::Result<DriftLine> our_drift(const lockstone::Game& game, std::uint64_t ticks);
/// All pairs that this machine can run: fused against plain in double and in single precision, -ffast-math against
/// plain, float_twin (which must not diverge), and Lockstone as the last.
lockstone::Result<std::vector<DriftLine>> all_drifts(const lockstone::Game& game, const Settings& settings,
                                                     std::uint64_t ticks);

} // namespace reference
