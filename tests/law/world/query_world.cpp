// Results of a world's queries: their order, filters, agreement between queries, and invalid arguments.
#include "support/about.h"
#include "support/query_scene.h"
#include "support/rigs/asked.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

using namespace lockstone;
using namespace lockstone::test::query;

namespace {

/// Returns the parts of the hits that do not depend on ids, sorted.
std::vector<std::array<std::int64_t, 3>> keys_of(const World& w, const std::vector<QueryHit>& hits) {
    std::vector<std::array<std::int64_t, 3>> keys;
    for (const QueryHit& h : hits)
        keys.push_back({h.distance.raw, static_cast<std::int64_t>(w.user_key(h.body)), h.feature});
    std::sort(keys.begin(), keys.end());
    return keys;
}

bool same(const std::optional<QueryHit>& a, const std::optional<QueryHit>& b) {
    Answers x, y;
    x.put(a);
    y.put(b);
    return x == y;
}

/// The results of three queries along one ray or one moving shape.
struct AlongAWay {
    std::vector<QueryHit> all;
    std::optional<QueryHit> first;
    bool any;
};
AlongAWay ask_ray(const World& w, const Ray& ray) {
    AlongAWay answer{{}, w.cast_ray(ray), w.cast_ray_any(ray)};
    w.cast_ray_all(ray, {}, answer.all);
    return answer;
}
AlongAWay ask_shape(const World& w, const Geometry& g, const Transform& pose, Vec3 way) {
    AlongAWay answer{{}, w.cast_shape(g, pose, way), w.cast_shape_any(g, pose, way)};
    w.cast_shape_all(g, pose, way, {}, answer.all);
    return answer;
}
/// Returns whether all hits are in order, `first` is the first of them, and `any` is true exactly when there is one.
bool agrees(const AlongAWay& answer) {
    for (std::size_t i = 1; i < answer.all.size(); ++i)
        if (!(answer.all[i - 1] < answer.all[i])) return false;
    return answer.any == !answer.all.empty() &&
           same(answer.first, answer.all.empty() ? std::nullopt : std::optional(answer.all.front()));
}

/// The shapes that overlap a place, and the nearest one within 6 m.
struct AtAPlace {
    std::vector<ShapeId> overlapping;
    std::optional<QueryHit> nearest;
};
AtAPlace ask_place(const World& w, const Geometry& g, const Transform& pose) {
    AtAPlace answer{{}, w.nearest(g, pose, 6_r)};
    w.overlap(g, pose, {}, answer.overlapping);
    return answer;
}
/// Returns whether the shapes are in order, an overlap has distance zero, and a body of that shape at that place has
/// the reported distance to the nearest shape, while no shape is nearer.
bool agrees(const World& w, const Geometry& g, const Transform& pose, const AtAPlace& answer) {
    const std::optional<QueryHit>& nearest = answer.nearest;
    if (!std::is_sorted(answer.overlapping.begin(), answer.overlapping.end())) return false;
    if (!answer.overlapping.empty())
        return nearest && nearest->distance == Real{} && nearest->shape == answer.overlapping.front();
    if (!nearest) return !w.nearest(g, pose, 6_r);
    if (nearest->distance == Real{}) return false;
    World other = w.clone();
    const BodyId probe = other.create_body({.kind = BodyKind::static_, .pose = pose}).value();
    const ShapeId probe_shape = other.create_shape(probe, {.geometry = g}).value();
    const std::optional<ShapeDistance> d = other.distance(nearest->shape, probe_shape),
                                       back = other.distance(probe_shape, nearest->shape);
    return d && std::abs(to_double(d->distance) - to_double(nearest->distance)) <= 3e-6 && back &&
           back->distance == d->distance && std::abs(to_double(back->normal.y + d->normal.y)) <= 1e-6 &&
           !w.nearest(g, pose, nearest->distance - 0.001_r);
}

/// The number of random queries whose results differ between two worlds, and of those that hit a shape.
struct Differences {
    int wrong = 0, met = 0;
};
Differences differences(const Assets& assets, const World& w, const World& other, int questions) {
    RandomPoint random(4);
    Differences found;
    for (int i = 0; i < questions; ++i) {
        const Ray ray = random_ray(random);
        const Transform pose{ray.from, random.rotation()};
        const auto ask = [&](const World& of) {
            return i % 2 == 0 ? ask_ray(of, ray)
                              : ask_shape(of, moving_geometry(assets, i), pose, ray.translation);
        };
        const AlongAWay answer = ask(w);
        found.wrong += keys_of(w, answer.all) != keys_of(other, ask(other).all);
        found.met += !answer.all.empty();
    }
    return found;
}

} // namespace

TEST_CASE("a cast returns the first of all hits and sorts all hits and an any cast reports if there is one") {
    const Assets assets;
    World w = crowd(assets, 80);
    for (int t = 0; t < 30; ++t) w.tick();
    RandomPoint random(3);
    int several = 0, wrong = 0;
    for (int i = 0; i < 2300; ++i) {
        const Ray ray = random_ray(random);
        const Transform pose{ray.from, random.rotation()};
        const AlongAWay answer =
            i < 2000 ? ask_ray(w, ray) : ask_shape(w, moving_geometry(assets, i), pose, ray.translation);
        wrong += !agrees(answer);
        several += answer.all.size() > 1;
    }
    CHECK(wrong == 0);
    CHECK(several > 200);
}

