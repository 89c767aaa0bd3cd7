/// Draws test pictures and checks that OpenGL reports no error and that no GL object is left.
///   render_check OUT_DIR [--window]
/// Writes scene.png, wireframe.png, split.png, close.png, wide.png and edge_cases.png. Off-screen unless
/// --window is given. Exit status: 0 good, 1 a check failed, 2 bad usage or no OpenGL.

#include "render/renderer.h"

#include <glm/gtc/matrix_transform.hpp>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string_view>

namespace {

using namespace lockstone::demo;

glm::mat4 pose(const glm::vec3& position, float angle = 0, const glm::vec3& axis = {0, 1, 0}) {
    return glm::rotate(glm::translate(glm::mat4(1), position), angle, glm::normalize(axis));
}

constexpr glm::vec3 ground_colour(0.66f, 0.66f, 0.64f);
constexpr glm::vec4 white(0.96f, 0.97f, 0.98f, 1), grey(0.72f, 0.76f, 0.80f, 1),
    green(0.55f, 0.90f, 0.55f, 1), amber(1.0f, 0.80f, 0.35f, 1), red(1.0f, 0.48f, 0.42f, 1);

void add_ground(Frame& frame) {
    frame.instances.push_back(
        {.kind = ShapeKind::plane, .size = {400, 0, 400}, .pose = glm::mat4(1), .colour = ground_colour});
}

/// A pyramid of boxes at `base`, with the contacts between its rows.
void add_pyramid(Frame& frame, const glm::vec3& base, int rows, bool contacts) {
    constexpr float half = 0.45f;
    std::uint32_t index = 0;
    for (int row = 0; row < rows; ++row) {
        for (int i = 0; i < rows - row; ++i) {
            const float x =
                (static_cast<float>(i) - 0.5f * static_cast<float>(rows - row - 1)) * 2.12f * half;
            const glm::vec3 centre = base + glm::vec3(x, half + 2 * half * static_cast<float>(row), 0);
            frame.instances.push_back({.kind = ShapeKind::box,
                                       .size = glm::vec3(half),
                                       .pose = pose(centre, 0.03f * static_cast<float>(index % 5) - 0.06f),
                                       .colour = palette_colour(index)});
            ++index;
            if (!contacts) continue;
            for (const float side : {-0.8f, 0.8f}) {
                const glm::vec3 at = centre + glm::vec3(side * half, -half, half);
                frame.points.push_back({.position = at, .colour = {1, 0.85f, 0.2f}});
                frame.lines.push_back(
                    {.from = at, .to = at + glm::vec3(0, 0.4f, 0), .colour = {0.2f, 1, 0.4f}});
            }
        }
    }
}

void add_round_shapes(Frame& frame) {
    const auto add = [&](ShapeKind kind, const glm::vec3& size, const glm::mat4& at, std::uint32_t colour) {
        frame.instances.push_back({.kind = kind, .size = size, .pose = at, .colour = palette_colour(colour)});
    };
    const float down = glm::half_pi<float>();
    add(ShapeKind::sphere, {0.9f, 0, 0}, pose({3.6f, 0.9f, 2.6f}, 0.7f, {1, 1, 0}), 1);
    add(ShapeKind::sphere, {0.45f, 0, 0}, pose({2.3f, 0.45f, 3.4f}, 1.9f, {0, 1, 1}), 2);
    add(ShapeKind::sphere, {0.25f, 0, 0}, pose({1.5f, 2.6f, 2.9f}), 0);
    add(ShapeKind::capsule, {0.4f, 0.7f, 0}, pose({-3.7f, 1.1f, 1.4f}), 3);
    add(ShapeKind::capsule, {0.3f, 0.9f, 0}, pose({-2.2f, 0.3f, 3.2f}, down, {1, 0, 0.4f}), 4);
    add(ShapeKind::capsule, {0.22f, 0.1f, 0}, pose({-0.6f, 0.32f, 3.6f}), 7);
    add(ShapeKind::cylinder, {0.5f, 0.6f, 0}, pose({5.6f, 0.6f, 0.4f}), 6);
    add(ShapeKind::cylinder, {0.35f, 0.8f, 0}, pose({0.7f, 0.35f, 4.6f}, down, {0.3f, 0, 1}), 5);
    add(ShapeKind::cone, {0.6f, 0.7f, 0}, pose({-5.4f, 0.7f, 0.2f}), 2);
    add(ShapeKind::box, {2.0f, 0.06f, 0.8f}, pose({6.0f, 0.72f, 3.4f}, 0.35f, {0, 0, 1}), 8);
    frame.instances.back().highlight = 1;
}

void add_crates(Frame& frame, ResourceManager& resources) {
    const auto crate = resources.model("crate.obj");
    frame.objects.emplace_back(crate, pose({-4.8f, 0.5f, 3.8f}, 0.4f));
    frame.objects.emplace_back(crate, pose({-5.9f, 0.5f, 3.1f}, -0.2f));
    frame.objects.emplace_back(crate, pose({-5.3f, 1.5f, 3.5f}, 0.15f));
    frame.objects.emplace_back(crate, glm::scale(pose({-6.6f, 0.35f, 4.6f}, 0.9f), glm::vec3(0.7f)));
    frame.objects.back().set_tint({0.75f, 0.85f, 1.0f});
}

void add_panel(Frame& frame, const char* title, const glm::vec4& title_colour) {
    frame.rects.push_back({.position = {12, 12}, .size = {346, 136}, .colour = {0.06f, 0.08f, 0.11f, 0.62f}});
    const auto say = [&](const char* text, float y, const glm::vec4& colour) {
        frame.text.push_back({.text = text, .position = {24, y}, .colour = colour});
    };
    frame.text.push_back({.text = title, .position = {24, 18}, .colour = title_colour, .height = 24});
    say("tick       1 204   (rolled back 6)", 48, white);
    say("hash       9f3c 21d0 77ab e415", 66, grey);
    say("tick time  312 \u00b5s   save 4.1 \u00b5s", 84, grey);
    say("\u2713 in sync with peer 2", 102, green);
    say("\u25b6 \u2190 \u2192  0.25\u00d7  \u00b1 3 ticks \u2026", 120, amber);
}

Frame make_scene(ResourceManager& resources, bool contacts) {
    Frame frame;
    frame.camera = Camera({0, 1.3f, 1.2f}, 15, 0.42f, -0.32f);
    add_ground(frame);
    add_pyramid(frame, {0.6f, 0, -0.6f}, 6, contacts);
    add_round_shapes(frame);
    add_crates(frame, resources);
    add_panel(frame, "pyramid", white);
    return frame;
}

/// Hundreds of bodies on a floor that is a box, and a generated terrain: the largest shadow map.
Frame make_wide(ResourceManager& resources) {
    MeshData terrain;
    constexpr int side = 40;
    const auto height = [](float x, float z) {
        return 2.2f + 1.6f * std::sin(0.35f * x) * std::cos(0.27f * z);
    };
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const float x = static_cast<float>(i) - 20, z = static_cast<float>(j) - 58;
            const float slope_x = height(x + 0.1f, z) - height(x - 0.1f, z);
            const float slope_z = height(x, z + 0.1f) - height(x, z - 0.1f);
            terrain.vertices.push_back({.anchor = {x, height(x, z), z},
                                        .normal = glm::normalize(glm::vec3(-slope_x, 0.2f, -slope_z))});
            const auto a = static_cast<std::uint32_t>(j * side + i);
            if (i + 1 < side && j + 1 < side)
                terrain.indices.insert(terrain.indices.end(),
                                       {a, a + side, a + side + 1, a, a + side + 1, a + 1});
        }
    }
    const Material grass{.colour = {0.52f, 0.62f, 0.42f}, .roughness = 0.9f};
    Frame frame;
    frame.camera = Camera({0, 0, -6}, 52, 0.5f, -0.42f);
    frame.objects.emplace_back(resources.add_model("terrain", Model::from_mesh(terrain, grass)));
    frame.instances.push_back({.size = {26, 0.5f, 17}, .pose = pose({0, -0.5f, 0}), .colour = ground_colour});
    for (int i = 0; i < 480; ++i) {
        const float x = static_cast<float>(i % 30) * 1.6f - 23, z = static_cast<float>(i / 30) * 1.9f - 14;
        const auto kind = static_cast<ShapeKind>(i % 5);
        const float base = kind == ShapeKind::capsule ? 0.8f : kind == ShapeKind::sphere ? 0.4f : 0.5f;
        frame.instances.push_back({.kind = kind,
                                   .size = {0.4f, base == 0.8f ? 0.4f : base, 0.4f},
                                   .pose = pose({x, base, z}, static_cast<float>(i)),
                                   .colour = palette_colour(static_cast<std::uint32_t>(i))});
    }
    return frame;
}

