#pragma once
/// The state of keyboard, mouse and gamepads: one snapshot per Surface::poll.

#include <glm/glm.hpp>

#include <array>
#include <bitset>
#include <cstddef>

namespace lockstone::demo {

// clang-format off
/// The keys of a US layout. The values are those of GLFW: ASCII for printable keys.
enum class Key : int {
    space = 32, apostrophe = 39, comma = 44, minus = 45, period = 46, slash = 47,
    num_0 = 48, num_1, num_2, num_3, num_4, num_5, num_6, num_7, num_8, num_9,
    semicolon = 59, equal = 61,
    a = 65, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w, x, y, z,
    left_bracket = 91, backslash = 92, right_bracket = 93, grave = 96,
    escape = 256, enter, tab, backspace, insert, del, right, left, down, up,
    page_up, page_down, home, end,
    f1 = 290, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12,
    left_shift = 340, left_control, left_alt, left_super, right_shift, right_control, right_alt,
};
// clang-format on
constexpr std::size_t key_count = 349;

enum class MouseButton : int { left = 0, right = 1, middle = 2 };

/// The state of buttons. `pressed` and `released` hold the changes since the last poll. A key that was pressed and
/// released between two polls still counts as pressed once.
template <std::size_t count> struct Buttons {
    std::bitset<count> down;
    std::bitset<count> pressed;
    std::bitset<count> released;
};

/// A controller in the usual layout (names after an Xbox pad).
struct Gamepad {
    // clang-format off
    enum Button : int {
        a, b, x, y, left_bumper, right_bumper, back, start, guide, left_thumb, right_thumb,
        up, right, down, left,
    };
    // clang-format on
    bool connected = false;
    glm::vec2 left_stick{0}; ///< -1 .. 1, y up, small deflections are 0
    glm::vec2 right_stick{0};
    float left_trigger = 0; ///< 0 .. 1
    float right_trigger = 0;
    Buttons<15> buttons;
};

struct Input {
    Buttons<key_count> keys;
    Buttons<8> mouse;
    glm::vec2 cursor{0};        ///< pixels of the surface, from the top left
    glm::vec2 cursor_change{0}; ///< since the last poll [px]
    glm::vec2 scroll{0};        ///< wheel steps since the last poll, y up
    std::array<Gamepad, 4> gamepads;

    bool down(Key key) const { return keys.down[static_cast<std::size_t>(key)]; }
    bool pressed(Key key) const { return keys.pressed[static_cast<std::size_t>(key)]; }
    bool down(MouseButton button) const { return mouse.down[static_cast<std::size_t>(button)]; }
    bool pressed(MouseButton button) const { return mouse.pressed[static_cast<std::size_t>(button)]; }
    bool released(MouseButton button) const { return mouse.released[static_cast<std::size_t>(button)]; }
};

} // namespace lockstone::demo
