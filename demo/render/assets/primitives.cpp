#include "primitives.h"

#include <glm/gtc/constants.hpp>

#include <cmath>

namespace lockstone::demo {
namespace {

constexpr int segments = 32;   ///< around the y axis
constexpr int cap_rings = 8;   ///< from a capsule's equator to its pole
constexpr int bevel_steps = 2; ///< along a quarter of a box's edge

/// Triangles of a grid of `columns` x `rows` vertices that starts at vertex `first`.
void add_grid(MeshData& mesh, std::uint32_t first, std::uint32_t columns, std::uint32_t rows) {
    for (std::uint32_t row = 0; row + 1 < rows; ++row) {
        for (std::uint32_t column = 0; column + 1 < columns; ++column) {
            const std::uint32_t a = first + row * columns + column, b = a + 1, c = a + columns, d = c + 1;
            mesh.indices.insert(mesh.indices.end(), {a, b, d, a, d, c});
        }
    }
}

glm::vec3 on_circle(int segment) {
    const float angle =
        glm::two_pi<float>() * static_cast<float>(segment % segments) / static_cast<float>(segments);
    return {std::cos(angle), 0, -std::sin(angle)};
}

/// Disc of radius 1 at height y, facing `facing` (1 up, -1 down).
void add_disc(MeshData& mesh, float y, float facing) {
    const auto centre = static_cast<std::uint32_t>(mesh.vertices.size());
    const glm::vec3 normal(0, facing, 0);
    mesh.vertices.push_back({.anchor = {0, y, 0}, .normal = normal, .uv = {0.5f, 0.5f}});
    for (int i = 0; i < segments; ++i) {
        const glm::vec3 rim = on_circle(i);
        const glm::vec2 uv = 0.5f + 0.5f * glm::vec2(rim.x, rim.z);
        mesh.vertices.push_back({.anchor = {rim.x, y, rim.z}, .normal = normal, .uv = uv});
    }
    for (std::uint32_t i = 0; i < segments; ++i) {
        const std::uint32_t here = centre + 1 + i, next = centre + 1 + (i + 1) % segments;
        if (facing > 0)
            mesh.indices.insert(mesh.indices.end(), {centre, here, next});
        else
            mesh.indices.insert(mesh.indices.end(), {centre, next, here});
    }
}

/// Side of a cylinder or cone from radius 1 at y = -1 to `top_radius` at y = 1.
void add_side(MeshData& mesh, float top_radius) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const float slope = 0.5f * (1 - top_radius);
    for (int row = 0; row < 2; ++row) {
        const float radius = row == 0 ? 1.0f : top_radius;
        for (int i = 0; i <= segments; ++i) {
            const glm::vec3 rim = on_circle(i);
            const glm::vec2 uv(static_cast<float>(i) / static_cast<float>(segments), static_cast<float>(row));
            const glm::vec3 anchor(radius * rim.x, row == 0 ? -1.0f : 1.0f, radius * rim.z);
            mesh.vertices.push_back({.anchor = anchor, .normal = rim + glm::vec3(0, slope, 0), .uv = uv});
        }
    }
    add_grid(mesh, first, segments + 1, 2);
}

/// One face of the rounded box, spanned by u and v around `axis` = cross(u, v). Each grid line has a sign
/// (which corner it belongs to) and a bevel angle of 0 to 45 degrees; the two lines of angle 0 bound the flat
/// middle.
void add_box_face(MeshData& mesh, const glm::vec3& axis, const glm::vec3& u, const glm::vec3& v) {
    constexpr int lines = 2 * (bevel_steps + 1);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto sign = [](int line) { return line <= bevel_steps ? -1.0f : 1.0f; };
    const auto tangent = [](int line) {
        const int step = line <= bevel_steps ? line - bevel_steps : line - bevel_steps - 1;
        return std::tan(glm::quarter_pi<float>() * static_cast<float>(step) /
                        static_cast<float>(bevel_steps));
    };
    for (int row = 0; row < lines; ++row) {
        for (int column = 0; column < lines; ++column) {
            const glm::vec3 anchor = axis + sign(column) * u + sign(row) * v;
            const glm::vec3 offset = glm::normalize(axis + tangent(column) * u + tangent(row) * v);
            const glm::vec2 uv(0.5f + 0.5f * sign(column), 0.5f + 0.5f * sign(row));
            mesh.vertices.push_back({.anchor = anchor, .offset = offset, .normal = offset, .uv = uv});
        }
    }
    add_grid(mesh, first, lines, lines);
}

} // namespace

MeshData make_box() {
    const glm::vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    MeshData mesh;
    add_box_face(mesh, x, y, z);
    add_box_face(mesh, y, z, x);
    add_box_face(mesh, z, x, y);
    add_box_face(mesh, -x, z, y);
    add_box_face(mesh, -y, x, z);
    add_box_face(mesh, -z, y, x);
    return mesh;
}

MeshData make_capsule() {
    MeshData mesh;
    // Rings from the lower pole up. The equator appears twice, once for each half; the cylinder lies in between.
    constexpr int rings = 2 * (cap_rings + 1);
    for (int ring = 0; ring < rings; ++ring) {
        const bool upper = ring > cap_rings;
        const int step = upper ? ring - cap_rings - 1 : ring - cap_rings;
        const float latitude =
            glm::half_pi<float>() * static_cast<float>(step) / static_cast<float>(cap_rings);
        for (int i = 0; i <= segments; ++i) {
            const glm::vec3 direction =
                std::cos(latitude) * on_circle(i) + glm::vec3(0, std::sin(latitude), 0);
            const glm::vec2 uv(static_cast<float>(i) / static_cast<float>(segments),
                               static_cast<float>(ring) / static_cast<float>(rings - 1));
            mesh.vertices.push_back(
                {.anchor = {0, upper ? 1 : -1, 0}, .offset = direction, .normal = direction, .uv = uv});
        }
    }
    add_grid(mesh, 0, segments + 1, rings);
    return mesh;
}

MeshData make_cylinder() {
    MeshData mesh;
    add_side(mesh, 1);
    add_disc(mesh, 1, 1);
    add_disc(mesh, -1, -1);
    return mesh;
}

MeshData make_cone() {
    MeshData mesh;
    add_side(mesh, 0);
    add_disc(mesh, -1, -1);
    return mesh;
}

MeshData make_plane() {
    MeshData mesh;
    for (const glm::vec2 corner : {glm::vec2(-1, 1), glm::vec2(1, 1), glm::vec2(1, -1), glm::vec2(-1, -1)})
        mesh.vertices.push_back(
            {.anchor = {corner.x, 0, corner.y}, .normal = {0, 1, 0}, .uv = 0.5f + 0.5f * corner});
    mesh.indices = {0, 1, 2, 0, 2, 3};
    return mesh;
}

} // namespace lockstone::demo