/// Two peers side by side, a bar between them and a timeline over both.
std::vector<Frame> make_split(ResourceManager& resources) {
    std::vector<Frame> frames;
    for (const float left : {0.0f, 0.5f}) {
        Frame frame = make_scene(resources, left == 0);
        frame.viewport = {left, 0, 0.5f, 1};
        frame.camera.zoom(1.25f);
        frame.rects.clear();
        frame.text.clear();
        add_panel(frame, left == 0 ? "peer 1" : "peer 2", left == 0 ? amber : red);
        frames.push_back(frame);
    }
    Frame over;
    over.scene = false;
    over.rects = {{.position = {639, 0}, .size = {2, 720}, .colour = {0, 0, 0, 1}},
                  {.position = {40, 686}, .size = {1200, 8}, .colour = {0.06f, 0.08f, 0.11f, 0.7f}},
                  {.position = {40, 686}, .size = {820, 8}, .colour = {0.35f, 0.65f, 0.95f, 0.9f}},
                  {.position = {857, 680}, .size = {6, 20}, .colour = white}};
    over.text = {{.text = "00:20.07", .position = {825, 660}, .colour = white}};
    frames.push_back(over);
    return frames;
}

/// Invalid input: an empty frame, a viewport without area, not-a-number, malformed text, the eye inside a body.
std::vector<Frame> make_edge_cases() {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    Frame empty, flat, wild;
    empty.viewport = {0, 0, 0.5f, 0.5f};
    empty.light.to_sun = {0, 1, 0};
    flat.viewport = {0.2f, 0.2f, 0, 0};
    wild.viewport = {0.5f, 0.5f, 0.5f, 0.5f};
    wild.camera = Camera({0, 0, 0}, 0.2f, 0, -3);
    wild.light.shadows = false;
    add_ground(wild);
    for (int i = 0; i < static_cast<int>(shape_kind_count); ++i)
        wild.instances.push_back(
            {.kind = static_cast<ShapeKind>(i), .size = glm::vec3(0), .pose = pose({0, 1, 0})});
    wild.instances.push_back({.kind = ShapeKind::box, .size = glm::vec3(1), .pose = pose({nan, 0, nan})});
    wild.instances.push_back(
        {.kind = ShapeKind::sphere, .size = glm::vec3(1e9f), .pose = pose({0, -2e9f, 0})});
    wild.lines = {{.from = {0, 0, 9}, .to = {0, 0, -9}}, {.from = {0, nan, 0}, .to = {1, 1, 1}}};
    wild.text = {{.text = "broken \xc3 \xff\xfe utf-8 \xe2\x82 \u4e16 end\nsecond line", .position = {8, 8}},
                 {.text = "tiny", .position = {8, 60}, .height = -3},
                 {.text = "", .position = {nan, nan}}};
    return {empty, flat, wild};
}

