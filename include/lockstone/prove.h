// A test of determinism for any simulation: it repeats it, rolls it back, moves it, poisons its scratch
// memory and flips its bits.
//
//   Result<Proof> proof = prove(game);                     // a lockstone::Game, with random inputs
//   puts(to_string(*proof).c_str());                       // a line for each check
//   assert(proof->holds());
//
// A simulation without a World implements Provable. The test covers the ticks that it runs, in one process;
// to test other compilers and machines, verify a recording on each.
#pragma once

#include "lockstone/game.h"
#include "lockstone/simd.h"
#include "lockstone/tasks.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lockstone {

/// A simulation that can be saved and created again. A tick depends on the state and on the number of the
/// tick only.
class Provable {
  public:
    virtual ~Provable() = default;
    /// Creates another simulation at its start; equal at every call.
    virtual std::unique_ptr<Provable> make() const = 0;
    /// Runs tick `tick`: 0, 1, 2 ...
    virtual void step(std::uint64_t tick) = 0;
    virtual std::vector<std::byte> save() const = 0; ///< The state as bytes.
    /// Replaces the state by bytes of save() of any of these simulations.
    virtual Status load(std::span<const std::byte> bytes) = 0;
    virtual std::uint64_t hash() const = 0; ///< Hash of the state.

    // ---- optional parts; prove() reports the checks that are not possible without them ----
    /// Saves the state to a slot in memory, as rollback does. Default: by save().
    virtual void keep(std::size_t slot);
    /// Restores the state of a slot that keep() has filled. Default: by load().
    virtual Status back(std::size_t slot);
    /// Sets the task scheduler of later ticks; null: none. Default: false, ticks use no tasks.
    virtual bool set_tasks(Tasks*) { return false; }
    /// Sets the instruction set of later ticks. False, without effect: not supported. prove() calls it
    /// between ticks, from one thread. Default: false.
    virtual bool set_simd(Simd) { return false; }
    /// Number of bits of the state. Default: 0, unknown.
    virtual std::uint64_t bit_count() const { return 0; }
    virtual void flip(std::uint64_t) {} ///< Flips a bit below bit_count().
    /// Changes data outside the state that must not affect the next tick: scratch memory, caches, search
    /// trees. The argument is a seed. Called between ticks. Default: false, there is none.
    virtual bool disturb(std::uint64_t) { return false; }
    /// save() as the difference to `base`, an earlier result of it. Default: empty, not supported.
    virtual std::optional<std::vector<std::byte>> save_delta(std::span<const std::byte> base) const;
    /// Replaces the state by `base` plus `delta`. Error: another base; the state is then as before.
    virtual Status load_delta(std::span<const std::byte> base, std::span<const std::byte> delta);
    /// The first difference of two states as text: "column body.velocity, row 7, linear.x: 1 against 2".
    virtual std::string difference(const Provable&) const { return "the hashes differ"; }

  private:
    std::vector<std::vector<std::byte>> kept;
};

/// Settings of prove().
struct ProofOptions {
    std::uint64_t ticks = 60;       ///< ticks of the reference run; 0 counts as 1
    std::uint32_t depth = 4;        ///< ticks that run again after each restore; 0 counts as 1
    std::uint32_t workers = 3;      ///< of the pool of "shuffles", at most 64; 0: no check uses a pool
    std::uint64_t bits_max = 20000; ///< bits to flip at the end of the run, evenly distributed; 0: none
    std::uint64_t seed = 1;         ///< of inputs, task order and memory content
};

/// Result of a check.
struct ProofCheck {
    std::string name;           ///< "rolls back"
    bool passed;                ///< true also if the check was not possible; `compared` is then 0
    std::uint64_t compared = 0; ///< number of compared hashes or flipped bits
    std::string sentence;       ///< first failure with tick and place; or why the check was not possible
};

/// Result of prove().
struct Proof {
    std::vector<ProofCheck> checks; ///< in the order of the list at prove()
    bool holds() const;             ///< True if every check passed.
};
/// A line for each check: "ok      rolls back: 340 compared" or "FAILED  rolls back: tick 12, ...".
std::string to_string(const Proof& proof);

/// Runs these checks, each with its own simulations:
///   repeats             two runs at different addresses, over different memory content, have equal hashes
///   rolls back          before every tick: back by `depth` ticks and forward again, by keep() and back()
///   saves everything    at every tick a loaded state saves equal bytes and has an equal hash
///   moves               at every tick another object loads the state and continues
///   forgets             after the end an object continues from each earlier tick, last first: `depth` ticks
///   reads no leftovers  before every tick disturb() changes the data outside the state
///   sends differences   an earlier state plus the difference gives each state; another base is refused
///   shuffles            tasks in random order, then on a pool of `workers`, give equal hashes at every tick
///   every mode agrees   each instruction set of the machine with tasks in random order, and 1 to 4 workers,
///                       give equal hashes at every tick; before random ticks a new object loads the state
///   every bit counts    flipping a bit of the state changes the hash; flipping it back restores the hash
Proof prove(const Provable& simulation, const ProofOptions& options = {});

/// Writes the input of a player at a tick to `input`, which is zero on entry. A pure function.
using ProofInput = std::function<void(std::uint64_t tick, std::uint32_t player, std::span<std::byte> input)>;

/// Runs these checks on a game and its world; two starts must give equal worlds. Rollback uses ring images,
/// moves use portable images, and bits of every column are flipped. Without `input` the inputs are random
/// bytes from the seed. Errors: those of the game, at its start or in a tick.
Result<Proof> prove(const Game& game, const ProofOptions& options = {}, ProofInput input = {});

/// Self test of the library, for the start of a program. Runs 20 small worlds in each instruction set of the
/// machine, half of them also with tasks in random order, and compares the hash after each tick with a stored
/// one. An error means that this compiler, flag or processor computes other bits than the builds of other
/// players, so a match with them diverges. The error names world, mode and tick, counted from 0: "world 7,
/// avx2, after tick 2: hash 0123456789abcdef against the stored 4567456745674567". Runs on the calling
/// thread. Thread-safe.
Status self_test();

} // namespace lockstone
