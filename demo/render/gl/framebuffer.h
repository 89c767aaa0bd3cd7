#pragma once
/// A framebuffer with colour, samples and depth.

#include "gl.h"

#include <glm/glm.hpp>

namespace lockstone::demo {

/// RGBA8 colour with optional samples and depth. Move-only.
class Framebuffer {
  public:
    enum class Depth { none, buffer };

    /// `size` in pixels, at least 1 x 1. `samples` of 0 means no multisampling; larger values are limited to the
    /// driver's maximum. Throws std::runtime_error if the driver refuses.
    Framebuffer(const glm::ivec2& size, int samples, Depth depth);

    /// Makes it the render target and sets the viewport to its size.
    void bind() const;

    /// Copies the colour to `target` of the same size, averaging samples.
    void resolve_to(GLuint target) const;

    GLuint name() const { return name_.get(); }
    const glm::ivec2& size() const { return size_; }

  private:
    GlFramebuffer name_;
    GlRenderbuffer colour_;
    GlRenderbuffer depth_;
    glm::ivec2 size_;
};

} // namespace lockstone::demo
