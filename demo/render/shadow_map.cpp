#include "shadow_map.h"

#include "render/assets/mesh.h"

#include <glm/gtc/matrix_transform.hpp>

#include <array>
#include <cmath>
#include <stdexcept>

namespace lockstone::demo {
namespace {

/// The sphere that `fit` has to cover.
glm::vec4 enclose(std::span<const glm::vec4> spheres, const glm::vec3& focus, float distance) {
    Bounds bounds;
    for (const glm::vec4& sphere : spheres) {
        const glm::vec3 centre(sphere);
        // The negated comparison also skips spheres that contain not-a-number.
        if (!(glm::length(centre - focus) + sphere.w <= distance)) continue;
        bounds.add(centre - sphere.w);
        bounds.add(centre + sphere.w);
    }
    if (bounds.empty()) return {focus, 0.25f * distance};
    return {bounds.centre(), bounds.radius()};
}

} // namespace

ShadowMap::ShadowMap() : depth_(GlTexture::make()), framebuffer_(GlFramebuffer::make()) {
    bind(0);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, resolution, resolution, 0, GL_DEPTH_COMPONENT,
                 GL_FLOAT, nullptr);
    // Linear filtering of a comparison mixes four results: the first ring of soft shadows has no extra cost.
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    constexpr std::array<float, 4> lit{1, 1, 1, 1};
    glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, lit.data());

    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_.get(), 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw std::runtime_error("the driver cannot draw into a depth texture");
    check_gl("ShadowMap");
}

void ShadowMap::fit(std::span<const glm::vec4> spheres, const glm::vec3& to_sun, const glm::vec3& focus,
                    float distance) {
    const glm::vec4 sphere = enclose(spheres, focus, distance);
    // The radius grows in steps and the centre moves by whole texels; otherwise shadow edges would flicker as bodies
    // move.
    constexpr float steps_per_octave = 4;
    const float radius =
        std::exp2(std::ceil(steps_per_octave * std::log2(sphere.w + 0.5f)) / steps_per_octave);
    texel_ = 2 * radius / static_cast<float>(resolution);

    const glm::vec3 up = std::abs(to_sun.y) > 0.99f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::mat4 turn = glm::lookAt(glm::vec3(0), -to_sun, up);
    glm::vec3 centre(turn * glm::vec4(glm::vec3(sphere), 1));
    centre.x = std::round(centre.x / texel_) * texel_;
    centre.y = std::round(centre.y / texel_) * texel_;
    // Depth is clamped while drawing: casters in front of the near plane still cast shadows, so the range can be short.
    const glm::mat4 box = glm::ortho(centre.x - radius, centre.x + radius, centre.y - radius,
                                     centre.y + radius, -centre.z - 2 * radius, -centre.z + 4 * radius);
    matrix_ = box * turn;
}

void ShadowMap::begin() const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
    glViewport(0, 0, resolution, resolution);
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_CLAMP);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 2.0f);
}

void ShadowMap::end() const {
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDisable(GL_DEPTH_CLAMP);
}

void ShadowMap::bind(int unit) const {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_2D, depth_.get());
}

} // namespace lockstone::demo
