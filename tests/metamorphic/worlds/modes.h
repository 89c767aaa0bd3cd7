// Execution modes. A mode must not change a bit of a world.
#pragma once

#include "story.h"

#include "lockstone/math/random.h"
#include "lockstone/simd.h"
#include "lockstone/tasks.h"
#include "lockstone/testing.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace worlds {

/// Ways to replace a world by another one between ticks.
enum Restore : std::uint32_t {
    rolls_back = 1,  ///< a ring image, some ticks later
    into_fresh = 2,  ///< the ring image of one world into a new one
    from_bytes = 4,  ///< a portable image into a new world
    from_delta = 8,  ///< a difference to an earlier image, into a new world
    from_clone = 16, ///< clone()
    all_restores = 31,
};
/// Memory outside of the state that the mode changes before a tick.
enum Disturb : std::uint32_t { scratch = 1, trees = 2, pairs = 4, all_disturbs = 7 };

enum class Runner : std::uint32_t { caller, shuffled, pool };

struct Mode {
    Simd simd = Simd::scalar;
    Runner runner = Runner::caller;
    std::uint32_t workers = 1;
    std::uint32_t restores = 0; ///< bits of Restore
    std::uint32_t disturbs = 0; ///< bits of Disturb
    bool observes = false;      ///< a phase observer and a journal are attached
    bool hashes_phases = false;
    bool reserves = false;    ///< reserves memory
    bool queries = false;     ///< casts and overlaps between ticks
    bool other_order = false; ///< the start is assembled in another order
    bool moves_state = false; ///< the state's block moves whenever it may
    std::uint64_t seed = 0;
    std::uint64_t planted =
        0; ///< planted fault: after this tick, counted from 1, one velocity changes by a step
};
std::string to_string(const Mode& mode);

/// One worker and plain integers. The data that earlier ticks left behind is dropped before each tick.
Mode reference_mode();
/// A random mode of this machine.
Mode draw_mode(Random& random);
/// The modes that are one step simpler, for shrinking.
std::vector<Mode> simpler(const Mode& mode);

/// A world that plays a story in a mode.
class Player {
  public:
    Player(const Story& story, const Mode& mode);
    ~Player();
    Player(const Player&) = delete;
    Player& operator=(const Player&) = delete;
    /// Runs the commands before tick `t`, then the tick. Ticks are run in order, each once.
    void play(std::uint64_t t);
    World& world() { return *own; }
    /// The execution paths of all ticks so far.
    const testing::PathSet& paths() const { return taken; }
    const World& world() const { return *own; }

  private:
    struct Watcher;
    void attach();
    void replace(World other);
    void restore(std::uint64_t t);
    void disturb();
    void look();
    void tick(std::uint64_t t);

    const Story& story;
    Mode mode;
    Random random;
    std::unique_ptr<Tasks> tasks;
    std::unique_ptr<Watcher> watcher;
    Teller teller;
    std::unique_ptr<World> own;
    testing::PathSet taken;
    Image kept; ///< before tick `kept_tick`
    std::uint64_t kept_tick = 0;
    bool is_kept = false;
};

} // namespace worlds
