#include "outlines.h"

#include "to_glm.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace lockstone::demo {
namespace {

constexpr int ring_steps = 24;
constexpr float crease_cos = 0.94f; ///< faces that meet at less than 20 degrees have no edge between them

/// Adds an arc around a point: cos(t) x + sin(t) y, where t starts at `begin` and covers `turns` of a circle.
void add_arc(std::vector<Edge>& edges, const glm::vec3& centre, const glm::vec3& x, const glm::vec3& y,
             float begin = 0, float turns = 1) {
    const int steps = static_cast<int>(std::lround(turns * ring_steps));
    const auto at = [&](int step) {
        const float t =
            glm::two_pi<float>() * (begin + turns * static_cast<float>(step) / static_cast<float>(steps));
        return centre + std::cos(t) * x + std::sin(t) * y;
    };
    for (int step = 0; step < steps; ++step) edges.emplace_back(at(step), at(step + 1));
}

/// Adds a solid of revolution about y: two rings, and four lines that connect them.
void add_round(std::vector<Edge>& edges, float low_radius, float low, float high_radius, float high) {
    for (const auto& [radius, height] : {std::pair(low_radius, low), std::pair(high_radius, high)})
        if (radius > 0) add_arc(edges, {0, height, 0}, {radius, 0, 0}, {0, 0, radius});
    for (const glm::vec2& side : {glm::vec2(1, 0), glm::vec2(-1, 0), glm::vec2(0, 1), glm::vec2(0, -1)})
        edges.emplace_back(glm::vec3(low_radius * side.x, low, low_radius * side.y),
                           glm::vec3(high_radius * side.x, high, high_radius * side.y));
}

std::vector<Edge> capsule_edges(float radius, float half) {
    std::vector<Edge> edges;
    const glm::vec3 x(radius, 0, 0), y(0, radius, 0), z(0, 0, radius), top(0, half, 0);
    if (half > 0)
        add_round(edges, radius, -half, radius, half);
    else
        add_arc(edges, {}, x, z);
    for (const glm::vec3& side : {x, z}) {
        add_arc(edges, top, side, y, 0, 0.5f);
        add_arc(edges, -top, side, y, 0.5f, 0.5f);
    }
    return edges;
}

/// The edges between faces that meet at an angle, and the edges of only one face.
std::vector<Edge> sharp_edges(const TriangleSoup& soup) {
    using Place = std::array<std::int64_t, 3>;
    std::map<std::pair<Place, Place>, std::vector<glm::vec3>> normals; // of the faces at each edge
    std::map<Place, glm::vec3> places;
    for (const auto& triangle : soup.triangles) {
        std::array<Place, 3> at{};
        std::array<glm::vec3, 3> p{};
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& v = soup.vertices[triangle[i]];
            at[i] = {v.x.raw, v.y.raw, v.z.raw};
            p[i] = places[at[i]] = to_glm(v);
        }
        const glm::vec3 area = glm::cross(p[1] - p[0], p[2] - p[0]);
        if (glm::length(area) <= 0) continue;
        for (std::size_t i = 0; i < 3; ++i)
            normals[std::minmax(at[i], at[(i + 1) % 3])].push_back(glm::normalize(area));
    }
    std::vector<Edge> edges;
    for (const auto& [edge, sides] : normals)
        if (sides.size() != 2 || glm::dot(sides[0], sides[1]) < crease_cos)
            edges.emplace_back(places[edge.first], places[edge.second]);
    return edges;
}

std::vector<Edge> edges_of(const Geometry& g, const AssetLibrary& assets) {
    const float radius = to_float(g.radius) * to_float(g.scale.x);
    const glm::vec3 half = to_glm(to_float(g.half_extent)) * to_glm(to_float(g.scale));
    std::vector<Edge> edges;
    const bool is_rounded = g.radius > Length{};
    if (g.kind == lockstone::ShapeKind::sphere) return capsule_edges(radius, 0);
    if (g.kind == lockstone::ShapeKind::capsule) return capsule_edges(radius, half.y);
    if (g.kind == lockstone::ShapeKind::cylinder && !is_rounded)
        add_round(edges, half.x, -half.y, half.x, half.y);
    else if (g.kind == lockstone::ShapeKind::cone && !is_rounded)
        add_round(edges, half.x, -half.y, 0, half.y);
    else
        edges = sharp_edges(triangulate(g, assets));
    return edges;
}

} // namespace

std::vector<Edge> outline_of(const ShapeDef& shape, const AssetLibrary& assets) {
    const glm::mat4 local = to_glm(shape.local);
    std::vector<Edge> edges = edges_of(shape.geometry, assets);
    for (auto& [from, to] : edges) {
        from = glm::vec3(local * glm::vec4(from, 1));
        to = glm::vec3(local * glm::vec4(to, 1));
    }
    return edges;
}

} // namespace lockstone::demo
