#include "camera_rig.h"

#include "render/camera_control.h"

#include <algorithm>
#include <cmath>

namespace lockstone::demo {
namespace {

constexpr float follow_distance = 13, follow_pitch = -0.5f; ///< [m], [rad]
constexpr float follow_rate =
    7; ///< the share of the way to the player that is left shrinks as exp(-rate t) [1/s]

} // namespace

void CameraRig::frame_scene(const Bounds& bounds) {
    followed_.reset();
    camera_ = Camera(bounds.centre(), 12, 0.6f, -0.42f);
    camera_.frame(bounds.centre(), std::clamp(0.85f * bounds.radius(), 2.0f, 80.0f));
}

void CameraRig::follow(std::optional<std::uint32_t> player) {
    if (player && !followed_) camera_ = Camera(camera_.focus(), follow_distance, 0.6f, follow_pitch);
    arrived_ = arrived_ && player == followed_;
    followed_ = player;
}

void CameraRig::control(const Input& input, const SceneView& view, float height, float seconds,
                        bool letters_taken) {
    const std::uint32_t players = view.player_count();
    if (input.pressed(Key::c) && players != 0)
        follow(followed_ ? std::nullopt : std::optional<std::uint32_t>(0));
    if (input.pressed(Key::tab) && players != 0) follow(followed_ ? (*followed_ + 1) % players : 0);
    if (input.pressed(Key::home) && input.down(Key::left_shift)) frame_scene(view.bounds());
    Input mine = input;
    if (followed_ || letters_taken) mine.keys = {};
    drive_camera(camera_, mine, height, seconds);
}

void CameraRig::update(const SceneView& view, float alpha, float seconds) {
    if (!followed_) return;
    const auto position = view.player_position(*followed_, alpha);
    if (!position) return;
    const glm::vec3 aim = *position + glm::vec3(0, 0.6f, 0);
    const float left = arrived_ ? std::exp(-follow_rate * seconds) : 0.0f;
    camera_.set_focus(glm::mix(aim, camera_.focus(), left));
    arrived_ = true;
}

} // namespace lockstone::demo
