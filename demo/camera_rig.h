#pragma once
/// The camera of a view. It shows the whole scene, follows a player, or is moved by hand.

#include "input_map.h"
#include "render/camera/camera.h"
#include "render/camera/input.h"
#include "view/scene_view.h"

#include <optional>

namespace lockstone::demo {

class CameraRig {
  public:
    /// Shows all moving bodies, and follows them as they spread.
    void frame_scene(const Bounds& bounds);
    /// Stays behind a player; empty: moved by hand.
    void follow(std::optional<std::uint32_t> player);
    const std::optional<std::uint32_t>& followed() const { return followed_; }

    /// C follows a player or stops following, Tab selects the next player, shift Home shows the whole scene.
    /// `letters_taken`: the letter keys drive a player, so they do not move the camera.
    void control(const Input& input, const SceneView& view, float height, float seconds, bool letters_taken);
    /// As above. With `people` (null: no person plays) the letter keys drive a player while the camera follows one, and
    /// move the camera otherwise.
    void control(const Input& input, const SceneView& view, float height, float seconds, InputMap* people);
    /// Moves the camera smoothly after its target.
    void update(const SceneView& view, float alpha, float seconds);

    const Camera& camera() const { return camera_; }

  private:
    struct Sphere {
        glm::vec3 centre{0};
        float radius = 1; ///< [m]
    };
    static Sphere around(const Bounds& bounds);
    void update_overview(const SceneView& view, float seconds);

    Camera camera_;
    std::optional<std::uint32_t> followed_;
    bool arrived_ = false; ///< has reached the player since it was selected
    bool overview_ = true; ///< shows the whole scene, until moved by hand
    Sphere aim_, seen_;    ///< of the overview: its target, its current state
};

} // namespace lockstone::demo
