#include "gl.h"

#include <stdexcept>

namespace lockstone::demo {
namespace {

const char* error_name(GLenum code) {
    switch (code) {
    case GL_INVALID_ENUM:
        return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
        return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
        return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
        return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
        return "GL_OUT_OF_MEMORY";
    default:
        return "unknown GL error";
    }
}

void append_item(std::string& list, const std::string& item) {
    if (!list.empty()) list += ", ";
    list += item;
}

} // namespace

GLuint BufferKind::create() {
    GLuint name = 0;
    glGenBuffers(1, &name);
    return name;
}
void BufferKind::destroy(GLuint name) { glDeleteBuffers(1, &name); }

GLuint VertexArrayKind::create() {
    GLuint name = 0;
    glGenVertexArrays(1, &name);
    return name;
}
void VertexArrayKind::destroy(GLuint name) { glDeleteVertexArrays(1, &name); }

GLuint TextureKind::create() {
    GLuint name = 0;
    glGenTextures(1, &name);
    return name;
}
void TextureKind::destroy(GLuint name) { glDeleteTextures(1, &name); }

GLuint FramebufferKind::create() {
    GLuint name = 0;
    glGenFramebuffers(1, &name);
    return name;
}
void FramebufferKind::destroy(GLuint name) { glDeleteFramebuffers(1, &name); }

GLuint RenderbufferKind::create() {
    GLuint name = 0;
    glGenRenderbuffers(1, &name);
    return name;
}
void RenderbufferKind::destroy(GLuint name) { glDeleteRenderbuffers(1, &name); }

GLuint StageKind::create(GLenum stage) { return glCreateShader(stage); }
void StageKind::destroy(GLuint name) { glDeleteShader(name); }

GLuint ProgramKind::create() { return glCreateProgram(); }
void ProgramKind::destroy(GLuint name) { glDeleteProgram(name); }

std::string take_gl_errors() {
    std::string errors;
    // A lost context may report errors endlessly, so the loop is bounded.
    for (int i = 0; i < 16; ++i) {
        const GLenum code = glGetError();
        if (code == GL_NO_ERROR) break;
        append_item(errors, error_name(code));
    }
    return errors;
}

void check_gl([[maybe_unused]] std::string_view where) {
#ifndef NDEBUG
    const std::string errors = take_gl_errors();
    if (!errors.empty()) throw std::runtime_error("OpenGL failed in " + std::string(where) + ": " + errors);
#endif
}

std::string live_gl_objects() {
    constexpr GLuint name_end = 4096;
    int buffers = 0, arrays = 0, textures = 0, framebuffers = 0, renderbuffers = 0, stages = 0, programs = 0;
    for (GLuint name = 1; name < name_end; ++name) {
        buffers += glIsBuffer(name);
        arrays += glIsVertexArray(name);
        textures += glIsTexture(name);
        framebuffers += glIsFramebuffer(name);
        renderbuffers += glIsRenderbuffer(name);
        stages += glIsShader(name);
        programs += glIsProgram(name);
    }
    std::string list;
    const auto report = [&list](int count, const char* noun) {
        if (count != 0) append_item(list, std::to_string(count) + " " + noun + (count == 1 ? "" : "s"));
    };
    report(buffers, "buffer");
    report(arrays, "vertex array");
    report(textures, "texture");
    report(framebuffers, "framebuffer");
    report(renderbuffers, "renderbuffer");
    report(stages, "shader stage");
    report(programs, "program");
    return list;
}

} // namespace lockstone::demo
