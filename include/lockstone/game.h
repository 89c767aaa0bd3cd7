// A game as sessions and replays see it: players' inputs in, one tick of the world out.
#pragma once

#include "lockstone/world.h"

#include <cstddef>
#include <span>
#include <string>

namespace lockstone {

enum class InputStatus : std::uint8_t {
    confirmed,    ///< this is what the player did
    predicted,    ///< a guess; the tick may be run again with another
    disconnected, ///< the player has left; bytes are zero
};

/// One player's input for one tick: `Game::input_size()` bytes. Status is for display; the simulation must not read
/// it except for `disconnected`, which is agreed between peers.
struct PlayerInput {
    std::span<const std::byte> bytes;
    InputStatus status = InputStatus::confirmed;
};

/// The game's rules. A pure function: all that `advance` remembers between ticks lies in the world (bodies and game
/// columns), never in the object. Then rollback, replay and lockstep need nothing else.
class Game {
  public:
    virtual ~Game() = default;
    virtual std::string name() const = 0;           ///< stands in replays; with content_id names the rules
    virtual std::uint64_t content_id() const = 0;   ///< changes whenever the rules or the start change
    virtual std::uint32_t player_count() const = 0; ///< 0..16
    virtual std::uint32_t input_size() const = 0;   ///< bytes per player and tick, 0..64
    virtual Result<World> start() const = 0;        ///< the world before tick 0
    /// Issues commands from `inputs` (player_count() of them), then calls world.tick() exactly once. A command that the
    /// rules cannot do without and that fails is the error; the tick is left out then, but a session runs it all the same
    /// (WorldSimulation::failure), and a recording of that match can be played up to it only. No state that `check` takes may
    /// make it abort: recordings come from anyone.
    virtual Status advance(World& world, std::span<const PlayerInput> inputs) const = 0;
    /// A state that came from a file or a peer, after the engine's own checks: whether the rules can go on from it. Every
    /// id and number in the game's columns that `advance` relies on; the error says which is wrong.
    virtual Status check(const World& world) const {
        (void)world;
        return {};
    }
};

} // namespace lockstone
