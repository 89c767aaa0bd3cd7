// A triangle mesh: vertices in cells of 32-bit local coordinates, neighbours and sharp edges of triangles, and
// a tree for queries.
#pragma once

#include "shapes/asset/asset.h"
#include "shapes/bounds_hierarchy.h"
#include "shapes/mesh/face.h"

namespace lockstone::shapes {

/// A vertex in a grid of 128 m cells: coordinate = cell * 128 m + local, local in 0 .. 2^31 - 1 steps of
/// 2^-24 m.
struct MeshVertex {
    std::uint32_t local[3];
    std::int8_t cell[3];
    std::uint8_t zero;

    friend constexpr bool operator==(const MeshVertex&, const MeshVertex&) = default;
};
MeshVertex mesh_vertex(CoordinateVec3 p); ///< p must be within 2^14 m of the origin
constexpr CoordinateVec3 position_of(const MeshVertex& v) {
    const auto at = [&v](int i) {
        return Coordinate::from_raw((std::int64_t{v.cell[i]} << 31) + v.local[i]);
    };
    return {at(0), at(1), at(2)};
}

/// The content of a mesh as stored in the asset. The mesh computes all other data from it.
struct MeshContent {
    bool two_sided = false;
    Unit flat_sine{};
    /// In the order in which the triangles first name them.
    std::vector<MeshVertex> vertices;
    /// In an order that keeps neighbours in space together.
    std::vector<std::array<std::uint32_t, 3>> triangles;
    /// For each triangle; empty when all are 0.
    std::vector<std::uint16_t> materials;
    /// For each triangle its index before baking; empty when all indices are unchanged
    std::vector<std::uint32_t> sources;
    std::vector<MaterialSurface> surfaces;
};

class Mesh {
  public:
    explicit Mesh(MeshContent content);
    std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(content.triangles.size()); }
    Face face(std::uint32_t index, LengthVec3 scale) const;
    FacePlane plane(std::uint32_t index) const { ///< at scale 1
        return {position_of(content.vertices[content.triangles[index][0]]), normals[index]};
    }
    FaceEdges edges(const Face& face, LengthVec3 scale) const; ///< for a result of face() at the same scale
    void find(const Extent& where, LengthVec3 scale, std::vector<std::uint32_t>& out) const;
    Extent extent() const { return bounds; } ///< at scale 1
    bool is_two_sided() const { return content.two_sided; }
    std::uint32_t source_of(std::uint32_t index) const {
        return content.sources.empty() ? index : content.sources[index];
    }
    std::uint32_t material_of(std::uint32_t index) const {
        return content.materials.empty() ? 0 : content.materials[index];
    }
    std::span<const MaterialSurface> surfaces() const { return content.surfaces; }
    const MeshContent& raw() const { return content; }

  private:
    static constexpr std::uint32_t no_neighbour = 0xffffffffu;
    void corners_of(std::uint32_t index, CoordinateVec3 (&out)[3]) const;
    void find_neighbours();
    void find_creases();

    MeshContent content;
    Extent bounds;
    std::vector<UnitVec3> normals;                        ///< at scale 1
    std::vector<std::array<std::uint32_t, 3>> neighbours; ///< across edge k
    /// Bits 0..2: edge k is convex; bits 3..5: edge k is sharp at scale 1 (see Triangle).
    std::vector<std::uint8_t> creases;
    std::unique_ptr<const BoundsHierarchy> hierarchy;
};

} // namespace lockstone::shapes
