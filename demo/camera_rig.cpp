#include "camera_rig.h"

#include "render/camera/camera_control.h"

#include <algorithm>
#include <cmath>

namespace lockstone::demo {
namespace {

constexpr float follow_distance = 13, follow_pitch = -0.5f;   ///< [m], [rad]
constexpr float overview_yaw = 0.6f, overview_pitch = -0.55f; ///< [rad]
/// Share of the radius: the overview rests while its target changes by less than this.
constexpr float slack = 0.15f;
/// The remaining distance shrinks as exp(-rate t) [1/s].
constexpr float follow_rate = 7, overview_rate = 1.5f;

} // namespace

CameraRig::Sphere CameraRig::around(const Bounds& bounds) {
    return {bounds.centre(), std::clamp(0.8f * bounds.radius(), 1.0f, 80.0f)};
}

void CameraRig::frame_scene(const Bounds& bounds) {
    followed_.reset();
    overview_ = true;
    aim_ = seen_ = around(bounds);
    camera_ = Camera(seen_.centre, 12, overview_yaw, overview_pitch);
    camera_.frame(seen_.centre, seen_.radius);
}

void CameraRig::follow(std::optional<std::uint32_t> player) {
    arrived_ = arrived_ && player == followed_;
    overview_ = false;
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
    const glm::vec3 focus = camera_.focus();
    const float distance = camera_.distance();
    drive_camera(camera_, mine, height, seconds);
    if (camera_.focus() != focus || camera_.distance() != distance) overview_ = false;
}

void CameraRig::control(const Input& input, const SceneView& view, float height, float seconds,
                        InputMap* people) {
    const bool letters_taken = people != nullptr && followed_.has_value();
    control(input, view, height, seconds, letters_taken);
    Input for_players = input;
    if (!letters_taken) for_players.keys = {};
    if (people != nullptr) people->poll(for_players, camera_);
}

void CameraRig::update(const SceneView& view, float alpha, float seconds) {
    if (overview_) update_overview(view, seconds);
    if (!followed_) return;
    const auto position = view.player_position(*followed_, alpha);
    if (!position) return;
    const glm::vec3 aim = *position + glm::vec3(0, 0.6f, 0);
    if (!arrived_) {
        // The camera starts behind the player, with the other bodies ahead.
        const glm::vec3 ahead = view.bounds().centre() - *position;
        camera_ = Camera(aim, follow_distance, std::atan2(-ahead.x, -ahead.z), follow_pitch);
        arrived_ = true;
    }
    camera_.set_focus(glm::mix(aim, camera_.focus(), std::exp(-follow_rate * seconds)));
}

void CameraRig::update_overview(const SceneView& view, float seconds) {
    const Sphere now = around(view.bounds());
    const float room = slack * aim_.radius;
    if (glm::distance(now.centre, aim_.centre) > room || std::abs(now.radius - aim_.radius) > room)
        aim_ = now;
    const float left = std::exp(-overview_rate * seconds);
    seen_.centre = glm::mix(aim_.centre, seen_.centre, left);
    seen_.radius = glm::mix(aim_.radius, seen_.radius, left);
    camera_.frame(seen_.centre, seen_.radius);
}

} // namespace lockstone::demo
