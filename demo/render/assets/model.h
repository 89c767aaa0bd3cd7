#pragma once
/// Meshes with their materials, from any file that assimp reads.

#include "material.h"
#include "mesh.h"

#include <filesystem>
#include <functional>
#include <vector>

namespace lockstone::demo {

/// One or more meshes, each with a material. Move-only.
class Model {
  public:
    struct Part {
        Mesh mesh;
        Material material;
    };

    /// Finds the texture of a model by path; ResourceManager::texture is one.
    using TextureLoader = std::function<std::shared_ptr<const Texture>(const std::filesystem::path&)>;

    /// Reads a model file (.obj, .gltf, .glb, .fbx, .ply, .stl, ...). The node tree is flattened, faces are
    /// triangulated, missing normals are made. Throws std::runtime_error naming the file and the reason.
    static Model load(const std::filesystem::path& path, const TextureLoader& texture);

    /// One mesh made in code: a hull, a terrain.
    static Model from_mesh(const MeshData& mesh, Material material);

    const std::vector<Part>& parts() const { return parts_; }

    /// Bounds in the model's frame, in the unit of the file.
    const Bounds& bounds() const { return bounds_; }

  private:
    void add(Part part);

    std::vector<Part> parts_;
    Bounds bounds_;
};

} // namespace lockstone::demo
