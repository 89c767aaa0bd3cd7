#include "input_map.h"

#include <glm/glm.hpp>

#include <cmath>

namespace lockstone::demo {
namespace {

struct SeatKeys {
    Key right, left, up, down, jump, push, push_too;
    Controls names;
    const char* half; ///< the half of the window that shows this player in netplay
};
constexpr std::array<SeatKeys, 2> seat_keys{{
    {Key::d,
     Key::a,
     Key::w,
     Key::s,
     Key::space,
     Key::f,
     Key::left_shift,
     {"WASD", "Space", "F"},
     " (left)    "},
    {Key::right,
     Key::left,
     Key::up,
     Key::down,
     Key::right_control,
     Key::right_shift,
     Key::right_alt,
     {"arrows", "right Control", "right Shift"},
     " (right)   "},
}};

std::int8_t to_axis(float value) {
    return static_cast<std::int8_t>(std::lround(127 * glm::clamp(value, -1.0f, 1.0f)));
}

/// For example "WASD roll   Space jump   F push".
std::string keys_of(const Game& game, std::uint32_t player) {
    const Controls keys = seat_keys[player].names, does = controls_of(game, player);
    std::string line;
    for (const auto part : {&Controls::stick, &Controls::jump, &Controls::push}) {
        if (!line.empty()) line += "   ";
        line.append(keys.*part).append(" ").append(does.*part);
    }
    return line;
}

} // namespace

bool is_playable(const Game& game) {
    return game.input_size() == input_size_of<ArenaInput> && !controls_of(game, 0).stick.empty();
}

std::string keys_in_short(const Game& game) { return keys_of(game, 0); }

std::string keys_of_players(const Game& game, bool sides) {
    std::string lines;
    for (std::uint32_t p = 0; p < seat_keys.size() && p < game.player_count(); ++p)
        lines += "player " + std::to_string(p + 1) + (sides ? seat_keys[p].half : "   ") + keys_of(game, p) +
                 (p == 0 ? "   (or a gamepad: stick, A, X)\n" : "\n");
    return lines;
}

void InputMap::read_keys(const Input& input, std::size_t seat, glm::vec2& stick, Seat& out) {
    if (seat >= seat_keys.size()) return;
    const SeatKeys& keys = seat_keys[seat];
    const auto axis = [&](Key plus, Key minus) {
        return static_cast<float>(input.down(plus)) - static_cast<float>(input.down(minus));
    };
    stick += glm::vec2(axis(keys.right, keys.left), axis(keys.up, keys.down));
    if (input.down(keys.jump)) out.held |= arena_jump;
    if (input.pressed(keys.jump)) out.struck |= arena_jump;
    for (const Key push : {keys.push, keys.push_too}) {
        if (input.down(push)) out.held |= arena_push;
        if (input.pressed(push)) out.struck |= arena_push;
    }
}

void InputMap::read_gamepad(const Gamepad& pad, glm::vec2& stick, Seat& out) {
    if (!pad.connected) return;
    const auto down = [&](Gamepad::Button b) { return pad.buttons.down[static_cast<std::size_t>(b)]; };
    const auto struck = [&](Gamepad::Button b) { return pad.buttons.pressed[static_cast<std::size_t>(b)]; };
    stick += pad.left_stick;
    stick += glm::vec2(static_cast<float>(down(Gamepad::right)) - static_cast<float>(down(Gamepad::left)),
                       static_cast<float>(down(Gamepad::up)) - static_cast<float>(down(Gamepad::down)));
    if (down(Gamepad::a)) out.held |= arena_jump;
    if (struck(Gamepad::a)) out.struck |= arena_jump;
    if (down(Gamepad::x) || down(Gamepad::b)) out.held |= arena_push;
    if (struck(Gamepad::x) || struck(Gamepad::b)) out.struck |= arena_push;
}

void InputMap::poll(const Input& input, const Camera& camera) {
    const glm::vec3 right = camera.right();
    const glm::vec3 ahead(right.z, 0, -right.x); // horizontal, for any pitch of the camera
    for (std::size_t i = 0; i < seat_count; ++i) {
        Seat& seat = seats_[i];
        glm::vec2 stick(0);
        seat.held = 0;
        read_keys(input, i, stick, seat);
        read_gamepad(input.gamepads[i], stick, seat);
        const float length = glm::length(stick);
        if (length > 1) stick /= length;
        seat.move = {stick.x * right.x + stick.y * ahead.x, stick.x * right.z + stick.y * ahead.z};
        seat.used = seat.used || length > 0.3f || seat.held != 0 || seat.struck != 0;
    }
}

ArenaInput InputMap::take(std::size_t seat) {
    Seat& from = seats_[seat];
    ArenaInput input;
    input.move_x = to_axis(from.move.x);
    input.move_z = to_axis(from.move.y);
    input.buttons = static_cast<std::uint8_t>(from.held | from.struck);
    from.struck = 0;
    return input;
}

} // namespace lockstone::demo
