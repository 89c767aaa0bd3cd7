#pragma once
/// The reaction of a surface to light.

#include "render/gl/shader.h"
#include "render/gl/texture.h"

#include <glm/glm.hpp>

#include <memory>

namespace lockstone::demo {

/// A pattern that the shader draws over the colour.
enum class Pattern : int {
    plain = 0,
    checker = 1,  ///< 1 m squares and a line every 10 m, in the object's xz plane
    octants = 2,  ///< two tones that make the rotation of a ball visible
    quarters = 3, ///< two tones around the y axis, for capsules, cylinders and cones
};

/// Cheap to copy: the texture is shared.
struct Material {
    glm::vec3 colour{1};    ///< sRGB, multiplied by the instance's colour and the texture
    float roughness = 0.6f; ///< 0 mirror .. 1 chalk
    float metalness = 0;    ///< 0 .. 1
    bool two_sided = false; ///< also draw triangles seen from behind
    Pattern pattern = Pattern::plain;
    std::shared_ptr<const Texture> texture{}; ///< may be null

    /// Sets the uniforms of the current `shader` and binds the texture to unit 0 (`white` if there is none).
    void bind(const Shader& shader, const Texture& white) const;
};

} // namespace lockstone::demo
