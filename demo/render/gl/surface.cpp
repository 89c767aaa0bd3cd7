#include "surface.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace lockstone::demo {
namespace {

void APIENTRY record_message(GLenum, GLenum, GLuint, GLenum severity, GLsizei, const GLchar* text,
                             const void* user) {
    constexpr std::size_t messages_max = 64;
    auto* messages = static_cast<std::vector<std::string>*>(const_cast<void*>(user));
    if (severity == GL_DEBUG_SEVERITY_NOTIFICATION || messages->size() >= messages_max) return;
    messages->emplace_back(text);
}

std::string gl_string(GLenum name) {
    const GLubyte* text = glGetString(name);
    return text == nullptr ? "unknown" : reinterpret_cast<const char*>(text);
}

} // namespace

bool Surface::display_available() {
    const auto set = [](const char* name) {
        const char* value = std::getenv(name);
        return value != nullptr && *value != '\0';
    };
    return set("DISPLAY") || set("WAYLAND_DISPLAY");
}

void Surface::start(const glm::ivec2& size, bool debug) {
    if (epoxy_gl_version() < 33)
        throw std::runtime_error("OpenGL 3.3 is needed, but the driver offers " + gl_string(GL_VERSION));
    if (debug && epoxy_has_gl_extension("GL_KHR_debug")) {
        glEnable(GL_DEBUG_OUTPUT);
        glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        glDebugMessageCallback(record_message, &messages_);
    }
    resize(size);
}

void Surface::resize(const glm::ivec2& size) {
    target_.reset();
    target_.emplace(size, 0, Framebuffer::Depth::none);
    target_->bind();
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}

Image Surface::read_pixels() const {
    Image image{.width = size().x, .height = size().y};
    const std::size_t row = 4 * static_cast<std::size_t>(image.width);
    const auto rows = static_cast<std::size_t>(image.height);
    image.pixels.resize(row * rows);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target_->name());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
    // The rows of GL begin at the bottom.
    for (std::size_t y = 0; y < rows / 2; ++y) {
        std::uint8_t* upper = image.pixels.data() + y * row;
        std::swap_ranges(upper, upper + row, image.pixels.data() + (rows - 1 - y) * row);
    }
    // Blending leaves arbitrary alpha values; the picture is made opaque.
    for (std::size_t i = 3; i < image.pixels.size(); i += 4) image.pixels[i] = 255;
    check_gl("Surface::read_pixels");
    return image;
}

std::string Surface::description() const {
    return gl_string(GL_RENDERER) + ", OpenGL " + gl_string(GL_VERSION);
}

} // namespace lockstone::demo