/// Draws a picture twice, so that state left by the first draw shows in the second.
void take_picture(Surface& surface, Renderer& renderer, const std::vector<Frame>& frames,
                  const std::filesystem::path& path) {
    for (int i = 0; i < 2; ++i) {
        surface.poll();
        const auto start = std::chrono::steady_clock::now();
        renderer.draw(surface, frames);
        surface.present();
        glFinish();
        const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
        if (i == 1) std::printf("%s  %.1f ms\n", path.string().c_str(), time.count());
    }
    surface.write_png(path);
    const std::string errors = take_gl_errors();
    if (!errors.empty()) throw std::logic_error(path.string() + ": " + errors);
}

void take_pictures(Surface& surface, const std::filesystem::path& folder) {
    ResourceManager resources;
    Renderer renderer(resources);
    Frame scene = make_scene(resources, true);
    take_picture(surface, renderer, {scene}, folder / "scene.png");
    scene.wireframe = true;
    take_picture(surface, renderer, {scene}, folder / "wireframe.png");
    take_picture(surface, renderer, make_split(resources), folder / "split.png");
    scene = make_scene(resources, false);
    scene.camera = Camera({-4.2f, 0.8f, 2.8f}, 5.5f, -0.5f, -0.3f);
    take_picture(surface, renderer, {scene}, folder / "close.png");
    take_picture(surface, renderer, {make_wide(resources)}, folder / "wide.png");
    take_picture(surface, renderer, make_edge_cases(), folder / "edge_cases.png");
}

int run(const std::filesystem::path& folder, bool window) {
    const SurfaceOptions options{.title = "render_check", .vsync = false, .debug = true};
    const auto surface = window ? Surface::open_window(options) : Surface::open_offscreen(options);
    std::printf("%s\n", surface->description().c_str());
    const std::string before = live_gl_objects();
    take_pictures(*surface, folder);
    const std::string after = live_gl_objects();
    std::printf("live objects before: %s; after: %s\n", before.c_str(), after.c_str());
    for (const std::string& message : surface->gl_messages())
        std::fprintf(stderr, "GL: %s\n", message.c_str());
    return before == after && surface->gl_messages().empty() ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    const bool window = argc == 3 && std::string_view(argv[2]) == "--window";
    if (argc != 2 && !window) {
        std::fprintf(stderr, "usage: render_check OUT_DIR [--window]\n");
        return 2;
    }
    try {
        std::filesystem::create_directories(argv[1]);
        return run(argv[1], window);
    } catch (const std::logic_error& error) {
        std::fprintf(stderr, "render_check: %s\n", error.what());
        return 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "render_check: %s\n", error.what());
        return 2;
    }
}
