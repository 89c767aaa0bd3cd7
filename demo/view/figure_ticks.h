#pragma once
/// The four moments of two blocks that bounce, found in a run from its contact events.
/// Source: Real-time Physics Simulation, figures 1 to 4.

#include "lockstone/world.h"

#include <array>
#include <cstdint>
#include <string>

namespace lockstone::demo {

/// Times: the state after that many ticks.
struct FigureTicks {
    std::uint64_t in_the_air; ///< figure 1: half way to the first contact
    std::uint64_t meeting;    ///< figure 2: one block has met the ground; now the other meets that block
    /// Figure 3: the middle of the time in which nothing touches, from where they part until one meets the ground. They may
    /// meet several times; they part where they do not meet again before figure 4.
    std::uint64_t apart;
    std::uint64_t landing; ///< figure 4: since they parted one has met the ground again; now the other does
    std::array<BodyId, 2> blocks; ///< the first is the one that meets the ground first
};

/// Follows a run of two dynamic bodies, the blocks; all else counts as the ground.
class FigureFinder {
  public:
    /// `start` is the world before its first tick. The error says what it has in place of two dynamic bodies.
    static Result<FigureFinder> create(const World& start);

    /// Reads the events of the tick that `world` has just run.
    void after_tick(const World& world);

    /// Whether the last of the four moments has passed; more ticks change nothing.
    bool done() const { return stage_ == Stage::landed; }
    /// The error says which of the moments did not come.
    Result<FigureTicks> ticks() const;

  private:
    enum class Stage { falling, bounced, met, apart, landed };
    /// What began in a tick.
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
    std::size_t first_ = 0;        ///< the block that meets the ground first
    bool second_landed_ = false;   ///< before it met the first
    int between_ = 0;              ///< pairs of shapes that touch: of both blocks,
    std::array<int, 2> ground_{};  ///< and of each block and the ground
    std::array<bool, 2> landed_{}; ///< on the ground again, since they parted
    std::uint64_t time_ = 0;       ///< after the last tick
    std::uint64_t first_contact_ = 0, meeting_ = 0, landing_ = 0;
    std::uint64_t parted_ = 0, flight_end_ = 0; ///< the last time they parted, and the first contact after it
};

} // namespace lockstone::demo
