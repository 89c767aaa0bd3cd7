#include "markers.h"

#include <cstddef>

namespace lockstone::demo {

MarkerPainter::MarkerPainter(ResourceManager& resources)
    : shader_(resources.shader("marker", "marker")), array_(GlVertexArray::make()),
      buffer_(GlBuffer::make()) {
    glBindVertexArray(array_.get());
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    for (GLuint i = 0; i < 3; ++i) {
        glVertexAttribPointer(i, 4, GL_FLOAT, GL_FALSE, sizeof(Stroke),
                              reinterpret_cast<const void*>(i * sizeof(glm::vec4)));
        glEnableVertexAttribArray(i);
        glVertexAttribDivisor(i, 1);
    }
    glBindVertexArray(0);
    check_gl("MarkerPainter");
}

void MarkerPainter::draw(const Frame& frame, const glm::mat4& view_projection, const glm::vec2& viewport,
                         float pixel_scale) {
    strokes_.clear();
    for (const Line& line : frame.lines)
        strokes_.push_back({glm::vec4(line.from, line.width * pixel_scale), glm::vec4(line.to, 0),
                            glm::vec4(line.colour, 1)});
    // A point is a line of length 0: the shader's round caps make it a disc.
    for (const Point& point : frame.points)
        strokes_.push_back({glm::vec4(point.position, point.diameter * pixel_scale),
                            glm::vec4(point.position, 0), glm::vec4(point.colour, 1)});
    if (strokes_.empty()) return;

    glBindVertexArray(array_.get());
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(strokes_.size() * sizeof(Stroke)), strokes_.data(),
                 GL_STREAM_DRAW);
    shader_->use();
    shader_->set("view_projection", view_projection);
    shader_->set("viewport", viewport);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_FALSE);
    const auto count = static_cast<GLsizei>(strokes_.size());
    constexpr float hidden_opacity = 0.35f;
    for (const bool hidden : {true, false}) {
        glDepthFunc(hidden ? GL_GREATER : GL_LEQUAL);
        shader_->set("opacity", hidden ? hidden_opacity : 1.0f);
        glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, count);
    }
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glBindVertexArray(0);
    check_gl("MarkerPainter::draw");
}

} // namespace lockstone::demo
