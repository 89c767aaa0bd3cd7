// For tests and proofs alone: a look behind a world's contract. Games do not include it.
#pragma once

#include "lockstone/world.h"

#include <bitset>
#include <span>
#include <string>
#include <string_view>

namespace lockstone::testing {

/// What ticks leave behind outside of the state, and no later one may see.
enum class Leftover : std::uint32_t {
    scratch, ///< memory that is written before it is read: filled with some byte
    trees,   ///< the shapes of the broad phase's trees: made anew, in random order or wholly at random
    pairs,   ///< which pairs were found already: some are forgotten, and found again in another order
};

/// Changes one of these leftovers; `seed` chooses how. No hash and no answer of the world depends on it. A value that is none of the
/// three does nothing.
void disturb(World& world, Leftover what, std::uint64_t seed);
/// The block itself, for planted faults. No check sees what is written there.
State& state_of(World& world);

/// Execution paths between which a tick chooses by sizes, workers, lanes and caches; all give the same bits. Bit k is the path path_names()[k].
using PathSet = std::bitset<192>;
/// Names of the paths. The sides of a choice follow one another.
std::span<const std::string_view> path_names();
/// The paths that the last tick of a world took. Empty before its first tick. A clone begins without paths.
PathSet paths_taken(const World& world);

/// A sentence about the first contact, joint or vehicle that the plans of the last tick take out of the order of solving; empty: there is none. Right after a
/// tick; disturb() overwrites what this reads.
std::string order_fault(const World& world);

/// How many worlds self_test() of lockstone/prove.h runs, and for how many ticks each.
inline constexpr std::uint32_t self_test_worlds = 20, self_test_ticks = 3;
/// The hashes that this build computes in the default mode, after each tick of each world, world by world. tools/refresh stores them. The error
/// names a world, a tick and the command that was refused.
Result<std::vector<std::uint64_t>> self_test_hashes();
/// self_test() with other hashes than the stored ones. Refuses another number of them.
Status self_test_against(std::span<const std::uint64_t> stored);

} // namespace lockstone::testing
