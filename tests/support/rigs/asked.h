// Queries of random heaps whose results other queries give too: casts that skip initial overlaps, and the contact
// points of one body. For the tests and for the planted faults.
#pragma once

#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace lockstone::test {

/// A solid of a random kind, 0.2 to 0.6 m.
inline Geometry drawn_solid(SplitMix& random) {
    // Draws in the order of this list, because the evaluation order of function arguments is unspecified.
    const Vec3 size{scene::real(drawn(random, 0.1, 0.3)), scene::real(drawn(random, 0.1, 0.3)),
                    scene::real(drawn(random, 0.1, 0.3))};
    switch (random.below(4)) {
    case 0:
        return sphere(size.x);
    case 1:
        return capsule(size.x, size.y);
    case 2:
        return cylinder(size.x, size.y);
    default:
        return box(size.x, size.y, size.z);
    }
}

/// 60 bodies of one or two shapes after half a second of falling onto a plane.
inline World drawn_heap(SplitMix& random) {
    WorldDef def = scene::small_def();
    def.bodies_max = 64, def.shapes_max = 128;
    World w = scene::made(World::create(def));
    scene::add_floor(w);
    for (int i = 0; i < 60; ++i) {
        const double x = drawn(random, -1, 1), y = drawn(random, 0.3, 3), z = drawn(random, -1, 1);
        const BodyId body = scene::add(w, {.pose = scene::at(x, y, z)}, {.geometry = drawn_solid(random)});
        if (!random.one_in(3)) continue;
        const Transform local = scene::at(drawn(random, -0.3, 0.3), 0.2, 0);
        scene::made(w.create_shape(body, {.geometry = drawn_solid(random), .local = local}));
    }
    for (int t = 0; t < 30; ++t) w.tick();
    return w;
}

inline bool is_one(const std::optional<QueryHit>& found, const QueryHit* wanted) {
    if (!found || wanted == nullptr) return !found && wanted == nullptr;
    return found->shape == wanted->shape && found->distance == wanted->distance &&
           found->point == wanted->point;
}

/// Casts rays and solids through a heap. Returns a sentence if a cast that skips overlaps does not give the hits of one
/// that includes them, without the hits of shapes that it overlaps at the start. `left_out`: the number of such hits.
inline std::string overlaps_seen_fault(std::uint64_t seed, int& left_out) {
    SplitMix random(seed);
    const World w = drawn_heap(random);
    const QueryFilter without{.overlaps = 0};
    for (int i = 0; i < 100; ++i) {
        const Vec3 from{scene::real(drawn(random, -1, 1)), scene::real(drawn(random, -0.1, 1.5)),
                        scene::real(drawn(random, -1, 1))};
        const Vec3 way{scene::real(drawn(random, -3, 3)), scene::real(drawn(random, -3, 3)),
                       scene::real(drawn(random, -3, 3))};
        const Geometry solid = drawn_solid(random);
        const Transform pose{from, Quat::identity()};
        std::vector<QueryHit> all, wanted, found;
        std::optional<QueryHit> first;
        bool any = false;
        if (i % 2 == 0) {
            w.cast_ray_all({from, way}, {}, all), w.cast_ray_all({from, way}, without, found);
            first = w.cast_ray({from, way}, without), any = w.cast_ray_any({from, way}, without);
        } else {
            w.cast_shape_all(solid, pose, way, {}, all), w.cast_shape_all(solid, pose, way, without, found);
            first = w.cast_shape(solid, pose, way, without),
            any = w.cast_shape_any(solid, pose, way, without);
        }
        for (const QueryHit& hit : all)
            if (hit.normal != UnitVec3{}) wanted.push_back(hit);
        left_out += static_cast<int>(all.size() - wanted.size());
        const bool same = std::ranges::equal(
            found, wanted, [](const QueryHit& a, const QueryHit& b) { return is_one(a, &b); });
        if (!same || any == wanted.empty() || !is_one(first, wanted.empty() ? nullptr : &wanted[0]))
            return "seed " + std::to_string(seed) + ", cast " + std::to_string(i) + ": " +
                   std::to_string(found.size()) + " hits without overlaps in place of " +
                   std::to_string(wanted.size());
    }
    return {};
}

/// Returns a sentence unless the contact points of a body are those points of the world's list that name one of its
/// shapes, in list order. Bodies are destroyed and made before half of the calls: the points must be those of the tick.
inline std::string body_points_fault(std::uint64_t seed) {
    SplitMix random(seed);
    World w = drawn_heap(random);
    std::vector<World::ContactPoint> found;
    w.contacts(w.body_at(0), found);
    w.tick(); // drops cached results of earlier queries
    std::vector<BodyId> bodies, of_point[2];
    for (std::uint32_t row = 0; row < w.body_count(); ++row) bodies.push_back(w.body_at(row));
    for (const World::ContactPoint& point : w.contacts())
        of_point[0].push_back(w.body_of(point.shape_a)), of_point[1].push_back(w.body_of(point.shape_b));
    const std::vector<World::ContactPoint> all(w.contacts().begin(), w.contacts().end());
    if (random.one_in(2)) {
        for (int i = 1; i < 10; ++i) scene::done(w.destroy(bodies[static_cast<std::size_t>(i)]));
        bodies.push_back(scene::add(w, {.pose = scene::at(0, 9, 0)}, {.geometry = sphere(1_r)}));
    }
    std::size_t sum = 0;
    for (const BodyId body : bodies) {
        w.contacts(body, found);
        std::size_t next = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (of_point[0][i] != body && of_point[1][i] != body) continue;
            if (next == found.size() || found[next].point != all[i].point ||
                found[next].shape_a != all[i].shape_a)
                return "seed " + std::to_string(seed) + ": point " + std::to_string(next) + " of body " +
                       std::to_string(body.index) + " is another";
            ++next;
        }
        if (next != found.size())
            return "seed " + std::to_string(seed) + ": body " + std::to_string(body.index) +
                   " has points of others";
        sum += next;
    }
    return sum == 2 * all.size() && sum > 50 ? "" : "seed " + std::to_string(seed) + ": points are missing";
}

} // namespace lockstone::test
