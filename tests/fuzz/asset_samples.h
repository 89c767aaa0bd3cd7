// One or two small assets of each kind, which the tests damage.
#pragma once

#include "fuzz/checks/asset_check.h"

#include <string>
#include <vector>

namespace fuzz {

struct Sample {
    std::string name;
    AssetBytes bytes;
};

inline LengthVec3 sample_point(int x, int y, int z) { // in quarters of a metre
    const auto quarter = [](int n) { return Length::from_raw(n * (1 << 22)); };
    return {quarter(x), quarter(y), quarter(z)};
}

inline AssetBytes sample_hull(bool cube) {
    std::vector<LengthVec3> points;
    for (int i = 0; i < 8; ++i)
        points.push_back(sample_point(i & 1 ? 4 : -4, i & 2 ? 3 : -3, i & 4 ? 2 : -2));
    if (!cube)
        points = {sample_point(0, 5, 0), sample_point(0, -5, 0), sample_point(4, 0, 0),
                  sample_point(-3, 0, 4), sample_point(-3, 1, -4)};
    return bake_hull(points).value();
}

inline AssetBytes sample_mesh(bool large) {
    const Real far = large ? Real(3000) : Real(1);
    const std::vector<Vec3> vertices = {{Real{}, Real{}, Real{}},
                                        {far, Real{}, Real{}},
                                        {Real{}, far, Real{}},
                                        {Real{}, Real{}, far},
                                        {far, far, far}};
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 4}};
    const std::vector<std::uint16_t> materials = {1, 2, 3, 4};
    MeshDef def{.vertices = vertices, .triangles = triangles};
    def.two_sided = large;
    if (!large) def.materials = materials;
    return bake_mesh(def).value();
}

inline AssetBytes sample_height_field(bool cells) {
    std::vector<Length> heights;
    for (int i = 0; i < 12; ++i) heights.push_back(Length::from_raw((i * 7 % 5) << 20));
    const std::vector<std::uint8_t> materials = {1, 255, 0, 3, 2, 255};
    HeightFieldDef def{.columns = 4, .rows = 3, .spacing = Length(1), .heights = heights};
    if (cells) def.cells = materials;
    return bake_height_field(def).value();
}

inline AssetBytes sample_compound() {
    const AssetLibrary library = library_with_hull();
    const Transform aside{{Real(2), Real{}, Real(-1)},
                          {Unit{}, Unit::from_raw(1 << 29), Unit{}, Unit::from_raw(929887697)}};
    const CompoundPart parts[] = {{sphere(Real(1)), Transform::identity()},
                                  {rounded(box(Real(1), Real(2), Real(1)), half(Real(1))), aside},
                                  {library.geometry(library.ids().front()).value(), aside}};
    return bake_compound(parts).value();
}

inline std::vector<Sample> samples() {
    return {{"hull cube", sample_hull(true)},
            {"hull of five", sample_hull(false)},
            {"mesh", sample_mesh(false)},
            {"large mesh", sample_mesh(true)},
            {"height field", sample_height_field(false)},
            {"height field with holes", sample_height_field(true)},
            {"compound", sample_compound()}};
}

/// Samples of version 1.1: triangles that baking moved, and surfaces.
inline std::vector<Sample> newer_samples() {
    const std::vector<Vec3> vertices = {{Real{}, Real{}, Real{}},
                                        {Real(1), Real{}, Real{}},
                                        {Real{}, Real(1), Real{}},
                                        {Real{}, Real{}, Real(1)}};
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 0, 1}, {0, 2, 1}, {0, 1, 3}};
    const std::vector<std::uint16_t> materials = {1, 2, 3};
    const std::vector<MaterialSurface> surfaces = {
        {1, half(Real(1)), half(Real(1))},
        {2, Real{}, Real{}, half(half(Real(1))), {Real(3), Real(-2), Real(1)}}};
    const std::vector<Length> heights(4);
    const std::vector<std::uint8_t> cell = {2};
    const HeightFieldDef field{.columns = 2,
                               .rows = 2,
                               .spacing = Length(1),
                               .heights = heights,
                               .cells = cell,
                               .surfaces = surfaces};
    return {{"moved mesh",
             bake_mesh(
                 {.vertices = vertices, .triangles = triangles, .materials = materials, .surfaces = surfaces})
                 .value()},
            {"height field with surfaces", bake_height_field(field).value()}};
}

} // namespace fuzz
