#include "surface.h"

#include <epoxy/egl.h>

#include <array>
#include <cstdio>
#include <stdexcept>

namespace lockstone::demo {
namespace {

/// An error with the text "WHAT: EGL error 0x3008".
std::runtime_error egl_error(const std::string& what) {
    std::array<char, 32> code{};
    std::snprintf(code.data(), code.size(), "EGL error 0x%04x", static_cast<unsigned>(eglGetError()));
    return std::runtime_error("cannot draw off-screen: " + what + ": " + code.data());
}

/// Owns the display connection, the context and its pbuffer.
class EglContext {
  public:
    EglContext() { display_ = open_display(); }
    ~EglContext() {
        if (display_ == EGL_NO_DISPLAY) return;
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
        if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
        eglTerminate(display_);
    }
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    void make_current(bool debug) {
        if (eglInitialize(display_, nullptr, nullptr) != EGL_TRUE) throw egl_error("EGL does not start");
        if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) throw egl_error("EGL offers no desktop OpenGL");
        const EGLConfig config = choose_config();
        const std::array<EGLint, 9> attributes{
            EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
            // Older EGL has the debug flag only as an extension, so the list contains it only on demand.
            debug ? EGL_CONTEXT_FLAGS_KHR : EGL_NONE, EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR, EGL_NONE};
        context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, attributes.data());
        if (context_ == EGL_NO_CONTEXT) throw egl_error("no OpenGL 3.3 core context");
        // A context without a surface needs an extension; a pbuffer of one pixel works everywhere.
        if (!epoxy_has_egl_extension(display_, "EGL_KHR_surfaceless_context")) {
            const std::array<EGLint, 5> size{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
            surface_ = eglCreatePbufferSurface(display_, config, size.data());
            if (surface_ == EGL_NO_SURFACE) throw egl_error("no pbuffer");
        }
        if (eglMakeCurrent(display_, surface_, surface_, context_) != EGL_TRUE)
            throw egl_error("the context cannot be made current");
    }

  private:
    static EGLDisplay open_display() {
        // epoxy ends the process when a library is missing, so this check comes first.
        if (!epoxy_has_egl()) throw std::runtime_error("cannot draw off-screen: libEGL is not installed");
        EGLDisplay display = EGL_NO_DISPLAY;
        if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
            display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (display == EGL_NO_DISPLAY) display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
        if (display == EGL_NO_DISPLAY) throw egl_error("EGL has no display");
        return display;
    }

    EGLConfig choose_config() const {
        const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                           EGL_OPENGL_BIT, EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        if (eglChooseConfig(display_, wanted.data(), &config, 1, &count) != EGL_TRUE || count < 1)
            throw egl_error("no pixel format for OpenGL");
        return config;
    }

    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
    EGLSurface surface_ = EGL_NO_SURFACE;
};

class OffscreenSurface final : public Surface {
  public:
    explicit OffscreenSurface(const SurfaceOptions& options) {
        context_.make_current(options.debug);
        start(options.size, options.debug);
    }
    ~OffscreenSurface() override { stop(); }

    const Input& poll() override { return input_; }
    void present() override { glFlush(); }

  private:
    EglContext context_;
    Input input_;
};

} // namespace

std::unique_ptr<Surface> Surface::open_offscreen(const SurfaceOptions& options) {
    return std::make_unique<OffscreenSurface>(options);
}

} // namespace lockstone::demo
