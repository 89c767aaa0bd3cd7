#pragma once
/// A frame's shapes and objects, sorted into as few draw calls as possible.

#include "frame.h"
#include "render/assets/mesh.h"

#include <array>
#include <vector>

namespace lockstone::demo {

/// One draw call: `count` records from `first`.
struct Batch {
    const Mesh* mesh = nullptr;
    const Material* material = nullptr;
    std::size_t first = 0;
    std::size_t count = 0;
    bool casts_shadow = true;
};

/// The meshes and materials of the primitive shapes. Move-only.
class ShapeLibrary {
  public:
    ShapeLibrary();

    const Mesh& mesh(ShapeKind kind) const;
    const Material& material(ShapeKind kind) const { return materials_[static_cast<std::size_t>(kind)]; }

  private:
    Mesh box_, capsule_, cylinder_, cone_, plane_;
    std::array<Material, shape_kind_count> materials_;
};

/// The draw calls of a frame. Rebuilt for each frame; keeps its memory. Move-only.
class DrawList {
  public:
    DrawList();

    /// Sorts and uploads. `library` and the frame's objects must live until the last draw of this frame.
    void build(const Frame& frame, const ShapeLibrary& library);

    const std::vector<Batch>& batches() const { return batches_; }

    /// World bounding spheres of the objects that cast shadows: centre xyz, radius w [m].
    const std::vector<glm::vec4>& casters() const { return casters_; }

    void draw(const Batch& batch) const { batch.mesh->draw(buffer_, batch.first, batch.count); }

  private:
    void add_shapes(const Frame& frame, const ShapeLibrary& library);
    void add_objects(const Frame& frame);

    GlBuffer buffer_;
    std::vector<GpuInstance> records_;
    std::vector<Batch> batches_;
    std::vector<glm::vec4> casters_;
};

} // namespace lockstone::demo
