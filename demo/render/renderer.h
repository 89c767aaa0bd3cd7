#pragma once
/// Turns frames into a picture: shadow map, shaded shapes, wireframe, sky, markers, overlay.
///
///   auto surface = Surface::display_available() ? Surface::open_window({}) : Surface::open_offscreen({});
///   ResourceManager resources;
///   Renderer renderer(resources);
///   while (!surface->close_requested()) {
///       const Input& input = surface->poll();
///       Frame frame;                                   // filled from the simulation
///       renderer.draw(*surface, frame);                // or several frames, each with its viewport
///       surface->present();
///   }
///   surface->write_png("last.png");

#include "draw_list.h"
#include "frame.h"
#include "markers.h"
#include "overlay.h"
#include "render/gl/surface.h"
#include "resource_manager.h"
#include "shadow_map.h"

#include <optional>
#include <span>

namespace lockstone::demo {

/// Sun with soft shadows, sky light, tone mapping, multisampling. Create it once; it needs the surface's context for
/// its whole lifetime. Every failure is a std::runtime_error with the reason.
class Renderer {
  public:
    /// `resources` must outlive the renderer. `samples`: per pixel, for smooth edges; 0 is faster without a GPU.
    explicit Renderer(ResourceManager& resources, int samples = 4);

    /// Draws every frame into its viewport of the surface's target: all scenes, then all overlays in order.
    /// Call surface.present() afterwards.
    void draw(const Surface& surface, std::span<const Frame> frames);
    void draw(const Surface& surface, const Frame& frame) { draw(surface, std::span(&frame, 1)); }

    /// Width and height of a letter of TextLine::height `height` [design px, all].
    glm::vec2 text_cell(const Surface& surface, float height = TextLine{}.height);

  private:
    struct View;

    void draw_scene(const Frame& frame, const View& view);
    void draw_shadows();
    void draw_shapes(const Frame& frame, const View& view);
    void draw_wireframe(const View& view);
    void draw_sky(const Frame& frame, const View& view);

    int sample_count_;
    std::shared_ptr<const Shader> lit_, depth_, wire_, sky_;
    ShapeLibrary library_;
    DrawList list_;
    ShadowMap shadow_map_;
    MarkerPainter markers_;
    OverlayPainter overlay_;
    Texture white_;
    GlVertexArray empty_array_;          ///< for the sky, whose vertices the shader generates
    std::optional<Framebuffer> samples_; ///< of the surface's size
};

} // namespace lockstone::demo