TEST_CASE("planted: the test detects hits that are out of order or lost or moved or denied") {
    const Assets assets;
    const World w = crowd(assets, 80);
    RandomPoint random(3);
    int planted = 0, noticed = 0;
    for (int i = 0; i < 1000; ++i) {
        const AlongAWay good = ask_ray(w, random_ray(random));
        if (good.all.size() < 2) continue;
        AlongAWay bad[] = {good, good, good, good, good};
        std::swap(bad[0].all[0], bad[0].all[1]);
        bad[1].all.erase(bad[1].all.begin());
        bad[2].any = false;
        bad[3].first->distance += Real::from_raw(1);
        bad[4].first.reset();
        for (const AlongAWay& b : bad) ++planted, noticed += !agrees(b);
    }
    CHECK(planted > 200);
    CHECK(noticed == planted);
}

TEST_CASE("ray and shape casts do not depend on the order in which bodies were created") {
    const Assets assets;
    std::vector<int> order(60);
    std::iota(order.begin(), order.end(), 0);
    const World w = crowd(assets, 60);
    std::shuffle(order.begin(), order.end(), std::mt19937_64(9));
    const Differences found = differences(assets, w, crowd(assets, 60, order), 1000);
    CHECK(found.wrong == 0);
    CHECK(found.met > 300);
    // A world in which one body lies elsewhere.
    World other = crowd(assets, 60);
    const BodyId last = other.body_at(other.body_count() - 1);
    done(other.set_pose(last, {other.pose(last).position + vec(0.01, 0, 0), other.pose(last).rotation}));
    CHECK(differences(assets, w, other, 1000).wrong > 0);
}

TEST_CASE("overlap and nearest and distance queries agree and the test detects a damaged answer") {
    const Assets assets;
    World w = crowd(assets, 60);
    for (int t = 0; t < 20; ++t) w.tick();
    RandomPoint random(6);
    int wrong = 0, overlapping = 0, near = 0, planted = 0, noticed = 0;
    for (int i = 0; i < 600; ++i) {
        const Geometry g = moving_geometry(assets, i);
        const Transform pose{vec3(random.point(10, -1, 6)), random.rotation()};
        const AtAPlace answer = ask_place(w, g, pose);
        wrong += !agrees(w, g, pose, answer);
        overlapping += !answer.overlapping.empty();
        near += answer.overlapping.empty() && answer.nearest;
        const auto plant = [&](const AtAPlace& bad) { ++planted, noticed += !agrees(w, g, pose, bad); };
        if (!answer.nearest || i % 5 != 0) continue;
        plant({answer.overlapping, {}});
        AtAPlace farther = answer;
        farther.nearest->distance += 0.002_r;
        plant(farther);
        if (answer.overlapping.empty())
            plant({{answer.nearest->shape}, answer.nearest}); // an overlap must have distance zero
        else
            plant({{}, answer.nearest});
    }
    CHECK(wrong == 0);
    CHECK(overlapping > 50);
    CHECK(near > 50);
    CHECK(planted > 100);
    CHECK(noticed == planted);
}

TEST_CASE("query filters select by category and body kind and sensor and ignored body") {
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
    CHECK(to_double(hits[0].distance) == test::about(1.5));
    CHECK(to_double(hits[0].fraction) == test::about(0.075));
    CHECK(to_double(hits[0].normal.x) == test::about(-1));
    CHECK(to_double(hits[0].point.x) == test::about(1.5));
}

TEST_CASE("casts without overlaps return the other hits of casts with overlaps") {
    int left_out = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) CHECK(test::overlaps_seen_fault(seed, left_out) == "");
    CHECK(left_out > 100);
}

TEST_CASE("cast_rays() returns the hits of single rays for as many rays as the output has room") {
    const Assets assets;
    const World w = crowd(assets, 40);
    RandomPoint random(8);
    std::vector<Ray> rays;
    for (int i = 0; i < 50; ++i) rays.push_back(random_ray(random));
    std::vector<std::optional<QueryHit>> hits(40);
    w.cast_rays(rays, {}, hits);
    int wrong = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) wrong += !same(hits[i], w.cast_ray(rays[i]));
    CHECK(wrong == 0);
}

TEST_CASE("a ray finds the right hit far from the origin and over 16 km") {
    World w = made(World::create(weightless()));
    const double far = 20000;
    const BodyId ball = add_ball(w, at(far, far, -far), 0.5);
    const BodyId beyond = add_ball(w, at(5e8, 0, 0), 0.5);
    const auto hit = w.cast_ray({vec(far - 15000, far, -far), vec(15900, 0, 0)});
    REQUIRE(hit);
    CHECK(hit->body == ball);
    CHECK(to_double(hit->distance) == test::about(14999.5, 1e-11));
    CHECK(!w.cast_ray({vec(far - 15000, far + 0.51, -far), vec(15900, 0, 0)}));
    const auto edge = w.cast_ray({vec(5e8 - 3, 0.4, 0), vec(10, 0, 0)});
    REQUIRE(edge);
    CHECK(edge->body == beyond);
    CHECK(to_double(edge->distance) == test::about(2.7, 1e-6));
    World p = made(World::create(weightless()));
    add_floor(p);
    const auto ground = p.cast_ray({vec(3e8, 100, -7e8), vec(300, -400, 0)});
    REQUIRE(ground);
    CHECK(to_double(ground->distance) == test::about(125));
    CHECK(std::abs(to_double(ground->point.y)) < 1e-6);
}
