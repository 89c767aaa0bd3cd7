#pragma once
/// A drawing surface: a window (GLFW), or memory (EGL) without a display. It can read pixels and write PNG files.

#include "framebuffer.h"
#include "image.h"
#include "render/camera/input.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lockstone::demo {

struct SurfaceOptions {
    glm::ivec2 size{1280, 720}; ///< [px]; a window may be resized later
    std::string title = "Lockstone";
    bool vsync = true;
    bool debug = false; ///< collects messages of the driver, see Surface::gl_messages
};

/// Owns an OpenGL 3.3 core context and makes it current on the calling thread. All drawing goes to one framebuffer, so
/// reading pixels works alike for a window and off-screen. Only one may be open at a time; it must outlive every GL
/// object of its context.
class Surface {
  public:
    virtual ~Surface() = default;
    Surface(const Surface&) = delete;
    Surface& operator=(const Surface&) = delete;

    /// True if DISPLAY or WAYLAND_DISPLAY is set, so that a window may open.
    static bool display_available();

    /// A window through GLFW: resizable, with keyboard, mouse and gamepads. Throws std::runtime_error with
    /// the reason.
    static std::unique_ptr<Surface> open_window(const SurfaceOptions& options);

    /// Off-screen through EGL; Mesa's software renderer llvmpipe is sufficient. Throws std::runtime_error with the
    /// reason.
    static std::unique_ptr<Surface> open_offscreen(const SurfaceOptions& options);

    /// Handles events and changes of the window's size. Call once before each picture.
    virtual const Input& poll() = 0;

    /// Shows the picture; returns at once off-screen.
    virtual void present() = 0;

    /// True when the user asked to close the window.
    virtual bool close_requested() const { return false; }

    virtual void set_title(const std::string&) {}

    /// Physical pixels per design pixel: 2 on a screen of double density.
    virtual float pixel_scale() const { return 1; }

    /// [px], at least 1 x 1.
    const glm::ivec2& size() const { return target_->size(); }

    /// The render target of the renderer; no depth, no samples.
    const Framebuffer& target() const { return *target_; }

    Image read_pixels() const;

    /// Throws std::runtime_error if the file cannot be written.
    void write_png(const std::filesystem::path& path) const { demo::write_png(read_pixels(), path); }

    /// The driver's name and version, for logs.
    std::string description() const;

    /// Errors and warnings of the driver so far, with SurfaceOptions::debug; at most 64 are kept.
    const std::vector<std::string>& gl_messages() const { return messages_; }

  protected:
    Surface() = default;

    /// The derived class calls it once its context is current.
    void start(const glm::ivec2& size, bool debug);
    void resize(const glm::ivec2& size);
    /// The derived class calls it before it destroys its context.
    void stop() { target_.reset(); }

  private:
    std::optional<Framebuffer> target_;
    std::vector<std::string> messages_;
};

} // namespace lockstone::demo
