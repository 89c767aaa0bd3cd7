#pragma once
/// Keys and gamepads as the inputs of scenes.

#include "render/camera/camera.h"
#include "render/camera/input.h"
#include "scenes/scenes.h"

#include <array>
#include <string>

namespace lockstone::demo {

/// Whether this game takes ArenaInput, so that people can play it.
bool is_playable(const Game& game);
/// What seat 0 does, for one line: "WASD roll   Space jump   F push".
std::string keys_in_short(const Game& game);
/// A line for each player who has keys; `sides`: netplay, whose halves have names.
std::string keys_of_players(const Game& game, bool sides = false);

/// Seat 0: WASD, space jumps, F or left shift pushes. Seat 1: arrows, right control jumps, right shift
/// pushes. Every seat: the gamepad of its number; left stick or cross moves, A jumps, X or B pushes.
class InputMap {
  public:
    static constexpr std::size_t seat_count = 4;

    /// Once per picture. Directions are those of the camera; buttons that were struck since the last take()
    /// count, however short.
    void poll(const Input& input, const Camera& camera);

    /// Whether anybody has ever used this seat.
    bool used(std::size_t seat) const { return seats_[seat].used; }
    /// For the next tick.
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
