// What a world answers: order, filters, agreement of the questions with each other, and nonsense.
#include "support/query_scene.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

using namespace lockstone;
using namespace lockstone::test::query;

namespace {

/// Hits by what does not depend on ids.
std::vector<std::array<std::int64_t, 3>> keys_of(const World& w, const std::vector<QueryHit>& hits) {
    std::vector<std::array<std::int64_t, 3>> keys;
    for (const QueryHit& h : hits)
        keys.push_back({h.distance.raw, static_cast<std::int64_t>(w.user_key(h.body)), h.feature});
    std::sort(keys.begin(), keys.end());
    return keys;
}

bool is_sorted(const std::vector<QueryHit>& hits) {
    for (std::size_t i = 1; i < hits.size(); ++i)
        if (!(hits[i - 1] < hits[i])) return false;
    return true;
}

bool same(const std::optional<QueryHit>& a, const std::optional<QueryHit>& b) {
    Answers x, y;
    x.put(a);
    y.put(b);
    return x == y;
}

} // namespace

TEST_CASE("the first hit is the first of all hits, which are in order, and any says whether there is one") {
    const Assets assets;
    World w = crowd(assets, 80);
    for (int t = 0; t < 30; ++t) w.tick();
    Random random(3);
    std::vector<QueryHit> hits;
    int several = 0, wrong = 0;
    for (int i = 0; i < 2000; ++i) {
        const Ray ray = random_ray(random);
        w.cast_ray_all(ray, {}, hits);
        wrong += !is_sorted(hits);
        wrong += w.cast_ray_any(ray) == hits.empty();
        wrong += !same(w.cast_ray(ray), hits.empty() ? std::nullopt : std::optional(hits.front()));
        several += hits.size() > 1;
    }
    for (int i = 0; i < 300; ++i) {
        const Ray ray = random_ray(random);
        const Transform pose{ray.from, random.rotation()};
        const Geometry g = moving_geometry(assets, i);
        w.cast_shape_all(g, pose, ray.translation, {}, hits);
        wrong += !is_sorted(hits);
        wrong += w.cast_shape_any(g, pose, ray.translation) == hits.empty();
        wrong += !same(w.cast_shape(g, pose, ray.translation),
                       hits.empty() ? std::nullopt : std::optional(hits.front()));
        several += hits.size() > 1;
    }
    CHECK(wrong == 0);
    CHECK(several > 200);
}

TEST_CASE("what a ray or a shape meets does not depend on the order in which things were made") {
    const Assets assets;
    std::vector<int> order(60);
    std::iota(order.begin(), order.end(), 0);
    const World w = crowd(assets, 60);
    std::shuffle(order.begin(), order.end(), std::mt19937_64(9));
    const World shuffled = crowd(assets, 60, order);
    Random random(4);
    std::vector<QueryHit> a, b;
    int wrong = 0, met = 0;
    for (int i = 0; i < 1000; ++i) {
        const Ray ray = random_ray(random);
        if (i % 2 == 0) {
            w.cast_ray_all(ray, {}, a);
            shuffled.cast_ray_all(ray, {}, b);
        } else {
            const Transform pose{ray.from, random.rotation()};
            w.cast_shape_all(moving_geometry(assets, i), pose, ray.translation, {}, a);
            shuffled.cast_shape_all(moving_geometry(assets, i), pose, ray.translation, {}, b);
        }
        wrong += keys_of(w, a) != keys_of(shuffled, b);
        met += !a.empty();
    }
    CHECK(wrong == 0);
    CHECK(met > 300);
}

TEST_CASE("overlap, nearest and distance agree") {
    const Assets assets;
    World w = crowd(assets, 60);
    for (int t = 0; t < 20; ++t) w.tick();
    Random random(6);
    int wrong = 0, overlapping = 0, near = 0;
    std::vector<ShapeId> shapes;
    for (int i = 0; i < 400; ++i) {
        const Geometry g = moving_geometry(assets, i);
        const Transform pose{vec3(random.point(10, -1, 6)), random.rotation()};
        w.overlap(g, pose, {}, shapes);
        const std::optional<QueryHit> nearest = w.nearest(g, pose, 6_r);
        wrong += !std::is_sorted(shapes.begin(), shapes.end());
        if (!shapes.empty()) {
            ++overlapping;
            wrong += !nearest || nearest->distance != Real{} || nearest->shape != shapes.front();
            continue;
        }
        if (!nearest) continue;
        ++near;
        // A body of that shape there is as far from it.
        World other = w.clone();
        const BodyId probe = other.create_body({.kind = BodyKind::static_, .pose = pose}).value();
        const ShapeId probe_shape = other.create_shape(probe, {.geometry = g}).value();
        const std::optional<ShapeDistance> d = other.distance(nearest->shape, probe_shape);
        const std::optional<ShapeDistance> back = other.distance(probe_shape, nearest->shape);
        wrong += !d || std::abs(to_double(d->distance) - to_double(nearest->distance)) > 3e-6;
        wrong += !back || back->distance != d->distance ||
                 std::abs(to_double(back->normal.y + d->normal.y)) > 1e-6;
        // A ball of that radius about the nearest point touches it, and no smaller one does.
        wrong += w.nearest(g, pose, nearest->distance - 0.001_r).has_value();
    }
    CHECK(wrong == 0);
    CHECK(overlapping > 50);
    CHECK(near > 50);
}

