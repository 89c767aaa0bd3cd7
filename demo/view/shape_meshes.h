#pragma once
/// Meshes of the shapes that are not a scaled primitive: rounded shapes, hulls, compounds, height fields, meshes. Each
/// geometry is triangulated once and has one buffer on the GPU.

#include "lockstone/asset.h"
#include "render/assets/model.h"

#include <array>
#include <map>
#include <memory>

namespace lockstone::demo {

class ShapeMeshes {
  public:
    /// Bounds in the shape's frame; needs no renderer.
    const Bounds& bounds(const Geometry& geometry, const AssetLibrary& assets);
    /// The model of a geometry; needs a renderer. Null if it has no triangles.
    std::shared_ptr<const Model> model(const Geometry& geometry, const AssetLibrary& assets);

  private:
    struct Entry {
        MeshData mesh; ///< empty once it is on the GPU
        Bounds bounds;
        std::shared_ptr<const Model> model;
    };
    using Key = std::array<std::int64_t, 9>; ///< all fields of a geometry
    Entry& entry(const Geometry& geometry, const AssetLibrary& assets);

    std::map<Key, Entry> entries_;
};

/// Triangles with normals. Faces that meet at less than `crease` [rad] are shaded as one smooth surface.
MeshData make_mesh(const TriangleSoup& soup, float crease);

} // namespace lockstone::demo
