// Shapes whose centre is inside a closed mesh. For the tests and for the planted faults.
#pragma once

#include "collide/narrow_phase.h"
#include "support/random.h"

#include <array>
#include <string>
#include <vector>

namespace lockstone::test {

/// A mesh of the surface of a box, each face in 2 n^2 triangles.
inline shapes::Solid box_of_triangles(scene::D3 half, int n, std::shared_ptr<shapes::SolidCache>& cache) {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0})
            for (int u = 0; u < n; ++u)
                for (int v = 0; v < n; ++v) {
                    const auto first = static_cast<std::uint32_t>(vertices.size());
                    for (const auto& [du, dv] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
                        scene::D3 at{};
                        at[axis] = side * half[axis];
                        at[(axis + 1) % 3] = half[(axis + 1) % 3] * (2.0 * (u + du) / n - 1);
                        at[(axis + 2) % 3] = half[(axis + 2) % 3] * (2.0 * (v + dv) / n - 1);
                        vertices.push_back(scene::vec3(at));
                    }
                    const std::uint32_t a = first + (side < 0 ? 3 : 1), b = first + (side < 0 ? 1 : 3);
                    triangles.push_back({first, a, first + 2});
                    triangles.push_back({first, first + 2, b});
                }
    AssetLibrary library;
    const AssetId id = library.add(bake_mesh({.vertices = vertices, .triangles = triangles})).value();
    cache = std::make_shared<shapes::SolidCache>(std::make_shared<const AssetLibrary>(std::move(library)));
    return cache->resolve(instance(ShapeKind::mesh, id)).value();
}

/// Returns a sentence if contacts push a shape whose centre is inside a closed mesh in another direction than out of
/// the nearest face.
inline std::string sunken_fault(scene::RandomPoint& random) {
    using namespace scene;
    const D3 half{random(1, 2), random(1, 2), random(1, 2)};
    std::shared_ptr<shapes::SolidCache> cache;
    const shapes::Solid mesh = box_of_triangles(half, static_cast<int>(random(1, 4.999)), cache);
    const std::size_t axis = static_cast<std::size_t>(random(0, 2.999));
    const double side = random(0, 1) < 0.5 ? -1 : 1;
    D3 at{};
    for (std::size_t i = 0; i < 3; ++i) at[i] = random(-0.4, 0.4) * half[i];
    at[axis] = side * (half[axis] - random(0.01, 0.1));
    const Real r = real(random(0.2, 0.4)), h = real(random(0.1, 0.4));
    const Geometry shapes[] = {box(r, h, r), capsule(r, h), cylinder(r, h)};
    const shapes::Solid body{shapes[static_cast<std::size_t>(random(0, 2.999))]};
    collide::NarrowScratch scratch;
    collide::Manifolds found;
    collide::collide(mesh, body, {to_rotation(random.rotation()), to<Coordinate>(vec3(at))},
                     decimal<Length>("0.02"), scratch, found);
    if (found.count == 0) return "a sunken shape has no contact";
    for (std::uint32_t i = 0; i < found.count; ++i) {
        const double along = side * to_double(found.items[i].normal[static_cast<int>(axis)]);
        if (along < 0.999)
            return "a sunken shape is pushed along " + std::to_string(along) + " of the nearest face";
    }
    return "";
}

} // namespace lockstone::test
