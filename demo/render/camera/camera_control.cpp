#include "camera_control.h"

#include <algorithm>
#include <cmath>

namespace lockstone::demo {

void drive_camera(Camera& camera, const Input& input, float viewport_height, float seconds) {
    const glm::vec2 drag = input.cursor_change / std::max(viewport_height, 1.0f);
    constexpr float turn_per_height = 3.0f; // [rad]
    if (input.down(MouseButton::right)) camera.orbit(-turn_per_height * drag.x, -turn_per_height * drag.y);
    // A drag over the height of the picture moves the focus by about the height of the visible area there.
    if (input.down(MouseButton::middle)) camera.pan(camera.distance() * glm::vec2(-drag.x, drag.y));
    if (input.scroll.y != 0) camera.zoom(std::pow(0.88f, input.scroll.y));

    const auto axis = [&](Key plus, Key minus) {
        return static_cast<float>(input.down(plus)) - static_cast<float>(input.down(minus));
    };
    const glm::vec3 wish(axis(Key::d, Key::a), axis(Key::e, Key::q), axis(Key::w, Key::s));
    if (wish == glm::vec3(0)) return;
    const float speed =
        (input.down(Key::left_shift) ? 3.0f : 1.0f) * std::max(camera.distance(), 4.0f); // [m/s]
    camera.fly(glm::normalize(wish) * speed * seconds);
}

} // namespace lockstone::demo