TEST_CASE("filters: categories, kinds, sensors and the own body") {
    World w = made(World::create(small_def()));
    const auto ball = [&](double x, const BodyKind kind, std::uint32_t category, std::uint32_t mask,
                          std::uint32_t sensor) {
        return add(w, {.kind = kind, .pose = at(x, 0, 0)},
                   {.geometry = sphere(0.5_r), .category = category, .mask = mask, .sensor = sensor});
    };
    const BodyId a = ball(2, BodyKind::static_, 1, ~0u, 0), b = ball(4, BodyKind::kinematic, 2, ~0u, 0);
    const BodyId c = ball(6, BodyKind::dynamic, 4, 1, 0), d = ball(8, BodyKind::dynamic, 8, ~0u, 1);
    std::vector<QueryHit> hits;
    const auto bodies = [&](const QueryFilter& filter) {
        w.cast_ray_all({Vec3{}, vec(20, 0, 0)}, filter, hits);
        std::vector<BodyId> out;
        for (const QueryHit& hit : hits) out.push_back(hit.body);
        return out;
    };
    CHECK(bodies({}) == std::vector{a, b, c});
    CHECK(bodies({.sensors = 1}) == std::vector{a, b, c, d});
    CHECK(bodies({.mask = 6}) == std::vector{b, c});
    CHECK(bodies({.category = 2}) == std::vector{a, b});
    CHECK(bodies({.kinds = 1}) == std::vector{a});
    CHECK(bodies({.kinds = 6}) == std::vector{b, c});
    CHECK(bodies({.ignore = b}) == std::vector{a, c});
    CHECK(to_double(hits[0].distance) == doctest::Approx(1.5));
    CHECK(to_double(hits[0].fraction) == doctest::Approx(0.075));
    CHECK(to_double(hits[0].normal.x) == doctest::Approx(-1));
    CHECK(to_double(hits[0].point.x) == doctest::Approx(1.5));
}

TEST_CASE("batches answer like single rays, as many as there is room for") {
    const Assets assets;
    const World w = crowd(assets, 40);
    Random random(8);
    std::vector<Ray> rays;
    for (int i = 0; i < 50; ++i) rays.push_back(random_ray(random));
    std::vector<std::optional<QueryHit>> hits(40);
    w.cast_rays(rays, {}, hits);
    int wrong = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) wrong += !same(hits[i], w.cast_ray(rays[i]));
    CHECK(wrong == 0);
}

TEST_CASE("far from the origin and over 16 km a ray meets what it should") {
    World w = made(World::create(weightless()));
    const double far = 20000;
    const BodyId ball = add_ball(w, at(far, far, -far), 0.5);
    const BodyId beyond = add_ball(w, at(5e8, 0, 0), 0.5);
    const auto hit = w.cast_ray({vec(far - 15000, far, -far), vec(15900, 0, 0)});
    REQUIRE(hit);
    CHECK(hit->body == ball);
    CHECK(to_double(hit->distance) == doctest::Approx(14999.5).epsilon(1e-11));
    CHECK(!w.cast_ray({vec(far - 15000, far + 0.51, -far), vec(15900, 0, 0)}));
    const auto edge = w.cast_ray({vec(5e8 - 3, 0.4, 0), vec(10, 0, 0)});
    REQUIRE(edge);
    CHECK(edge->body == beyond);
    CHECK(to_double(edge->distance) == doctest::Approx(2.7).epsilon(1e-6));
    World p = made(World::create(weightless()));
    add_floor(p);
    const auto ground = p.cast_ray({vec(3e8, 100, -7e8), vec(300, -400, 0)});
    REQUIRE(ground);
    CHECK(to_double(ground->distance) == doctest::Approx(125));
    CHECK(to_double(ground->point.y) == doctest::Approx(0));
}

TEST_CASE("nonsense gets an empty answer") {
    const Assets assets;
    World w = crowd(assets, 10);
    const Ray long_ray{vec(0, 9000, 0), vec(0, -17000, 0)};
    std::vector<QueryHit> hits(3);
    std::vector<ShapeId> shapes(3);
    CHECK(!w.cast_ray(long_ray));
    CHECK(!w.cast_ray_any({Vec3{}, {Real::max(), Real::min(), Real::max()}}));
    w.cast_ray_all(long_ray, {}, hits);
    CHECK(hits.empty());
    CHECK(!w.cast_ray({{Real::max(), Real::min(), Real::max()}, vec(1, 1, 1)}));
    CHECK(w.cast_ray({vec(0, -5, 0), Vec3{}})); // in the half-space below the plane
    const Geometry bad[] = {sphere(Real{}),
                            sphere(-(1_r)),
                            box(1_r, 1000_r, 1_r),
                            plane(),
                            instance(ShapeKind::mesh, assets.mesh),
                            instance(ShapeKind::hull, AssetId{12345}),
                            Geometry{static_cast<ShapeKind>(77), Length{}, LengthVec3{}}};
    for (const Geometry& g : bad) {
        CHECK(!w.cast_shape(g, Transform::identity(), vec(0, -10, 0)));
        CHECK(!w.nearest(g, Transform::identity(), 100_r));
        w.overlap(g, Transform::identity(), {}, shapes);
        CHECK(shapes.empty());
    }
    CHECK(!w.nearest(sphere(1_r), Transform::identity(), -(1_r)));
    CHECK(w.nearest(sphere(1_r), {vec(0, 3, 0), Quat{}}, Real::max()));
    const ShapeId alive = w.shapes(w.body_at(5)).front(), mesh = w.shapes(w.body_at(1)).front(),
                  ground = w.shapes(w.body_at(0)).front();
    CHECK(w.distance(alive, mesh));
    CHECK(!w.distance(ground, mesh));
    CHECK(!w.distance(alive, ShapeId{}));
    CHECK(!w.distance({9999, 1}, alive));
    CHECK(!w.distance({alive.index, alive.generation + 1}, alive));
}
