#pragma once
/// Finds the four moments of two bouncing blocks in the contact events of a run. Source: Real-time Physics Simulation,
/// figures 1 to 4.

#include "lockstone/world.h"

#include <array>
#include <cstdint>
#include <string>

namespace lockstone::demo {

/// Times: each is the number of ticks before the state.
struct FigureTicks {
    std::uint64_t in_the_air; ///< figure 1: half of the time to the first contact
    std::uint64_t meeting; ///< figure 2: one block has touched the ground; now the other touches that block
    /// Figure 3: the middle of the contact-free time that begins when the blocks part and ends when one touches the
    /// ground. If the blocks touch several times, the last parting before figure 4 counts.
    std::uint64_t apart;
    /// Figure 4: since the blocks parted one of them has touched the ground again; now the other does.
    std::uint64_t landing;
    std::array<BodyId, 2> blocks; ///< the first is the block that touches the ground first
};

/// Follows a run with two dynamic bodies, the blocks. All other bodies count as the ground.
class FigureFinder {
  public:
    /// `start` is the world before its first tick. An error if the world does not have exactly two dynamic bodies.
    static Result<FigureFinder> create(const World& start);

    /// Reads the events of the tick that `world` has just run.
    void after_tick(const World& world);

    /// True once the last of the four moments has passed; more ticks change nothing.
    bool done() const { return stage_ == Stage::landed; }
    /// The four moments. The error names a moment that did not occur.
    Result<FigureTicks> ticks() const;

  private:
    enum class Stage { falling, bounced, met, apart, landed };
    /// The contacts that began in a tick.
    struct Begun {
        bool between = false;
        std::array<bool, 2> ground{};
        bool any() const { return between || ground[0] || ground[1]; }
    };

    explicit FigureFinder(const std::array<BodyId, 2>& blocks) : blocks_(blocks) {}
    Begun read_events(const World& world);
    void after_parting(const Begun& begun);
    bool nothing_touches() const { return between_ == 0 && ground_[0] == 0 && ground_[1] == 0; }
    std::string complaint() const;

    std::array<BodyId, 2> blocks_;
    Stage stage_ = Stage::falling;
    std::size_t first_ = 0;        ///< the block that touches the ground first
    bool second_landed_ = false;   ///< the second block touched the ground before it touched the first
    int between_ = 0;              ///< number of touching pairs of shapes: between the blocks,
    std::array<int, 2> ground_{};  ///< and between each block and the ground
    std::array<bool, 2> landed_{}; ///< has touched the ground again since the blocks parted
    std::uint64_t time_ = 0;       ///< after the last tick
    std::uint64_t first_contact_ = 0, meeting_ = 0, landing_ = 0;
    /// Time of the last parting, and of the first contact after it.
    std::uint64_t parted_ = 0, flight_end_ = 0;
};

} // namespace lockstone::demo
