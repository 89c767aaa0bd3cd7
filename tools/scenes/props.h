// Small bodies of many shapes, shared by the scenes that drop them.
#pragma once

#include "lockstone/math/random.h"
#include "scenes/scene.h"

#include <vector>

namespace lockstone::scenes_detail {

/// Eleven shapes that each fit into a ball of radius `size` [m]: five baked hulls (a gem, an icosahedron, a wedge, a
/// tetrahedron, a rock of 40 random corners), then cylinder, cone, capsule, rounded box, rounded cylinder, rounded
/// cone.
std::vector<Geometry> bake_props(Shelf& shelf, Real size);

/// A random orientation.
Quat random_turn(Random& random);

/// Adds SceneOptions::size bodies: the i-th is at place(i, random) and has the next of the shapes. `surface` holds the
/// friction and the other values of each shape.
template <class Place>
void add_props(Builder& build, const SceneOptions& options, const std::vector<Geometry>& shapes,
               Place&& place, const ShapeDef& surface = {}) {
    Random random = Random::seeded(options.seed);
    for (std::uint32_t i = 0; i < options.size; ++i) {
        ShapeDef shape = surface;
        shape.geometry = shapes[i % shapes.size()];
        build.body({.pose = place(i, random), .user_key = user_key_of(Role::prop, i)}, shape);
    }
}

} // namespace lockstone::scenes_detail
