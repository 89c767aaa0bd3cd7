#pragma once
/// The camera of a view: it sees everything, follows a player, or is flown by hand.

#include "input_map.h"
#include "render/camera/camera.h"
#include "render/camera/input.h"
#include "view/scene_view.h"

#include <optional>

namespace lockstone::demo {

class CameraRig {
  public:
    /// Looks at all that moves, and goes on doing so as it spreads.
    void frame_scene(const Bounds& bounds);
    /// Stays behind a player; nothing: flown by hand.
    void follow(std::optional<std::uint32_t> player);
    const std::optional<std::uint32_t>& followed() const { return followed_; }

    /// C follows or lets go, Tab takes the next player, shift Home sees everything. `letters_taken`: the
    /// letters belong to a player, so they must not fly the camera.
    void control(const Input& input, const SceneView& view, float height, float seconds, bool letters_taken);
    /// Where `people` may play (null: nobody does) the letters are theirs while a player is followed, and fly the camera else.
    void control(const Input& input, const SceneView& view, float height, float seconds, InputMap* people);
    /// Moves with what it looks at, smoothly.
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
    bool arrived_ = false; ///< at the player, since it was chosen
    bool overview_ = true; ///< sees everything, until flown by hand
    Sphere aim_, seen_;    ///< of the overview: where it is going, where it is
};

} // namespace lockstone::demo
