#pragma once
/// Converts keys and gamepads to the inputs of scenes.

#include "render/camera/camera.h"
#include "render/camera/input.h"
#include "scenes/scenes.h"

#include <array>
#include <string>

namespace lockstone::demo {

/// True if the game uses ArenaInput, so that a person can play it.
bool is_playable(const Game& game);
/// The keys of seat 0 in one line: "WASD roll   Space jump   F push".
std::string keys_in_short(const Game& game);
/// A line for each player with keys. `sides`: also names the halves of the window, for netplay.
std::string keys_of_players(const Game& game, bool sides = false);

/// A seat is a set of controls. Seat 0: WASD, space jumps, F or left shift pushes. Seat 1: arrows, right control jumps,
/// right shift pushes. Every seat also has the gamepad of its number: left stick or cross moves, A jumps, X or B
/// pushes.
class InputMap {
  public:
    static constexpr std::size_t seat_count = 4;

    /// Call it once per picture. Directions are relative to the camera. A button that was pressed since the last take()
    /// counts, even if it is already released.
    void poll(const Input& input, const Camera& camera);

    /// True if the seat was ever used.
    bool used(std::size_t seat) const { return seats_[seat].used; }
    /// The input for the next tick.
    ArenaInput take(std::size_t seat);

  private:
    struct Seat {
        glm::vec2 move{0}; ///< along world x and z, at most 1 long
        std::uint8_t held = 0, struck = 0;
        bool used = false;
    };
    static void read_keys(const Input& input, std::size_t seat, glm::vec2& stick, Seat& out);
    static void read_gamepad(const Gamepad& pad, glm::vec2& stick, Seat& out);
    std::array<Seat, seat_count> seats_;
};

} // namespace lockstone::demo
