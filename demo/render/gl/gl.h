#pragma once
/// Owners of OpenGL names, and error checks. Every call needs a current context (see surface.h).

#include <epoxy/gl.h>

#include <string>
#include <string_view>
#include <utility>

namespace lockstone::demo {

/// Owns one OpenGL name and deletes it. Move-only; empty (name 0) by default. The context must outlive it.
template <class Kind> class GlHandle {
  public:
    GlHandle() = default;
    ~GlHandle() { reset(); }
    GlHandle(GlHandle&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    GlHandle& operator=(GlHandle&& other) noexcept {
        if (this != &other) {
            reset();
            name_ = std::exchange(other.name_, 0);
        }
        return *this;
    }
    GlHandle(const GlHandle&) = delete;
    GlHandle& operator=(const GlHandle&) = delete;

    /// Creates a name. The arguments are passed to the GL call (the stage of a shader).
    template <class... Arguments> static GlHandle make(Arguments... arguments) {
        GlHandle handle;
        handle.name_ = Kind::create(arguments...);
        return handle;
    }

    GLuint get() const { return name_; }
    explicit operator bool() const { return name_ != 0; }

    void reset() {
        if (name_ != 0) Kind::destroy(name_);
        name_ = 0;
    }

  private:
    GLuint name_ = 0;
};

struct BufferKind {
    static GLuint create();
    static void destroy(GLuint name);
};
struct VertexArrayKind {
    static GLuint create();
    static void destroy(GLuint name);
};
struct TextureKind {
    static GLuint create();
    static void destroy(GLuint name);
};
struct FramebufferKind {
    static GLuint create();
    static void destroy(GLuint name);
};
struct RenderbufferKind {
    static GLuint create();
    static void destroy(GLuint name);
};
struct StageKind {
    static GLuint create(GLenum stage);
    static void destroy(GLuint name);
};
struct ProgramKind {
    static GLuint create();
    static void destroy(GLuint name);
};

using GlBuffer = GlHandle<BufferKind>;
using GlVertexArray = GlHandle<VertexArrayKind>;
using GlTexture = GlHandle<TextureKind>;
using GlFramebuffer = GlHandle<FramebufferKind>;
using GlRenderbuffer = GlHandle<RenderbufferKind>;
using GlStage = GlHandle<StageKind>;
using GlProgram = GlHandle<ProgramKind>;

/// Clears the GL error flags and returns their names, comma separated; empty if there was none.
std::string take_gl_errors();

/// In builds without NDEBUG: throws std::runtime_error when a GL error is pending. Otherwise does nothing.
void check_gl(std::string_view where);

/// Live GL objects of this context, e.g. "2 buffers, 1 texture"; empty if there are none. For leak checks: tests each
/// name below 4096 in GL, so that no counters are needed.
std::string live_gl_objects();

} // namespace lockstone::demo
