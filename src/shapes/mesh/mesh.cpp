#include "shapes/mesh/mesh.h"

#include "shapes/mesh/triangle.h"

#include <algorithm>

namespace lockstone::shapes {

MeshVertex mesh_vertex(CoordinateVec3 p) {
    MeshVertex v{};
    for (int i = 0; i < 3; ++i) {
        v.cell[i] = static_cast<std::int8_t>(p[i].raw >> 31);
        v.local[i] = static_cast<std::uint32_t>(p[i].raw & 0x7fffffff);
    }
    return v;
}

Mesh::Mesh(MeshContent of) : content(std::move(of)) {
    const auto box_of = [this](std::uint32_t index) {
        CoordinateVec3 c[3];
        corners_of(index, c);
        return Extent{min(c[0], min(c[1], c[2])), max(c[0], max(c[1], c[2]))};
    };
    bounds = box_of(0);
    for (const MeshVertex& v : content.vertices) {
        bounds.lower = min(bounds.lower, position_of(v));
        bounds.upper = max(bounds.upper, position_of(v));
    }
    normals.reserve(triangle_count());
    for (std::uint32_t i = 0; i < triangle_count(); ++i) {
        CoordinateVec3 c[3];
        corners_of(i, c);
        normals.push_back(triangle_normal(c, scale_one));
    }
    find_neighbours();
    find_creases();
    hierarchy = std::make_unique<const BoundsHierarchy>(triangle_count(), bounds, box_of);
}

void Mesh::corners_of(std::uint32_t index, CoordinateVec3 (&out)[3]) const {
    for (std::size_t k = 0; k < 3; ++k) out[k] = position_of(content.vertices[content.triangles[index][k]]);
}

/// Two triangles are neighbours when exactly these two have an edge, and they run along it in opposite
/// directions.
void Mesh::find_neighbours() {
    struct HalfEdge {
        std::uint32_t greater, place; // the greater of its vertices; 3 times the triangle plus the edge
    };
    std::vector<std::uint32_t> first(content.vertices.size() + 1, 0);
    const auto smaller_of = [](const auto& t, std::size_t k) { return std::min(t[k], t[(k + 1) % 3]); };
    for (const auto& t : content.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++first[smaller_of(t, k) + 1];
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    std::vector<HalfEdge> edges(3 * content.triangles.size());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < triangle_count(); ++i) {
        const auto& t = content.triangles[i];
        for (std::uint32_t k = 0; k < 3; ++k)
            edges[next[smaller_of(t, k)]++] = {std::max(t[k], t[(k + 1) % 3]), 3 * i + k};
    }
    neighbours.assign(content.triangles.size(), {no_neighbour, no_neighbour, no_neighbour});
    const auto begins_at = [&](std::uint32_t place) { return content.triangles[place / 3][place % 3]; };
    for (std::size_t v = 0; v + 1 < first.size(); ++v) {
        const std::span<HalfEdge> here(edges.data() + first[v], first[v + 1] - first[v]);
        std::ranges::sort(here, [](const HalfEdge& a, const HalfEdge& b) {
            return a.greater != b.greater ? a.greater < b.greater : a.place < b.place;
        });
        for (std::size_t i = 0, end = 0; i < here.size(); i = end) {
            for (end = i + 1; end < here.size() && here[end].greater == here[i].greater;) ++end;
            const std::uint32_t a = here[i].place, b = here[end - 1].place;
            if (end - i != 2 || begins_at(a) == begins_at(b)) continue;
            neighbours[a / 3][a % 3] = b / 3;
            neighbours[b / 3][b % 3] = a / 3;
        }
    }
}

void Mesh::find_creases() {
    creases.assign(content.triangles.size(), 0);
    for (std::uint32_t i = 0; i < triangle_count(); ++i) {
        CoordinateVec3 c[3];
        corners_of(i, c);
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t other = neighbours[i][k];
            if (other == no_neighbour) {
                creases[i] |= static_cast<std::uint8_t>(9u << k);
                continue;
            }
            if (other < i) continue; // set together with the other triangle
            const auto& t = content.triangles[other];
            std::uint32_t back = 0;
            while (neighbours[other][back] != i || t[back] != content.triangles[i][(k + 1) % 3]) ++back;
            const bool convex = side_of(c, position_of(content.vertices[t[(back + 2) % 3]])) < 0;
            const bool felt =
                (convex || content.two_sided) && !is_flat(normals[i], normals[other], content.flat_sine);
            const unsigned bits = (convex ? 1u : 0u) | (felt ? 8u : 0u);
            creases[i] |= static_cast<std::uint8_t>(bits << k);
            creases[other] |= static_cast<std::uint8_t>(bits << back);
        }
    }
}

Face Mesh::face(std::uint32_t index, LengthVec3 scale) const {
    Face out;
    corners_of(index, out.corner);
    out.index = index;
    if (scale == scale_one) {
        out.normal = normals[index];
    } else {
        out.normal = triangle_normal(out.corner, scale);
        for (CoordinateVec3& c : out.corner) c = scaled_by(c, scale);
    }
    return out;
}

FaceEdges Mesh::edges(const Face& face, LengthVec3 scale) const {
    const bool as_baked = scale == scale_one;
    const auto normal_of = [&](std::uint32_t i) {
        if (as_baked) return normals[i];
        CoordinateVec3 c[3];
        corners_of(i, c);
        return triangle_normal(c, scale);
    };
    const std::uint32_t crease = creases[face.index];
    FaceEdges out;
    out.sharp = as_baked ? crease >> 3 : 0;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t other = neighbours[face.index][k];
        const bool border = other == no_neighbour, convex = (crease >> k & 1) != 0;
        out.beyond[k] = border ? -face.normal : normal_of(other);
        if (!as_baked && (border || ((convex || content.two_sided) &&
                                     !is_flat(face.normal, out.beyond[k], content.flat_sine))))
            out.sharp |= 1u << k;
    }
    return out;
}

void Mesh::find(const Extent& where, LengthVec3 scale, std::vector<std::uint32_t>& out) const {
    const Extent box = at_scale_one(where, scale);
    if (hierarchy->is_exact()) {
        hierarchy->visit(box, [&](std::uint32_t index) { out.push_back(index); });
        return;
    }
    hierarchy->visit(box, [&](std::uint32_t index) {
        CoordinateVec3 c[3];
        corners_of(index, c);
        if (overlap({min(c[0], min(c[1], c[2])), max(c[0], max(c[1], c[2]))}, box)) out.push_back(index);
    });
}

} // namespace lockstone::shapes
