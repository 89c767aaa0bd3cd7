#include "overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace lockstone::demo {

OverlayPainter::OverlayPainter(ResourceManager& resources)
    : shader_(resources.shader("overlay", "overlay")), ttf_(read_file(resources.asset_path("mono.ttf"))),
      array_(GlVertexArray::make()), buffer_(GlBuffer::make()) {
    glBindVertexArray(array_.get());
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    const auto attribute = [](GLuint index, GLint floats, std::size_t offset) {
        glVertexAttribPointer(index, floats, GL_FLOAT, GL_FALSE, sizeof(Corner),
                              reinterpret_cast<const void*>(offset));
        glEnableVertexAttribArray(index);
    };
    attribute(0, 2, offsetof(Corner, position));
    attribute(1, 2, offsetof(Corner, uv));
    attribute(2, 4, offsetof(Corner, colour));
    glBindVertexArray(0);
    check_gl("OverlayPainter");
}

const Font& OverlayPainter::font(float line_height) {
    constexpr std::size_t fonts_max = 16;
    const int height = std::clamp(static_cast<int>(std::lround(line_height)), 6, 200);
    const auto found = fonts_.find(height);
    if (found != fonts_.end()) return found->second;
    // Limits the memory if the size of a text changes continuously.
    if (fonts_.size() == fonts_max) fonts_.clear();
    return fonts_.try_emplace(height, ttf_, height).first->second;
}

void OverlayPainter::add_quad(const glm::vec2& min, const glm::vec2& max, const GlyphBox& glyph,
                              const glm::vec4& colour) {
    const Corner a{min, glyph.min, colour};
    const Corner b{{max.x, min.y}, {glyph.max.x, glyph.min.y}, colour};
    const Corner c{max, glyph.max, colour};
    const Corner d{{min.x, max.y}, {glyph.min.x, glyph.max.y}, colour};
    for (const Corner& corner : {a, b, c, a, c, d}) corners_.push_back(corner);
}

void OverlayPainter::add_text(const TextLine& line, const Font& font, float pixel_scale) {
    const glm::vec2 cell(font.cell());
    const glm::vec2 start = glm::round(line.position * pixel_scale);
    const float edge = std::max(1.0f, std::round(pixel_scale));
    const glm::vec4 shade(0, 0, 0, 0.55f * line.colour.a);
    // All shadows come before all letters, so that a shadow does not darken the neighbouring letter.
    for (const bool shading : {true, false}) {
        glm::vec2 pen = start;
        for (std::string_view rest = line.text; !rest.empty();) {
            const char32_t code = take_code_point(rest);
            if (code == U'\n') {
                pen = {start.x, pen.y + cell.y};
                continue;
            }
            if (code != U' ') {
                const GlyphBox& glyph = font.glyph(code);
                const glm::vec2 corner = shading ? pen + edge : pen;
                add_quad(corner, corner + cell, glyph, shading ? shade : line.colour);
            }
            pen.x += cell.x;
        }
    }
}

void OverlayPainter::flush(const Font& font) {
    if (corners_.empty()) return;
    font.texture().bind(0);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners_.size() * sizeof(Corner)), corners_.data(),
                 GL_STREAM_DRAW);
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners_.size()));
    corners_.clear();
}

void OverlayPainter::draw(const Frame& frame, const glm::vec2& viewport, float pixel_scale) {
    if (frame.rects.empty() && frame.text.empty()) return;
    glBindVertexArray(array_.get());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    shader_->use();
    shader_->set("viewport", viewport);
    shader_->set("glyphs", 0);

    const Font& plain = font(TextLine{}.height * pixel_scale);
    for (const Rect& rect : frame.rects) {
        const glm::vec2 corner = rect.position * pixel_scale;
        add_quad(corner, corner + rect.size * pixel_scale, {plain.white(), plain.white()}, rect.colour);
    }
    flush(plain);
    for (std::size_t i = 0; i < frame.text.size(); ++i) {
        const float height = frame.text[i].height;
        const Font& current = font(height * pixel_scale);
        const TextLine& line = frame.text[i];
        if (!line.yields || !touches(line, glm::vec2(current.cell()) / pixel_scale, frame.rects))
            add_text(line, current, pixel_scale);
        if (i + 1 == frame.text.size() || frame.text[i + 1].height != height) flush(current);
    }
    glDisable(GL_BLEND);
    glBindVertexArray(0);
    check_gl("OverlayPainter::draw");
}

} // namespace lockstone::demo
