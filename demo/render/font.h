#pragma once
/// Glyphs of a monospace font as a texture.

#include "render/gl/texture.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <map>
#include <span>
#include <string_view>

namespace lockstone::demo {

/// Texture coordinates of one cell of the atlas.
struct GlyphBox {
    glm::vec2 min{0};
    glm::vec2 max{0};
};

/// All glyphs of one size, in cells of equal size, to be drawn at whole pixels without scaling. Move-only.
class Font {
  public:
    /// `ttf` is the content of a monospace TrueType file, `line_height` the height of a cell [px], at
    /// least 6. Throws std::runtime_error if it is no font.
    Font(std::span<const std::uint8_t> ttf, int line_height);

    /// Width and height of a cell [px].
    const glm::ivec2& cell() const { return cell_; }

    /// The glyph of a Unicode code point, or that of '?'.
    const GlyphBox& glyph(char32_t code) const;

    /// A white spot of the atlas, for filled rectangles.
    const glm::vec2& white() const { return white_; }

    const Texture& texture() const { return texture_; }

  private:
    struct Atlas;
    explicit Font(const Atlas& atlas);
    static Atlas draw(std::span<const std::uint8_t> ttf, int line_height);

    glm::ivec2 cell_;
    glm::vec2 white_;
    std::map<char32_t, GlyphBox> glyphs_;
    Texture texture_;
};

/// Removes the first code point from `text`, which must not be empty. Malformed UTF-8 returns U+FFFD and removes one
/// byte.
char32_t take_code_point(std::string_view& text);

} // namespace lockstone::demo
