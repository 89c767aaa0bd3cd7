// Plays a recording: any tick, forwards and backwards.
//
//   Player player = Player::open(recording, game).value();      // inputs: needs the game
//   Player player = Player::open(recording).value();            // commands: needs nothing
//   player.seek(1200);                                          // nearest keyframe, then re-simulation
//   draw(player.world());
#pragma once

#include "replay/recording.h"

#include <map>

namespace lockstone::replay {

class Player {
  public:
    /// Fails for a game or an engine that cannot play the recording: another name, content id, player count, schema
    /// or world. The player starts at start_tick(). Both arguments must outlive the player.
    static Result<Player> open(const Recording& recording, const Game& game);
    static Result<Player> open(const Recording& recording);
    /// For either mode. A null `game` is an error in inputs mode; commands mode ignores it.
    static Result<Player> open(const Recording& recording, const Game* game);
    /// An upper bound of the memory that a player needs in addition to the recording [bytes], without its kept
    /// states. open() fails if this exceeds the remaining limit.
    static std::uint64_t memory_of(const Recording& recording, const WorldDef& def, const GameSchema& schema);

    const Recording& recording() const { return *source; }
    World& world() { return now; }
    const World& world() const { return now; }
    World release() && { return std::move(now); }

    std::uint64_t time() const { return time_now; }
    /// The cursor from which it reads inputs and commands.
    BlockCursor& blocks() { return cursor; }
    bool at_end() const { return time_now == source->end_tick(); }
    /// Returns true if the world's hash equals the recorded hash at this time.
    bool agrees() const { return now.hash() == source->hash_at(time_now); }

    /// Runs tick time(). Errors: at the end; a command that the world refuses. After an error the world stays as it
    /// is, and may not agree with the recording.
    Status step();
    /// Moves to the state at a time start_tick() .. end_tick(), from the nearest keyframe, or from a state that was
    /// visited before: every 60th is kept. Any other time is an error and changes nothing.
    Status seek(std::uint64_t to);
    /// Bytes that kept states may occupy, 64 MiB by default; 0: keeps no further states.
    void keep_states(std::size_t bytes_max) { kept_bytes_max = bytes_max; }
    /// Moves to the state of a keyframe, and checks its hash. An error if there is no such keyframe.
    Status seek_keyframe(std::size_t keyframe);

  private:
    Player(const Recording& from, const Game* by, World start)
        : source(&from), game(by), now(std::move(start)), cursor(from) {}
    static Result<Player> at_start(const Recording& recording, const Game* game, World world);
    Status run_commands();
    void keep_state();
    Error error(const std::string& sentence) const;

    const Recording* source;
    const Game* game; ///< null in commands mode
    World now;
    std::uint64_t time_now = 0;
    BlockCursor cursor;
    std::map<std::uint64_t, Image> kept; ///< by time; only states that agree with the recording
    std::size_t kept_bytes = 0, kept_bytes_max = std::size_t{64} << 20;
};

} // namespace lockstone::replay
