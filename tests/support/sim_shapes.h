// Worlds with a shape of every kind.
#pragma once

#include "support/sim_scenes.h"

#include <memory>

namespace lockstone::test::scene {

/// A wedge-like hull, a height field of gentle waves, a mesh with a step in it, and a table of two parts.
struct Zoo {
    std::shared_ptr<const AssetLibrary> library;
    AssetId hull, waves, step, table;
};

inline Result<AssetBytes> gem_bytes() {
    // An octahedron with cut corners, which has flat faces of several sizes.
    std::vector<LengthVec3> points;
    for (int i = 0; i < 3; ++i)
        for (int sign : {-1, 1})
            for (int j = 0; j < 4; ++j) {
                D3 p{};
                const auto a = static_cast<std::size_t>(i), b = (a + 1) % 3, c = (a + 2) % 3;
                p[a] = 0.5 * sign;
                p[b] = j == 0 ? 0.2 : j == 1 ? -0.2 : 0;
                p[c] = j == 2 ? 0.2 : j == 3 ? -0.2 : 0;
                points.push_back(to<Length>(vec(p[0], p[1], p[2])));
            }
    return bake_hull(points);
}

inline Result<AssetBytes> wave_bytes(std::uint32_t side = 33) {
    std::vector<Length> heights;
    for (std::uint32_t row = 0; row < side; ++row)
        for (std::uint32_t column = 0; column < side; ++column)
            heights.push_back(to<Length>(real(0.3 * std::sin(0.4 * column) * std::cos(0.3 * row))));
    return bake_height_field({side, side, to<Length>(1_r), heights});
}

inline Result<AssetBytes> step_bytes() {
    const std::vector<Vec3> v = {vec(-8, 0, -8),  vec(0, 0, -8),   vec(0, 0, 8),   vec(-8, 0, 8),
                                 vec(0, 0.4, -8), vec(8, 0.4, -8), vec(8, 0.4, 8), vec(0, 0.4, 8)};
    const std::vector<std::array<std::uint32_t, 3>> t = {{0, 3, 2}, {0, 2, 1}, {4, 7, 6},
                                                         {4, 6, 5}, {1, 2, 7}, {1, 7, 4}};
    return bake_mesh({v, t});
}

inline Zoo make_zoo() {
    AssetLibrary library;
    Zoo zoo;
    zoo.hull = made(library.add(gem_bytes()));
    zoo.waves = made(library.add(wave_bytes()));
    zoo.step = made(library.add(step_bytes()));
    const CompoundPart parts[] = {{box(0.6_r, 0.1_r, 0.4_r), at(0, 0.4, 0)},
                                  {cylinder(0.1_r, 0.3_r), Transform::identity()},
                                  {instance(ShapeKind::hull, zoo.hull), at(0, -0.3, 0)}};
    zoo.table = made(library.add(bake_compound(parts)));
    zoo.library = std::make_shared<const AssetLibrary>(std::move(library));
    return zoo;
}

/// Each shape that a dynamic body can have, all about a metre wide.
inline std::vector<Geometry> moving_shapes(const Zoo& zoo) {
    return {
        sphere(0.4_r),
        capsule(0.25_r, 0.3_r),
        cylinder(0.4_r, 0.3_r),
        cone(0.4_r, 0.4_r),
        box(0.4_r, 0.3_r, 0.5_r),
        rounded(box(0.3_r, 0.2_r, 0.4_r), 0.1_r),
        rounded(cylinder(0.3_r, 0.2_r), 0.1_r),
        rounded(cone(0.3_r, 0.3_r), 0.05_r),
        instance(ShapeKind::hull, zoo.hull),
        rounded(instance(ShapeKind::hull, zoo.hull, {to<Length>(1.5_r), to<Length>(0.5_r), to<Length>(1_r)}),
                0.05_r),
        instance(ShapeKind::compound, zoo.table)};
}

/// A world in which all of them fall on waves, on a step and on a plane further away.
inline World zoo_world(const Zoo& zoo, int layers = 2) {
    WorldDef def = small_def();
    def.bodies_max = def.shapes_max = 128;
    def.contacts_max = 1024;
    World w = made(World::create(def, {}, zoo.library));
    add(w, {.kind = BodyKind::static_, .pose = at(-16, 0, -16)},
        {.geometry = instance(ShapeKind::height_field, zoo.waves)});
    add(w, {.kind = BodyKind::static_, .pose = at(0, 1, 0)},
        {.geometry = instance(ShapeKind::mesh, zoo.step)});
    add(w, {.kind = BodyKind::static_, .pose = at(0, -1, 0)}, {.geometry = plane()});
    const std::vector<Geometry> shapes = moving_shapes(zoo);
    for (int layer = 0; layer < layers; ++layer)
        for (std::size_t i = 0; i < shapes.size(); ++i) {
            const double x = -6 + 1.2 * static_cast<double>(i), z = -1 + 2.2 * (layer % 2);
            add(w,
                {.pose = at(x, 2.5 + 1.5 * layer, z, turned(axis_z, 20 * static_cast<double>(i))),
                 .linear_velocity = vec(1, 0, layer % 2 == 0 ? 3 : -2),
                 .angular_velocity = vec(1, 2, static_cast<double>(i) - 4)},
                {.geometry = shapes[i], .rolling_resistance = 0.01_r});
        }
    return w;
}

} // namespace lockstone::test::scene
