#include "shape_meshes.h"

#include "lockstone/math/convert.h"
#include "to_glm.h"

#include <cmath>

namespace lockstone::demo {
namespace {

/// The crease angle: facets of hulls stay visible, hills look smooth.
float crease_of(lockstone::ShapeKind kind) {
    switch (kind) {
    case lockstone::ShapeKind::hull:
        return 0;
    case lockstone::ShapeKind::height_field:
        return 1.2f;
    default:
        return 0.45f;
    }
}

Material material_of(lockstone::ShapeKind kind) {
    Material material;
    const bool ground = kind == lockstone::ShapeKind::height_field || kind == lockstone::ShapeKind::mesh;
    material.roughness = ground ? 0.85f : 0.5f;
    if (ground) material.colour = {0.86f, 1.0f, 0.72f};
    if (kind == lockstone::ShapeKind::height_field) material.pattern = Pattern::checker;
    if (kind == lockstone::ShapeKind::cylinder || kind == lockstone::ShapeKind::cone)
        material.pattern = Pattern::quarters;
    material.two_sided = kind == lockstone::ShapeKind::mesh;
    return material;
}

/// Adds the vertices of one mesh, each combination of position and normal once.
class Joiner {
  public:
    Joiner(const TriangleSoup& from, MeshData& to)
        : soup(from), mesh(to), first(from.vertices.size(), none) {}

    std::uint32_t add(std::uint32_t vertex, const glm::vec3& normal) {
        for (std::uint32_t at = first[vertex]; at != none; at = next[at])
            if (glm::dot(mesh.vertices[at].normal, normal) > 0.9999f) return at;
        const auto added = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back({.anchor = to_glm(soup.vertices[vertex]), .normal = normal});
        next.push_back(first[vertex]);
        first[vertex] = added;
        return added;
    }

  private:
    static constexpr std::uint32_t none = UINT32_MAX;
    const TriangleSoup& soup;
    MeshData& mesh;
    std::vector<std::uint32_t> first, next; ///< by soup vertex; by mesh vertex
};

/// Merges vertices with equal positions.
TriangleSoup welded(const TriangleSoup& soup) {
    std::map<std::array<std::int64_t, 3>, std::uint32_t> index;
    TriangleSoup out;
    std::vector<std::uint32_t> now;
    for (const Vec3& v : soup.vertices) {
        const auto [at, added] =
            index.try_emplace({v.x.raw, v.y.raw, v.z.raw}, static_cast<std::uint32_t>(out.vertices.size()));
        if (added) out.vertices.push_back(v);
        now.push_back(at->second);
    }
    for (const auto& t : soup.triangles) out.triangles.push_back({now[t[0]], now[t[1]], now[t[2]]});
    return out;
}

} // namespace

MeshData make_mesh(const TriangleSoup& soup, float crease) {
    const TriangleSoup joined = welded(soup);
    std::vector<glm::vec3> area(joined.triangles.size()); // normals times twice the area
    std::vector<std::vector<std::uint32_t>> around(joined.vertices.size());
    for (std::uint32_t t = 0; t < joined.triangles.size(); ++t) {
        const auto& [a, b, c] = joined.triangles[t];
        const glm::vec3 origin = to_glm(joined.vertices[a]);
        area[t] = glm::cross(to_glm(joined.vertices[b]) - origin, to_glm(joined.vertices[c]) - origin);
        for (const std::uint32_t v : joined.triangles[t]) around[v].push_back(t);
    }
    const float smooth = std::cos(crease);
    MeshData mesh;
    Joiner joiner(joined, mesh);
    for (std::uint32_t t = 0; t < joined.triangles.size(); ++t) {
        if (glm::length(area[t]) <= 0) continue;
        const glm::vec3 mine = glm::normalize(area[t]);
        for (const std::uint32_t v : joined.triangles[t]) {
            glm::vec3 sum = area[t];
            for (const std::uint32_t other : around[v])
                if (other != t && crease > 0 &&
                    glm::dot(area[other], mine) > smooth * glm::length(area[other]))
                    sum += area[other];
            mesh.indices.push_back(joiner.add(v, glm::normalize(sum)));
        }
    }
    return mesh;
}

ShapeMeshes::Entry& ShapeMeshes::entry(const Geometry& g, const AssetLibrary& assets) {
    const Key key{static_cast<std::int64_t>(g.kind),
                  g.radius.raw,
                  g.half_extent.x.raw,
                  g.half_extent.y.raw,
                  g.half_extent.z.raw,
                  g.scale.x.raw,
                  g.scale.y.raw,
                  g.scale.z.raw,
                  static_cast<std::int64_t>(g.asset.value)};
    const auto [at, added] = entries_.try_emplace(key);
    if (added) {
        at->second.mesh = make_mesh(triangulate(g, assets), crease_of(g.kind));
        for (const Vertex& vertex : at->second.mesh.vertices) at->second.bounds.add(vertex.anchor);
        if (at->second.bounds.empty()) at->second.bounds.add(glm::vec3(0));
    }
    return at->second;
}

const Bounds& ShapeMeshes::bounds(const Geometry& geometry, const AssetLibrary& assets) {
    return entry(geometry, assets).bounds;
}

std::shared_ptr<const Model> ShapeMeshes::model(const Geometry& geometry, const AssetLibrary& assets) {
    Entry& made = entry(geometry, assets);
    if (made.model == nullptr && !made.mesh.indices.empty()) {
        made.model = std::make_shared<const Model>(Model::from_mesh(made.mesh, material_of(geometry.kind)));
        made.mesh = {};
    }
    return made.model;
}

} // namespace lockstone::demo
