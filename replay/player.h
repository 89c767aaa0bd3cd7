// Plays a recording: any tick, forwards and backwards.
//
//   Player player = Player::open(recording, game).value();      // inputs: needs the game
//   Player player = Player::open(recording).value();            // commands: needs nothing
//   player.seek(1200);                                          // nearest keyframe, then re-simulated
//   draw(player.world());
#pragma once

#include "replay/recording.h"

#include <map>

namespace lockstone::replay {

class Player {
  public:
    /// Refuses a game or an engine that cannot play the recording: another name, content id, players, schema or world.
    /// Stands at the start. Both arguments outlive the player.
    static Result<Player> open(const Recording& recording, const Game& game);
    static Result<Player> open(const Recording& recording);
    /// Either: `game` null is refused in inputs mode, ignored in commands mode.
    static Result<Player> open(const Recording& recording, const Game* game);
    /// An upper bound of what a player takes besides the recording [bytes], its kept states left out; more than the limit
    /// leaves is refused by open.
    static std::uint64_t memory_of(const Recording& recording, const WorldDef& def, const GameSchema& schema);

    const Recording& recording() const { return *source; }
    World& world() { return now; }
    const World& world() const { return now; }
    World release() && { return std::move(now); }

    std::uint64_t time() const { return time_now; }
    /// Where it reads what a tick is made of.
    BlockCursor& blocks() { return cursor; }
    bool at_end() const { return time_now == source->end_tick(); }
    /// Whether the world is, by its hash, the recorded one at this time.
    bool agrees() const { return now.hash() == source->hash_at(time_now); }

    /// Runs tick time(). Errors: at the end; a command that the world refuses. What was reached stays; it may not agree.
    Status step();
    /// To the state at a time start_tick() .. end_tick(), from the nearest keyframe, or from a state that was passed
    /// before: one in 60 is kept. Any other time is an error and changes nothing.
    Status seek(std::uint64_t to);
    /// Bytes that kept states may take, 64 MiB by default; 0 keeps none from now on.
    void keep_states(std::size_t bytes_max) { kept_bytes_max = bytes_max; }
    /// To the state that a keyframe holds. Its hash is checked. An error when there is no such keyframe.
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
