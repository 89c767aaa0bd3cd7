// The rules for an asset library that gets arbitrary bytes. The fuzzer and the tests that replay its inputs use them.
#pragma once

#include "base/hash.h"
#include "lockstone/asset.h"
#include "shapes/asset/asset_file.h"
#include "shapes/mesh/height_field.h"

#include <algorithm>
#include <string>

namespace fuzz {

using namespace lockstone;

/// A library with a tetrahedron, which compounds can name.
inline AssetLibrary library_with_hull() {
    const auto point = [](int x, int y, int z) { return LengthVec3{Length(x), Length(y), Length(z)}; };
    const LengthVec3 corners[] = {point(0, 0, 0), point(1, 0, 0), point(0, 1, 0), point(0, 0, 1)};
    AssetLibrary library;
    (void)library.add(bake_hull(corners)).value();
    return library;
}

/// Writes the valid checksum of the content, so that the bytes reach the checks after the checksum.
inline void seal(AssetBytes& bytes) {
    if (bytes.size() < shapes::asset_checksum_size) return;
    const std::size_t size = bytes.size() - shapes::asset_checksum_size;
    const std::uint64_t sum = base::xxh3(std::span<const std::byte>(bytes).first(size));
    base::store_little_endian(sum == 0 ? std::uint64_t{1} : sum, bytes.data() + size);
}

/// Queries around some triangles. Each query must find its triangle, and a query without bounds must find all.
inline std::string check_triangles(const shapes::Solid& solid) {
    std::vector<std::uint32_t> found;
    const std::uint32_t count = shapes::triangle_count(solid), stride = 1 + count / 16;
    for (std::uint32_t i = 0; i < count; i += stride) {
        const shapes::Triangle t = shapes::triangle_at(solid, i);
        const shapes::Extent e{min(t.corner[0], min(t.corner[1], t.corner[2])),
                               max(t.corner[0], max(t.corner[1], t.corner[2]))};
        found.clear();
        shapes::find_triangles(solid, e, found);
        const bool hole = solid.height_field != nullptr && solid.height_field->is_hole(i);
        if (std::ranges::binary_search(found, i) == hole) return "a triangle is not found where it is";
        if (!std::ranges::is_sorted(found)) return "triangles are out of order";
        if (t.normal == UnitVec3{}) return "a triangle has no normal";
    }
    const Coordinate far = Coordinate::max();
    found.clear();
    shapes::find_triangles(solid, {{-far, -far, -far}, {far, far, far}}, found);
    std::uint32_t holes = 0;
    for (std::uint32_t i = 0; solid.height_field != nullptr && i < count; ++i)
        holes += solid.height_field->is_hole(i) ? 1u : 0u;
    return found.size() == count - holes ? "" : "not all triangles are found";
}

inline std::string check_hull(const shapes::Hull& hull) {
    if (hull.vertices.size() + hull.triangles.size() / 2 != hull.triangles.size() + 2)
        return "Euler's formula fails";
    if (hull.faces.size() < 4 || hull.edges.size() < 6) return "a hull has too few faces or edges";
    if (hull.properties.gyration_squared.x.x <= I20F44{}) return "a hull has no inertia";
    return {};
}

/// Returns an error sentence or an empty string. Sets `loaded` if the library accepted the bytes.
inline std::string check(std::span<const std::byte> bytes, const AssetLibrary& library, bool& loaded) {
    const auto asset = shapes::parse_asset(bytes, library);
    loaded = asset.ok();
    if (!asset)
        return asset.error().message.starts_with("asset: ") ? "" : "an error does not say what it is about";
    if (!std::ranges::equal((*asset)->bytes, bytes) || shapes::rebuilt(**asset) != (*asset)->bytes)
        return "rebuilt bytes differ";
    const shapes::Solid solid{.geometry = instance((*asset)->kind, (*asset)->id),
                              .hull = (*asset)->hull.get(),
                              .compound = (*asset)->compound.get(),
                              .height_field = (*asset)->height_field.get(),
                              .mesh = (*asset)->mesh.get()};
    const shapes::Extent extent = shapes::extent_of(solid);
    if (extent.lower.x > extent.upper.x) return "the extent is empty";
    if (solid.hull != nullptr) return check_hull(*solid.hull);
    if (solid.compound != nullptr) {
        std::vector<std::uint32_t> found;
        solid.compound->find(extent, found);
        return found.size() == solid.compound->parts.size() ? "" : "a part is not found";
    }
    return check_triangles(solid);
}

} // namespace fuzz
