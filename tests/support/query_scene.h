// A world with objects of every kind, and random queries.
#pragma once

#include "support/random.h"

#include <cstring>
#include <memory>
#include <optional>

namespace lockstone::test::query {

using namespace lockstone::test::scene;

struct Assets {
    std::shared_ptr<AssetLibrary> library = std::make_shared<AssetLibrary>();
    AssetId hull, mesh, field, compound;

    Assets() {
        RandomPoint random(5);
        std::vector<LengthVec3> points;
        for (int i = 0; i < 24; ++i) {
            const D3 p = random.point(0.5, -0.5, 0.5);
            points.push_back({quantize<Length>(p[0]), quantize<Length>(p[1]), quantize<Length>(p[2])});
        }
        hull = library->add(bake_hull(points)).value();
        constexpr std::uint32_t side = 17;
        std::vector<Vec3> vertices;
        std::vector<Length> heights;
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (std::uint32_t z = 0; z < side; ++z)
            for (std::uint32_t x = 0; x < side; ++x) {
                const double height = random(-0.4, 0.4);
                vertices.push_back(vec(x - 8.0, height, z - 8.0));
                heights.push_back(quantize<Length>(height));
            }
        for (std::uint32_t z = 0; z + 1 < side; ++z)
            for (std::uint32_t x = 0; x + 1 < side; ++x) {
                const std::uint32_t at = z * side + x;
                triangles.push_back({at, at + side, at + side + 1});
                triangles.push_back({at, at + side + 1, at + 1});
            }
        mesh = library->add(bake_mesh({.vertices = vertices, .triangles = triangles})).value();
        field = library
                    ->add(bake_height_field(
                        {.columns = side, .rows = side, .spacing = Length(1), .heights = heights}))
                    .value();
        const CompoundPart parts[] = {{box(0.1_r, 0.1_r, 0.6_r), Transform::identity()},
                                      {sphere(0.25_r), at(0, 0, 0.6)},
                                      {instance(ShapeKind::hull, hull), at(0, 0.2, -0.6)}};
        compound = library->add(bake_compound(parts)).value();
    }
};

/// `geometry(i)` for i = 0..8: every kind of moving shape.
inline Geometry moving_geometry(const Assets& assets, int i) {
    switch (i % 9) {
    case 0:
        return sphere(0.3_r);
    case 1:
        return capsule(0.2_r, 0.3_r);
    case 2:
        return cylinder(0.3_r, 0.2_r);
    case 3:
        return cone(0.3_r, 0.3_r);
    case 4:
        return box(0.3_r, 0.2_r, 0.4_r);
    case 5:
        return rounded(box(0.2_r, 0.2_r, 0.2_r), 0.1_r);
    case 6:
        return instance(ShapeKind::hull, assets.hull);
    case 7:
        return rounded(cylinder(0.2_r, 0.2_r), 0.05_r);
    default:
        return instance(ShapeKind::compound, assets.compound);
    }
}

/// A mesh beside a height field above a plane, and `count` falling bodies. `order`: the order of their creation.
inline World crowd(const Assets& assets, int count, const std::vector<int>& order = {}) {
    WorldDef def = small_def();
    def.bodies_max = def.shapes_max = 256;
    def.contacts_max = 4096;
    World w = made(World::create(def, {}, assets.library));
    add(w, {.kind = BodyKind::static_, .pose = at(0, -3, 0)}, {.geometry = plane()});
    add(w, {.kind = BodyKind::static_, .pose = at(-8, 0, 0)},
        {.geometry = instance(ShapeKind::mesh, assets.mesh)});
    add(w, {.kind = BodyKind::static_, .pose = at(0, 0, -8)},
        {.geometry = instance(ShapeKind::height_field, assets.field)});
    for (int k = 0; k < count; ++k) {
        const int i = order.empty() ? k : order[static_cast<std::size_t>(k)];
        RandomPoint random(static_cast<std::uint64_t>(i) + 100);
        add(w,
            {.kind = i % 11 == 10 ? BodyKind::kinematic : BodyKind::dynamic,
             .pose = {vec3(random.point(12, 1, 10)), random.rotation()},
             .linear_velocity = vec3(random.point(2, -2, 2)),
             .angular_velocity = vec3(random.point(3, -3, 3)),
             .user_key = static_cast<std::uint64_t>(i)},
            {.geometry = moving_geometry(assets, i),
             .category = 1u << (i % 3),
             .sensor = i % 13 == 12 ? 1u : 0u});
    }
    return w;
}

/// The results of queries as bytes, in a fixed order.
struct Answers {
    std::vector<std::byte> bytes;

    template <class T> void put(const T& value) {
        const auto raw = std::as_bytes(std::span(&value, 1));
        bytes.insert(bytes.end(), raw.begin(), raw.end());
    }
    void put(const QueryHit& h) {
        put(h.shape), put(h.body), put(h.distance), put(h.fraction), put(h.point), put(h.normal),
            put(h.feature);
    }
    void put(const std::optional<QueryHit>& h) {
        put(h.has_value());
        if (h) put(*h);
    }
    friend bool operator==(const Answers&, const Answers&) = default;
};

inline Ray random_ray(RandomPoint& random) {
    const D3 from = random.point(14, -2, 12), to = random.point(14, -4, 12);
    const double far = random(0, 1) < 0.2 ? 500 : 1;
    return {vec3(from), vec3(far * (to - from))};
}

/// `count` random queries of all kinds.
inline Answers ask(const World& w, const Assets& assets, std::uint64_t seed, int count) {
    RandomPoint random(seed);
    Answers answers;
    std::vector<QueryHit> hits;
    std::vector<ShapeId> shapes;
    for (int i = 0; i < count; ++i) {
        const Ray ray = random_ray(random);
        const QueryFilter filter{.mask = random(0, 1) < 0.5 ? ~0u : 5u,
                                 .kinds = random(0, 1) < 0.5 ? 7u : 5u,
                                 .sensors = i % 2 == 0 ? 1u : 0u};
        const Geometry g = moving_geometry(assets, i);
        const Transform pose{ray.from, random.rotation()};
        switch (i % 8) {
        case 0:
            answers.put(w.cast_ray(ray, filter));
            break;
        case 1:
            w.cast_ray_all(ray, filter, hits);
            for (const QueryHit& hit : hits) answers.put(hit);
            break;
        case 2:
            answers.put(w.cast_ray_any(ray, filter));
            break;
        case 3:
            answers.put(w.cast_shape(g, pose, ray.translation, filter));
            break;
        case 4:
            w.cast_shape_all(g, pose, ray.translation, filter, hits);
            for (const QueryHit& hit : hits) answers.put(hit);
            break;
        case 5:
            w.overlap(g, pose, filter, shapes);
            for (const ShapeId id : shapes) answers.put(id);
            break;
        case 6:
            answers.put(w.nearest(g, pose, real(random(0, 10)), filter));
            break;
        default:
            const auto shape_of = [&] {
                const BodyId body = w.body_at(static_cast<std::uint32_t>(random.engine() % w.body_count()));
                return w.shapes(body).front();
            };
            const ShapeId a = shape_of(), b = shape_of();
            const std::optional<ShapeDistance> d = w.distance(a, b);
            answers.put(d.has_value());
            if (d)
                answers.put(d->distance), answers.put(d->on_a), answers.put(d->on_b), answers.put(d->normal);
        }
    }
    return answers;
}

} // namespace lockstone::test::query
