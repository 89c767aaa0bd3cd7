#include "camera.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace lockstone::demo {
namespace {

constexpr glm::vec3 up(0, 1, 0);
constexpr float pitch_limit = 1.55f;  ///< less than a right angle, at which yaw is undefined [rad]
constexpr float near_distance = 0.1f; ///< [m]
constexpr float far_distance = 2000;  ///< [m]

} // namespace

Camera::Camera(const glm::vec3& focus, float distance, float yaw, float pitch)
    : focus_(focus), distance_(distance), yaw_(yaw), pitch_(glm::clamp(pitch, -pitch_limit, pitch_limit)) {}

void Camera::orbit(float yaw, float pitch) {
    yaw_ = std::remainder(yaw_ + yaw, glm::two_pi<float>());
    pitch_ = glm::clamp(pitch_ + pitch, -pitch_limit, pitch_limit);
}

void Camera::look(float yaw, float pitch) {
    const glm::vec3 fixed = eye();
    orbit(yaw, pitch);
    focus_ = fixed + distance_ * forward();
}

void Camera::zoom(float factor) { distance_ = glm::clamp(distance_ * factor, 0.2f, 500.0f); }

void Camera::pan(const glm::vec2& offset) {
    focus_ += offset.x * right() + offset.y * glm::cross(right(), forward());
}

void Camera::fly(const glm::vec3& offset) {
    focus_ += offset.x * right() + offset.y * up + offset.z * forward();
}

void Camera::frame(const glm::vec3& centre, float radius) {
    focus_ = centre;
    distance_ = glm::clamp(1.1f * radius / std::sin(0.5f * vertical_fov_), 0.2f, 500.0f);
}

glm::vec3 Camera::forward() const {
    return {-std::sin(yaw_) * std::cos(pitch_), std::sin(pitch_), -std::cos(yaw_) * std::cos(pitch_)};
}

glm::vec3 Camera::right() const { return {std::cos(yaw_), 0, -std::sin(yaw_)}; }

glm::mat4 Camera::view() const { return glm::lookAt(eye(), focus_, up); }

glm::mat4 Camera::projection(float aspect) const {
    return glm::perspective(vertical_fov_, aspect, near_distance, far_distance);
}

Ray Camera::ray(const glm::vec2& pixel, const glm::vec2& size) const {
    const glm::vec2 ndc = (2.0f * pixel / size - 1.0f) * glm::vec2(1, -1);
    const glm::vec2 slope = ndc * std::tan(0.5f * vertical_fov_) * glm::vec2(size.x / size.y, 1);
    const glm::vec3 direction = forward() + slope.x * right() + slope.y * glm::cross(right(), forward());
    return {eye(), glm::normalize(direction)};
}

std::optional<glm::vec2> Camera::project(const glm::vec3& point, const glm::vec2& size) const {
    const glm::vec4 clip = projection(size.x / size.y) * view() * glm::vec4(point, 1);
    if (clip.w < near_distance) return std::nullopt;
    const glm::vec2 ndc(clip.x / clip.w, clip.y / clip.w);
    return (0.5f + 0.5f * ndc * glm::vec2(1, -1)) * size;
}

} // namespace lockstone::demo
