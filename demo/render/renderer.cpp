#include "renderer.h"

#include <algorithm>
#include <cmath>

namespace lockstone::demo {
namespace {

constexpr int shadow_unit = 1;

Image white_pixel() { return {.width = 1, .height = 1, .pixels = {255, 255, 255, 255}}; }

/// A viewport in pixels from the lower left, as GL counts them. The edges are rounded, so neighbouring viewports share
/// them exactly.
struct PixelRect {
    int x, y, width, height;
};

PixelRect to_pixels(const glm::vec4& viewport, const glm::ivec2& size) {
    const auto edge = [](float fraction, int length) {
        return std::clamp(static_cast<int>(std::lround(fraction * static_cast<float>(length))), 0, length);
    };
    const int left = edge(viewport.x, size.x), right = edge(viewport.x + viewport.z, size.x);
    const int top = edge(viewport.y, size.y), bottom = edge(viewport.y + viewport.w, size.y);
    return {left, size.y - bottom, std::max(right - left, 0), std::max(bottom - top, 0)};
}

void set_viewport(const PixelRect& rect) {
    glViewport(rect.x, rect.y, rect.width, rect.height);
    glScissor(rect.x, rect.y, rect.width, rect.height);
}

void set_light(const Shader& shader, const Light& light, const glm::vec3& eye) {
    shader.set("to_sun", glm::normalize(light.to_sun));
    shader.set("sun_strength", light.sun);
    shader.set("sky_strength", light.sky);
    shader.set("haze_distance", light.haze_distance);
    shader.set("eye", eye);
}

} // namespace

/// Data that the passes of one frame share.
struct Renderer::View {
    PixelRect rect;
    glm::mat4 view_projection;
    glm::vec3 eye;
    const Framebuffer* target;
    float pixel_scale;
};

Renderer::Renderer(ResourceManager& resources, int samples)
    : sample_count_(samples), lit_(resources.shader("shape", "lit")),
      depth_(resources.shader("shadow", "shadow")), wire_(resources.shader("shape", "wire")),
      sky_(resources.shader("sky", "sky")), markers_(resources), overlay_(resources), white_(white_pixel()),
      empty_array_(GlVertexArray::make()) {}

void Renderer::draw(const Surface& surface, std::span<const Frame> frames) {
    if (!samples_ || samples_->size() != surface.size()) {
        samples_.reset();
        samples_.emplace(surface.size(), sample_count_, Framebuffer::Depth::buffer);
    }
    samples_->bind();
    glDisable(GL_SCISSOR_TEST);
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    const float pixel_scale = surface.pixel_scale();
    for (const Frame& frame : frames) {
        const PixelRect rect = to_pixels(frame.viewport, surface.size());
        if (!frame.scene || rect.width == 0 || rect.height == 0) continue;
        const float aspect = static_cast<float>(rect.width) / static_cast<float>(rect.height);
        draw_scene(frame, {rect, frame.camera.projection(aspect) * frame.camera.view(), frame.camera.eye(),
                           &*samples_, pixel_scale});
    }
    samples_->resolve_to(surface.target().name());
    // Text is drawn after resolving samples, because that would soften it.
    surface.target().bind();
    glEnable(GL_SCISSOR_TEST);
    for (const Frame& frame : frames) {
        const PixelRect rect = to_pixels(frame.viewport, surface.size());
        if (rect.width == 0 || rect.height == 0) continue;
        set_viewport(rect);
        overlay_.draw(frame, {rect.width, rect.height}, pixel_scale);
    }
    glDisable(GL_SCISSOR_TEST);
    glUseProgram(0); // a bound program would outlive its owner
    check_gl("Renderer::draw");
}

void Renderer::draw_scene(const Frame& frame, const View& view) {
    list_.build(frame, library_);
    glEnable(GL_DEPTH_TEST);
    if (frame.light.shadows) {
        shadow_map_.fit(list_.casters(), glm::normalize(frame.light.to_sun), frame.camera.focus(),
                        frame.light.shadow_distance);
        draw_shadows();
    }
    view.target->bind();
    glEnable(GL_MULTISAMPLE);
    set_viewport(view.rect);
    draw_shapes(frame, view);
    if (frame.wireframe) draw_wireframe(view);
    draw_sky(frame, view);
    markers_.draw(frame, view.view_projection, {view.rect.width, view.rect.height}, view.pixel_scale);
    check_gl("Renderer::draw_scene");
}

void Renderer::draw_shadows() {
    shadow_map_.begin();
    glDisable(GL_CULL_FACE);
    depth_->use();
    depth_->set("view_projection", shadow_map_.matrix());
    for (const Batch& batch : list_.batches())
        if (batch.casts_shadow) list_.draw(batch);
    shadow_map_.end();
}

void Renderer::draw_shapes(const Frame& frame, const View& view) {
    lit_->use();
    lit_->set("view_projection", view.view_projection);
    set_light(*lit_, frame.light, view.eye);
    lit_->set("shadow_matrix", shadow_map_.matrix());
    lit_->set("shadow_texel", shadow_map_.texel());
    lit_->set("shadow_strength", frame.light.shadows ? 1.0f : 0.0f);
    lit_->set("shadow_map", shadow_unit);
    shadow_map_.bind(shadow_unit);
    for (const Batch& batch : list_.batches()) {
        batch.material->bind(*lit_, white_);
        list_.draw(batch);
    }
    glDisable(GL_CULL_FACE);
}

void Renderer::draw_wireframe(const View& view) {
    wire_->use();
    wire_->set("view_projection", view.view_projection);
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    glEnable(GL_POLYGON_OFFSET_LINE);
    glPolygonOffset(-0.5f, -1);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glDepthFunc(GL_LEQUAL);
    for (const Batch& batch : list_.batches())
        if (batch.casts_shadow) list_.draw(batch);
    glDepthFunc(GL_LESS);
    glDisable(GL_BLEND);
    glDisable(GL_POLYGON_OFFSET_LINE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

void Renderer::draw_sky(const Frame& frame, const View& view) {
    // The sky comes after all solid objects, at the far plane: only uncovered pixels are shaded.
    sky_->use();
    sky_->set("from_clip", glm::inverse(view.view_projection));
    set_light(*sky_, frame.light, view.eye);
    glDepthFunc(GL_LEQUAL);
    glBindVertexArray(empty_array_.get());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
    glDepthFunc(GL_LESS);
}

glm::vec2 Renderer::text_cell(const Surface& surface, float height) {
    const float pixel_scale = surface.pixel_scale();
    return overlay_.cell(height * pixel_scale) / pixel_scale;
}

} // namespace lockstone::demo
