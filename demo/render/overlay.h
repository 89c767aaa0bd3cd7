#pragma once
/// Rectangles and text over the picture.

#include "font.h"
#include "frame.h"
#include "render/gl/gl.h"
#include "resource_manager.h"

#include <cstdint>
#include <map>

namespace lockstone::demo {

/// Draws a frame's rects, then its text, with a soft dark edge for legibility. Move-only.
class OverlayPainter {
  public:
    explicit OverlayPainter(ResourceManager& resources);

    /// Draws into the current target, whose viewport is that of the frame. `viewport` in pixels;
    /// `pixel_scale` is physical per design pixel.
    void draw(const Frame& frame, const glm::vec2& viewport, float pixel_scale);

    /// Width and height of a letter of `line_height` [physical px, all].
    glm::vec2 cell(float line_height) { return font(line_height).cell(); }

  private:
    struct Corner {
        glm::vec2 position; ///< [px]
        glm::vec2 uv;
        glm::vec4 colour;
    };

    const Font& font(float line_height);
    void add_quad(const glm::vec2& min, const glm::vec2& max, const GlyphBox& glyph, const glm::vec4& colour);
    void add_text(const TextLine& line, const Font& font, float pixel_scale);
    void flush(const Font& font);

    std::shared_ptr<const Shader> shader_;
    std::vector<std::uint8_t> ttf_;
    std::map<int, Font> fonts_; ///< by line height [px]
    GlVertexArray array_;
    GlBuffer buffer_;
    std::vector<Corner> corners_;
};

} // namespace lockstone::demo
