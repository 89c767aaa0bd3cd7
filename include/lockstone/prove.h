// The proof of determinism, for any simulation: rerun it, roll it back, move it, poison its scratch, flip its bits.
//
//   Result<Proof> proof = prove(game);                     // a lockstone::Game, with random inputs
//   puts(to_string(*proof).c_str());                       // a line for each check
//   assert(proof->holds());
//
// A simulation that is not a World implements Provable. A proof is a test: it finds what it can see in the ticks it runs.
// What it cannot see in one process (another compiler, another machine) is for recordings that both verify.
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

/// A simulation that can be saved, and made again. What it does in a tick depends on its state and the tick's number.
class Provable {
  public:
    virtual ~Provable() = default;
    /// Makes another one, at its start, at another address. The same at every call.
    virtual std::unique_ptr<Provable> make() const = 0;
    /// Runs tick `tick`: 0, 1, 2 ...
    virtual void step(std::uint64_t tick) = 0;
    virtual std::vector<std::byte> save() const = 0;
    /// Takes the bytes that save() of any other one gave.
    virtual Status load(std::span<const std::byte> bytes) = 0;
    virtual std::uint64_t hash() const = 0;

    // ---- what a simulation may have besides; a proof says what it could not check ----
    /// The fast way of rollback, when there is one: up to `slots` states kept in memory. By default save() and load().
    virtual void keep(std::size_t slot);
    virtual Status back(std::size_t slot);
    /// Who runs the parts of a tick from now on; false: ticks have no parts.
    virtual bool set_tasks(Tasks*) { return false; }
    /// Later ticks use this instruction set, as after World::set_simd. Returns false and changes nothing where the simulation has no
    /// choice of instruction sets, or where the machine lacks this one. prove() calls it between ticks, from one thread.
    virtual bool set_simd(Simd) { return false; }
    /// How many bits of state there are to flip, and one of them.
    virtual std::uint64_t bit_count() const { return 0; }
    virtual void flip(std::uint64_t) {}
    /// Changes what an earlier tick left behind and the next one must not see: scratch memory, caches, the shapes of
    /// search trees. Called between ticks; false: there is nothing to change.
    virtual bool disturb(std::uint64_t) { return false; }
    /// What save() gives, as the difference to `base`, which it gave earlier; without a value: there is no such thing.
    virtual std::optional<std::vector<std::byte>> save_delta(std::span<const std::byte> base) const;
    /// Of a difference to `base`. Refuses, and stays as it was, where it is the difference to something else.
    virtual Status load_delta(std::span<const std::byte> base, std::span<const std::byte> delta);
    /// Where the two part, in words: "column body.velocity, row 7, linear.x: 1 against 2".
    virtual std::string difference(const Provable&) const { return "the hashes differ"; }

  private:
    std::vector<std::vector<std::byte>> kept;
};

struct ProofOptions {
    std::uint64_t ticks = 60;       ///< of the run that everything is compared with, at least 1
    std::uint32_t depth = 4;        ///< ticks that are run again after each restore, at least 1
    std::uint32_t workers = 3;      ///< of the pool that "shuffles" runs on; 0: no check uses a pool
    std::uint64_t bits_max = 20000; ///< flipped in turn at the end of the run, spread evenly; 0: none
    std::uint64_t seed = 1;         ///< of inputs, of the order of workers and of what memory is filled with
};

struct ProofCheck {
    std::string name;           ///< "rolls back"
    bool passed;                ///< also when there was nothing to check; then `compared` is 0
    std::uint64_t compared = 0; ///< hashes, or flipped bits
    /// The first thing that was wrong: tick and place; or why there was nothing to check
    std::string sentence;
};

struct Proof {
    std::vector<ProofCheck> checks; ///< in the order of the list at prove()
    bool holds() const;
};
/// One line a check: "ok      rolls back: 340 compared" or "FAILED  rolls back: tick 12, ...".
std::string to_string(const Proof& proof);

/// The checks, each on simulations of its own:
///   repeats             made and run twice, at other addresses, over memory filled otherwise: the same hashes
///   rolls back          before every tick, back by `depth` ticks and run again, through keep and back
///   saves everything    a state that was loaded saves the same bytes and has the same hash, at every tick
///   moves               at every tick the state goes on in another object that knows nothing else
///   forgets             one that ran to the end goes on from every earlier tick, last first, `depth` ticks each
///   reads no leftovers  at every tick with what the one before left behind made different
///   sends differences   every state comes out of an earlier one and the difference; out of another it is refused
///   shuffles            tasks in random order, then on a pool of `workers`: the same hash at every tick
///   every mode agrees   a run in each instruction set of the machine with tasks in random order, and on 1, 2, 3 and 4 workers; before
///                       random ticks a new object of that mode loads the saved state and continues: the same hash at every tick
///   every bit counts    flipping a bit of the state changes the hash; flipping it back restores the hash
Proof prove(const Provable& simulation, const ProofOptions& options = {});

/// Fills `input` with what a player does at a tick: a pure function, zero on entry.
using ProofInput = std::function<void(std::uint64_t tick, std::uint32_t player, std::span<std::byte> input)>;

/// Runs the checks above on a game and the world of its start; a second start has to give an equal world. The world is rolled back through ring images and
/// moved through portable ones, and bits of every column are flipped. Without `input` the inputs are random bytes from the seed. Returns the error of the
/// game, at its start or in a tick.
Result<Proof> prove(const Game& game, const ProofOptions& options = {}, ProofInput input = {});

/// The self test of the library, for the start of a program. Runs 20 small worlds in each instruction set of the machine, and half of them
/// with tasks in random order, and compares the hash after each tick with a stored hash of the library. Another hash means that a compiler, a flag or
/// a processor computes other bits than the builds of other players, and a match with them diverges. The error names world, mode and tick, each counted
/// from 0: "world 7, avx2, after tick 3: hash 0123456789abcdef against the stored 4567456745674567". It runs on the calling thread, frees its
/// memory before it returns, and neither reads nor changes anything else: any number of threads may call it at any time.
Status self_test();

} // namespace lockstone
