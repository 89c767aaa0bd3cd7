#include "surface.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <stdexcept>

namespace lockstone::demo {
namespace {

static_assert(static_cast<int>(Key::end) == GLFW_KEY_END && static_cast<int>(Key::f12) == GLFW_KEY_F12 &&
              static_cast<int>(Key::right_alt) == GLFW_KEY_RIGHT_ALT && key_count == GLFW_KEY_LAST + 1);

std::runtime_error window_error(const std::string& what) {
    const char* reason = nullptr;
    glfwGetError(&reason);
    return std::runtime_error("cannot open a window: " + what + (reason ? ": " + std::string(reason) : ""));
}

/// Initialises GLFW and terminates it.
struct GlfwLibrary {
    GlfwLibrary() {
        if (glfwInit() != GLFW_TRUE) throw window_error("GLFW does not start");
    }
    ~GlfwLibrary() { glfwTerminate(); }
    GlfwLibrary(const GlfwLibrary&) = delete;
    GlfwLibrary& operator=(const GlfwLibrary&) = delete;
};

using WindowHandle = std::unique_ptr<GLFWwindow, void (*)(GLFWwindow*)>;

WindowHandle make_window(const SurfaceOptions& options) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, options.debug ? GLFW_TRUE : GLFW_FALSE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    const glm::ivec2 size = glm::max(options.size, glm::ivec2(1));
    WindowHandle window(glfwCreateWindow(size.x, size.y, options.title.c_str(), nullptr, nullptr),
                        glfwDestroyWindow);
    if (!window) throw window_error("no OpenGL 3.3 core context");
    return window;
}

template <std::size_t count> void set_button(Buttons<count>& buttons, int index, int action) {
    if (index < 0 || static_cast<std::size_t>(index) >= count || action == GLFW_REPEAT) return;
    const auto bit = static_cast<std::size_t>(index);
    buttons.down[bit] = action == GLFW_PRESS;
    (action == GLFW_PRESS ? buttons.pressed : buttons.released).set(bit);
}

/// In GLFW the y axis of sticks points down, and sticks at rest are not exactly 0.
glm::vec2 stick(const float* axes) {
    constexpr float dead_zone = 0.15f;
    const glm::vec2 raw(axes[0], -axes[1]);
    const float length = glm::length(raw);
    if (length < dead_zone) return glm::vec2(0);
    return raw / length * std::min((length - dead_zone) / (1 - dead_zone), 1.0f);
}

void read_gamepad(int slot, Gamepad& pad) {
    GLFWgamepadstate state{};
    pad.connected = glfwGetGamepadState(slot, &state) == GLFW_TRUE;
    const Buttons<15> before = pad.buttons;
    // An unplugged gamepad reads as all zero, so that no button stays pressed.
    for (std::size_t i = 0; i < pad.buttons.down.size(); ++i)
        pad.buttons.down[i] = pad.connected && state.buttons[i] == GLFW_PRESS;
    pad.buttons.pressed = pad.buttons.down & ~before.down;
    pad.buttons.released = ~pad.buttons.down & before.down;
    pad.left_stick = pad.connected ? stick(state.axes + GLFW_GAMEPAD_AXIS_LEFT_X) : glm::vec2(0);
    pad.right_stick = pad.connected ? stick(state.axes + GLFW_GAMEPAD_AXIS_RIGHT_X) : glm::vec2(0);
    pad.left_trigger = pad.connected ? 0.5f + 0.5f * state.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER] : 0.0f;
    pad.right_trigger = pad.connected ? 0.5f + 0.5f * state.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] : 0.0f;
}

class WindowSurface final : public Surface {
  public:
    explicit WindowSurface(const SurfaceOptions& options) : window_(make_window(options)) {
        glfwMakeContextCurrent(window_.get());
        glfwSwapInterval(options.vsync ? 1 : 0);
        listen();
        start(framebuffer_size(), options.debug);
    }
    ~WindowSurface() override { stop(); }

    const Input& poll() override;
    void present() override;

    bool close_requested() const override { return glfwWindowShouldClose(window_.get()) == GLFW_TRUE; }
    void set_title(const std::string& title) override { glfwSetWindowTitle(window_.get(), title.c_str()); }
    float pixel_scale() const override {
        float x = 1, y = 1;
        glfwGetWindowContentScale(window_.get(), &x, &y);
        return std::max({x, y, 1.0f});
    }

  private:
    static Input& input_of(GLFWwindow* window) {
        return static_cast<WindowSurface*>(glfwGetWindowUserPointer(window))->input_;
    }

    void listen();
    void poll_cursor();

    glm::ivec2 framebuffer_size() const {
        glm::ivec2 size(1);
        glfwGetFramebufferSize(window_.get(), &size.x, &size.y);
        return size;
    }

    GlfwLibrary library_;
    WindowHandle window_;
    Input input_;
    bool cursor_known_ = false;
};

void WindowSurface::listen() {
    glfwSetWindowUserPointer(window_.get(), this);
    glfwSetKeyCallback(window_.get(), [](GLFWwindow* window, int key, int, int action, int) {
        set_button(input_of(window).keys, key, action);
    });
    glfwSetMouseButtonCallback(window_.get(), [](GLFWwindow* window, int button, int action, int) {
        set_button(input_of(window).mouse, button, action);
    });
    glfwSetScrollCallback(window_.get(), [](GLFWwindow* window, double x, double y) {
        input_of(window).scroll += glm::vec2(x, y);
    });
}

void WindowSurface::poll_cursor() {
    double x = 0, y = 0;
    glfwGetCursorPos(window_.get(), &x, &y);
    glm::ivec2 window_size(1);
    glfwGetWindowSize(window_.get(), &window_size.x, &window_size.y);
    // Cursor positions are in screen coordinates, which are not pixels on some systems.
    const glm::vec2 cursor =
        glm::vec2(x, y) * glm::vec2(size()) / glm::vec2(glm::max(window_size, glm::ivec2(1)));
    input_.cursor_change = cursor_known_ ? cursor - input_.cursor : glm::vec2(0);
    input_.cursor = cursor;
    cursor_known_ = true;
}

const Input& WindowSurface::poll() {
    input_.keys.pressed.reset();
    input_.keys.released.reset();
    input_.mouse.pressed.reset();
    input_.mouse.released.reset();
    input_.scroll = glm::vec2(0);
    glfwPollEvents();
    const glm::ivec2 wanted = framebuffer_size();
    // A minimised window has no pixels; it keeps its last target.
    if (wanted.x > 0 && wanted.y > 0 && wanted != size()) resize(wanted);
    poll_cursor();
    for (std::size_t i = 0; i < input_.gamepads.size(); ++i)
        read_gamepad(GLFW_JOYSTICK_1 + static_cast<int>(i), input_.gamepads[i]);
    return input_;
}

void WindowSurface::present() {
    target().resolve_to(0);
    glfwSwapBuffers(window_.get());
}

} // namespace

std::unique_ptr<Surface> Surface::open_window(const SurfaceOptions& options) {
    return std::make_unique<WindowSurface>(options);
}

} // namespace lockstone::demo
