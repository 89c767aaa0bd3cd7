// Meshes, height fields and compounds for tests: made from doubles by the bakers, as a game makes them.
#pragma once

#include "collide/narrow_phase.h"
#include "oracle/double_shapes.h"

#include <doctest/doctest.h>

#include <memory>
#include <vector>

namespace mesh_scenes {

using oracle::as_fixed;
using oracle::D3;

/// A solid and the objects that it needs.
struct Owned {
    std::shared_ptr<const lockstone::AssetLibrary> library;
    std::shared_ptr<lockstone::shapes::SolidCache> cache;
    lockstone::shapes::Solid solid;
};

inline Owned own(lockstone::AssetLibrary&& made, lockstone::AssetId id,
                 lockstone::LengthVec3 scale = lockstone::scale_one) {
    Owned out;
    out.library = std::make_shared<const lockstone::AssetLibrary>(std::move(made));
    out.cache = std::make_shared<lockstone::shapes::SolidCache>(out.library);
    const lockstone::Result<lockstone::Geometry> geometry = out.library->geometry(id, scale);
    if (!geometry) FAIL(geometry.error().message);
    lockstone::Result<lockstone::shapes::Solid> solid = out.cache->resolve(*geometry);
    if (!solid) FAIL(solid.error().message);
    out.solid = *solid;
    return out;
}

inline lockstone::Vec3 real(D3 p) {
    return {as_fixed<lockstone::Real>(p.x), as_fixed<lockstone::Real>(p.y), as_fixed<lockstone::Real>(p.z)};
}

struct Soup {
    std::vector<D3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    void add(D3 a, D3 b, D3 c) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), {a, b, c});
        triangles.push_back({first, first + 1, first + 2});
    }
    void add(D3 a, D3 b, D3 c, D3 d) {
        add(a, b, c);
        add(a, c, d);
    }
};

inline Owned mesh(const Soup& soup, bool two_sided = false,
                  lockstone::LengthVec3 scale = lockstone::scale_one) {
    std::vector<lockstone::Vec3> vertices;
    for (const D3& v : soup.vertices) vertices.push_back(real(v));
    lockstone::AssetLibrary library;
    const lockstone::Result<lockstone::AssetId> id = library.add(
        lockstone::bake_mesh({.vertices = vertices, .triangles = soup.triangles, .two_sided = two_sided}));
    if (!id) FAIL(id.error().message);
    return own(std::move(library), *id, scale);
}

/// height(column, row) in metres.
template <class Height>
Owned height_field(std::uint32_t columns, std::uint32_t rows, double spacing, Height&& height) {
    std::vector<lockstone::Length> heights;
    for (std::uint32_t row = 0; row < rows; ++row)
        for (std::uint32_t column = 0; column < columns; ++column)
            heights.push_back(as_fixed<lockstone::Length>(height(column, row)));
    lockstone::AssetLibrary library;
    const lockstone::Result<lockstone::AssetId> id =
        library.add(lockstone::bake_height_field({.columns = columns,
                                                  .rows = rows,
                                                  .spacing = as_fixed<lockstone::Length>(spacing),
                                                  .heights = heights}));
    if (!id) FAIL(id.error().message);
    return own(std::move(library), *id);
}

inline lockstone::shapes::Solid primitive(const lockstone::Geometry& geometry) {
    lockstone::shapes::Solid solid;
    solid.geometry = geometry;
    return solid;
}

/// Counter-clockwise seen from +y, x from `left`, z from `front`; `height(x, z)`. With a seed the diagonals are random.
/// Inner corners move sideways at random by up to `jitter` cells.
template <class Height>
Soup grid(double left, double front, double cell, int columns, int rows, double jitter, std::uint64_t seed,
          Height&& height) {
    oracle::RandomReal random(seed);
    Soup soup;
    const auto at = [&](int c, int r) { return static_cast<std::uint32_t>(r * (columns + 1) + c); };
    for (int r = 0; r <= rows; ++r)
        for (int c = 0; c <= columns; ++c) {
            const bool inner = c > 0 && r > 0 && c < columns && r < rows;
            const double dx = random.uniform(-jitter, jitter), dz = random.uniform(-jitter, jitter);
            const double x = left + cell * (c + (inner ? dx : 0)), z = front + cell * (r + (inner ? dz : 0));
            soup.vertices.push_back({x, height(x, z), z});
        }
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            if (seed != 0 && random.below(2) == 0) {
                soup.triangles.push_back({at(c, r), at(c, r + 1), at(c + 1, r + 1)});
                soup.triangles.push_back({at(c, r), at(c + 1, r + 1), at(c + 1, r)});
            } else {
                soup.triangles.push_back({at(c, r), at(c, r + 1), at(c + 1, r)});
                soup.triangles.push_back({at(c + 1, r), at(c, r + 1), at(c + 1, r + 1)});
            }
        }
    return soup;
}

inline lockstone::collide::RelativePose pose_at(D3 position, lockstone::Quat rotation) {
    using lockstone::Coordinate;
    return {lockstone::to_rotation(rotation),
            {as_fixed<Coordinate>(position.x), as_fixed<Coordinate>(position.y),
             as_fixed<Coordinate>(position.z)}};
}

} // namespace mesh_scenes
