#pragma once
/// The camera of a view: free, or behind a player.

#include "render/camera.h"
#include "render/input.h"
#include "scene_view.h"

#include <optional>

namespace lockstone::demo {

class CameraRig {
  public:
    /// Looks at all that `bounds` holds.
    void frame_scene(const Bounds& bounds);
    /// Stays behind a player; nothing flies freely.
    void follow(std::optional<std::uint32_t> player);
    const std::optional<std::uint32_t>& followed() const { return followed_; }

    /// C follows or lets go, Tab takes the next player, Home looks at everything. `letters_taken`: the letters belong
    /// to a player, so they must not fly the camera.
    void control(const Input& input, const SceneView& view, float height, float seconds, bool letters_taken);
    /// Moves with the followed player, smoothly.
    void update(const SceneView& view, float alpha, float seconds);

    const Camera& camera() const { return camera_; }

  private:
    Camera camera_;
    std::optional<std::uint32_t> followed_;
    bool arrived_ = false; ///< at the player, since it was chosen
};

} // namespace lockstone::demo
