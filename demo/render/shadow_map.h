#pragma once
/// The shadow map: the depth of the scene as seen from the sun.

#include "render/gl/gl.h"

#include <glm/glm.hpp>

#include <span>

namespace lockstone::demo {

/// A square depth texture, and a camera in the direction of the sun that covers the scene. Move-only.
class ShadowMap {
  public:
    static constexpr int resolution = 2048; ///< [px]

    ShadowMap();

    /// Fits the map around `spheres` (centre xyz, radius w) [m]. It ignores spheres that are not completely within
    /// `distance` of `focus`. `to_sun` has length 1.
    void fit(std::span<const glm::vec4> spheres, const glm::vec3& to_sun, const glm::vec3& focus,
             float distance);

    /// Makes it the render target and clears it; end() restores all changed state except the target.
    void begin() const;
    void end() const;

    /// Binds the depth to texture unit `unit`, for a sampler2DShadow.
    void bind(int unit) const;

    /// The transform from world to the sun's clip space.
    const glm::mat4& matrix() const { return matrix_; }

    /// Width of one texel [m].
    float texel() const { return texel_; }

  private:
    GlTexture depth_;
    GlFramebuffer framebuffer_;
    glm::mat4 matrix_{1};
    float texel_ = 0.01f;
};

} // namespace lockstone::demo
