#pragma once
/// Draws lines and points over the scene.

#include "frame.h"
#include "render/gl/gl.h"
#include "resource_manager.h"

namespace lockstone::demo {

/// Draws lines and points of any width, which core OpenGL does not guarantee. Move-only.
class MarkerPainter {
  public:
    explicit MarkerPainter(ResourceManager& resources);

    /// Draws into the current target: first faintly over everything, then opaque where no surface hides it. `viewport`
    /// in pixels; `pixel_scale` is physical per design pixel.
    void draw(const Frame& frame, const glm::mat4& view_projection, const glm::vec2& viewport,
              float pixel_scale);

  private:
    struct Stroke {
        glm::vec4 from_width;
        glm::vec4 to;
        glm::vec4 colour;
    };

    std::shared_ptr<const Shader> shader_;
    GlVertexArray array_;
    GlBuffer buffer_;
    std::vector<Stroke> strokes_;
};

} // namespace lockstone::demo
