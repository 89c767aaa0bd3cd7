#include "framebuffer.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace lockstone::demo {
namespace {

GlRenderbuffer attach(GLenum slot, GLenum format, const glm::ivec2& size, int samples) {
    GlRenderbuffer buffer = GlRenderbuffer::make();
    glBindRenderbuffer(GL_RENDERBUFFER, buffer.get());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, size.x, size.y);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, slot, GL_RENDERBUFFER, buffer.get());
    return buffer;
}

} // namespace

Framebuffer::Framebuffer(const glm::ivec2& size, int samples, Depth depth)
    : name_(GlFramebuffer::make()), size_(glm::max(size, glm::ivec2(1))) {
    GLint samples_max = 0;
    glGetIntegerv(GL_MAX_SAMPLES, &samples_max);
    samples = std::clamp(samples, 0, samples_max);
    glBindFramebuffer(GL_FRAMEBUFFER, name_.get());
    colour_ = attach(GL_COLOR_ATTACHMENT0, GL_RGBA8, size_, samples);
    if (depth == Depth::buffer) depth_ = attach(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, size_, samples);
    const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    const std::string errors = take_gl_errors();
    if (status != GL_FRAMEBUFFER_COMPLETE || !errors.empty())
        throw std::runtime_error("cannot make a framebuffer of " + std::to_string(size_.x) + " x " +
                                 std::to_string(size_.y) + " pixels with " + std::to_string(samples) +
                                 " samples: " + (errors.empty() ? "the driver does not support it" : errors));
}

void Framebuffer::bind() const {
    glBindFramebuffer(GL_FRAMEBUFFER, name_.get());
    glViewport(0, 0, size_.x, size_.y);
}

void Framebuffer::resolve_to(GLuint target) const {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, name_.get());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target);
    glBlitFramebuffer(0, 0, size_.x, size_.y, 0, 0, size_.x, size_.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, target);
}

} // namespace lockstone::demo
