// The interface of a game for sessions and replays: inputs of all players in, one tick of the world out.
#pragma once

#include "lockstone/world.h"

#include <cstddef>
#include <span>
#include <string>

namespace lockstone {

/// Origin of an input.
enum class InputStatus : std::uint8_t {
    confirmed,    ///< the player's true input
    predicted,    ///< predicted; the tick may run again with another input
    disconnected, ///< the player has left; all bytes are zero
};

/// One player's input for one tick. Rules may read only whether the status is `disconnected`, which is equal
/// on all machines; the rest of the status is for display.
struct PlayerInput {
    std::span<const std::byte> bytes;            ///< [input_size]; not owned
    InputStatus status = InputStatus::confirmed; ///< confirmed, predicted or disconnected
};

/// The rules of a game: a pure function of the world and the inputs. Data that advance() needs in a later
/// tick must be in the world (bodies or game columns), not in this object.
class Game {
  public:
    virtual ~Game() = default;
    virtual std::string name() const = 0; ///< Name in replays. Name and content_id identify the rules.
    virtual std::uint64_t content_id() const = 0;   ///< Number that changes with the rules or the start.
    virtual std::uint32_t player_count() const = 0; ///< Number of players, 0..16.
    virtual std::uint32_t input_size() const = 0;   ///< Bytes of a player's input in each tick, 0..64.
    virtual Result<World> start() const = 0;        ///< Creates the world before tick 0; equal at every call.
    /// Runs one tick, in this order:
    ///   1. issue commands from `inputs` [player_count()]
    ///   2. call world.tick() exactly once
    ///   3. read world.events(), the events of this tick
    ///   4. write the game columns that these events change; other commands are possible here too
    /// Do not read events() or contacts() before the tick: they are not part of the state, and a restore
    /// clears them. A tick that runs again after a rollback would find none, and machines would diverge.
    /// Sounds and particles read SessionRunner::events() instead.
    ///
    /// Return an error, without a tick, if a necessary command fails: a session then runs the tick itself
    /// (WorldSimulation::failure()), and a recording of the match ends before it. Must not abort in any state
    /// that check() accepts, because recordings come from outside.
    virtual Status advance(World& world, std::span<const PlayerInput> inputs) const = 0;
    /// Checks a state from a file or a peer, after the engine's own checks: every id and number in the game
    /// columns that advance() relies on. The error names the wrong one. Default: accepts all.
    virtual Status check(const World& world) const {
        (void)world;
        return {};
    }
};

} // namespace lockstone
