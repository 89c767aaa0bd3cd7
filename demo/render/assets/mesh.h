#pragma once
/// Triangles, and the instances they are drawn at.

#include "render/gl/gl.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lockstone::demo {

/// One corner. In the object's frame its position is `anchor * scale + offset * radius`, with scale and radius from the
/// instance. Rounded shapes of any proportion thus share one mesh: the caps of a capsule stay half spheres at any
/// length, and the bevel of a box keeps its width. Scaling a finished mesh would distort both.
struct Vertex {
    glm::vec3 anchor{0}; ///< scaled per axis
    glm::vec3 offset{0}; ///< scaled by the radius; if not zero it is the normal
    glm::vec3 normal{0}; ///< for vertices without offset
    glm::vec2 uv{0};
};

/// An indexed triangle list, counter-clockwise seen from outside.
struct MeshData {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;
};

/// The data of one drawn instance on the GPU.
struct GpuInstance {
    glm::mat4 pose{1};
    glm::vec4 scale_radius{1, 1, 1, 0}; ///< xyz [m] on anchors, w [m] on offsets
    glm::vec4 colour_highlight{1, 1, 1, 0};
};

/// Axis-aligned box; empty while min exceeds max.
struct Bounds {
    glm::vec3 min{1e30f};
    glm::vec3 max{-1e30f};
    void add(const glm::vec3& point) {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
    bool empty() const { return min.x > max.x; }
    glm::vec3 centre() const { return 0.5f * (min + max); }
    float radius() const { return 0.5f * glm::length(max - min); }
};

/// Immutable triangles on the GPU. Move-only.
class Mesh {
  public:
    /// Throws std::runtime_error if `data` has no triangle or an index out of range.
    explicit Mesh(const MeshData& data);

    /// Draws `count` instances, reading GpuInstance records from `instances`, starting at record `first`.
    void draw(const GlBuffer& instances, std::size_t first, std::size_t count) const;

    /// Bounds of the anchors, in the object's frame.
    const Bounds& bounds() const { return bounds_; }

  private:
    GlVertexArray array_;
    GlBuffer vertices_;
    GlBuffer indices_;
    GLsizei index_count_ = 0;
    Bounds bounds_;
};

} // namespace lockstone::demo
