#pragma once
/// The camera: position, direction and projection.

#include <glm/glm.hpp>

#include <optional>

namespace lockstone::demo {

/// A ray in world space; `direction` has length 1.
struct Ray {
    glm::vec3 origin{0};
    glm::vec3 direction{0, 0, -1};
};

/// Looks at `focus` from `distance` away. Right-handed, y up. It has no mode: orbit() turns around the focus
/// and look() turns around the eye, so a viewer can mix both ways of moving freely.
class Camera {
  public:
    Camera() = default;
    Camera(const glm::vec3& focus, float distance, float yaw, float pitch);

    void orbit(float yaw, float pitch); ///< [rad], the focus stays
    void look(float yaw, float pitch);  ///< [rad], the eye stays
    void zoom(float factor);            ///< multiplies the distance, kept within 0.2 .. 500 m
    void pan(const glm::vec2& offset);  ///< moves in the picture plane [m]: x right, y up
    void fly(const glm::vec3& offset);  ///< moves along the view's axes [m]: x right, y up, z forward

    /// Moves the camera so that a sphere fills the picture; the direction stays.
    void frame(const glm::vec3& centre, float radius);

    void set_focus(const glm::vec3& focus) { focus_ = focus; }
    void set_vertical_fov(float angle) { vertical_fov_ = angle; } ///< [rad]

    const glm::vec3& focus() const { return focus_; }
    float distance() const { return distance_; }
    glm::vec3 eye() const { return focus_ - distance_ * forward(); }
    glm::vec3 forward() const;
    glm::vec3 right() const;

    glm::mat4 view() const;
    /// `aspect` = width / height.
    glm::mat4 projection(float aspect) const;

    /// The ray through a pixel of a viewport of `size` pixels, counted from the top left.
    Ray ray(const glm::vec2& pixel, const glm::vec2& size) const;

    /// The pixel of a world point; empty if the point lies behind the eye.
    std::optional<glm::vec2> project(const glm::vec3& point, const glm::vec2& size) const;

  private:
    glm::vec3 focus_{0, 1, 0};
    float distance_ = 12; ///< eye to focus [m]
    float yaw_ = 0.6f;    ///< around y, 0 looks along -z [rad]
    float pitch_ = -0.4f; ///< negative looks down [rad]
    float vertical_fov_ = glm::radians(45.0f);
};

} // namespace lockstone::demo
