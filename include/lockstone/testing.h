// Access to the internals of a world, for tests and proofs. Games do not include it.
#pragma once

#include "lockstone/world.h"

#include <bitset>
#include <span>
#include <string>
#include <string_view>

/// Access for tests and proofs.
namespace lockstone::testing {

/// Data outside the state that a tick leaves behind. It must not affect later ticks.
enum class Leftover : std::uint32_t {
    scratch, ///< scratch memory: filled with a byte
    trees,   ///< broad-phase trees: rebuilt in random order or with random structure
    pairs,   ///< cached pairs: some are removed, so that they are found again in another order
};

/// Changes leftover data; `seed` selects how. No hash and no query result depends on it. Any other value of
/// `what` has no effect.
void disturb(World& world, Leftover what, std::uint64_t seed);
/// The state of a world for writing, without any check: for planted faults. Valid as long as the world.
State& state_of(World& world);

/// Set of execution paths. A tick selects paths by sizes, workers, lanes and caches; all of them give equal
/// bits. Bit k is path_names()[k].
using PathSet = std::bitset<192>;
/// Names of the paths; alternatives are neighbours. Static memory.
std::span<const std::string_view> path_names();
/// The paths of a world's last tick. Empty before its first tick, and in a clone.
PathSet paths_taken(const World& world);

/// Checks the solving order of the last tick: a sentence about the first contact, joint or vehicle out of
/// order; empty: none. Call it right after a tick, before disturb().
std::string order_fault(const World& world);

inline constexpr std::uint32_t self_test_worlds = 20, ///< worlds of self_test() (lockstone/prove.h)
    self_test_ticks = 3;                              ///< ticks of each world
/// The self-test hashes of this build [self_test_worlds * self_test_ticks, world by world]. tools/refresh
/// stores them. The error names a world, a tick and the refused command.
Result<std::vector<std::uint64_t>> self_test_hashes();
/// self_test() with these hashes in place of the stored ones. Error also: a wrong number of hashes.
Status self_test_against(std::span<const std::uint64_t> stored);

} // namespace lockstone::testing
