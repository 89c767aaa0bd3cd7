// Moving convex shapes and distances, proved in double precision: a plane that separates the two shapes and a point in
// both prove a hit; a plane that separates them all the way proves a miss.
#include "oracle/cast_double.h"
#include "oracle/convex_double.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <string>

using namespace cast_oracle;
using collide::CastHit;
using collide::Nearest;
using collide::RelativePose;

namespace {

oracle::D3 d3(V v) { return {v.x, v.y, v.z}; }
V v3(oracle::D3 v) { return {v.x, v.y, v.z}; }

struct Pair {
    Geometry a, b;
    RelativePose pose;
};

oracle::DoubleCore core(const shapes::Solid& s, const Rotation& r, V p) { return {s, {r, coordinates(p)}}; }

/// The separation of the shapes along a direction from A to B, after B moved by `by`.
double parted(const oracle::DoubleCore& a, const oracle::DoubleCore& b, V n, V by = {0, 0, 0}) {
    return oracle::separation_along(a, b, d3(n)) + dot(n, by) - (a.radius + b.radius) * norm(n);
}

/// The nearest points of a smooth core, though not the distance, are a little off sideways.
double point_tolerance(const oracle::DoubleCore& a, const oracle::DoubleCore& b, double distance) {
    return a.is_smooth() || b.is_smooth() ? 5e-5 + 5e-5 * distance : 0;
}

/// Directions that separate the shapes somewhere on the way. Each separation is linear along the way, so together they
/// bound the distance from below everywhere: at the ends and where two of the lines cross.
struct Planes {
    std::vector<V> normals;

    double least(const oracle::DoubleCore& a, const oracle::DoubleCore& b, V way) const {
        std::vector<std::pair<double, double>> lines; // at the start, and the change to the end
        for (const V& n : normals)
            if (norm(n) > 0.5) lines.push_back({parted(a, b, n), dot(n, way)});
        const auto most = [&](double t) {
            double best = -1e9;
            for (const auto& [begin, change] : lines) best = std::max(best, begin + change * t);
            return best;
        };
        double worst = std::min(most(0), most(1));
        for (const auto& [b1, c1] : lines)
            for (const auto& [b2, c2] : lines)
                if (const double t = (b2 - b1) / (c1 - c2); c1 != c2 && t > 0 && t < 1)
                    worst = std::min(worst, most(t));
        return worst;
    }
};

std::string complaint(const oracle::DoubleCore& a, const oracle::DoubleCore& b, V way, bool found,
                      const CastHit& hit, const Planes& planes) {
    const double tolerance = 2.5e-6 + 1e-7 * (norm(v3(b.center)) + 10);
    const V d = unit(way);
    if (found && hit.normal == UnitVec3{}) {
        if (hit.distance != Coordinate{}) return "a zero normal beyond the start";
        return parted(a, b, planes.normals.front()) > tolerance ? "they are apart at the start" : "";
    }
    if (found) {
        const V at = d * value(hit.distance), n = of(hit.normal);
        const double gap = parted(a, b, n, at), near = tolerance + point_tolerance(a, b, 0);
        if (gap < -tolerance) return "late: they overlap by " + std::to_string(-gap * 1e6) + " um";
        if (dot(n, d) > 1e-6) return "it moves away";
        if (a.outside(d3(of(hit.point))) > a.radius + near) return "the point is not on the solid";
        if (b.outside(d3(of(hit.point) - at)) > b.radius + near)
            return "the point is not on the moving shape";
        return "";
    }
    return planes.least(a, b, way) < -tolerance ? "missed, or not proved a miss" : "";
}

struct Tally {
    int casts = 0, hits = 0, starts = 0, wrong = 0;
    std::string first;
};

Geometry random_hull(RandomCast& random, Solids& solids) {
    std::vector<LengthVec3> points;
    const V half{random.size(0.05, 2), random.size(0.05, 2), random.size(0.05, 2)};
    for (int i = 0; i < 4 + static_cast<int>(random(0, 30)); ++i) {
        const V p = random.in_box(1);
        points.push_back(
            {fixed<Length>(p.x * half.x), fixed<Length>(p.y * half.y), fixed<Length>(p.z * half.z)});
    }
    const Result<AssetId> id = solids.library->add(bake_hull(points));
    return id ? instance(ShapeKind::hull, *id) : box(1_r, 1_r, 1_r);
}

constexpr ShapeKind kinds[] = {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::cylinder,
                               ShapeKind::cone,   ShapeKind::box,     ShapeKind::hull};

Geometry random_convex(RandomCast& random, Solids& solids) {
    const ShapeKind kind = kinds[random.engine() % 6];
    if (kind == ShapeKind::hull) return random_hull(random, solids);
    return random_primitive(random, kind, 0.02, 4, random(0, 1) < 0.3);
}

template <class Damage> Tally cast_many(int count, Damage&& damage) {
    RandomCast random{std::mt19937_64(4711)};
    Solids solids;
    collide::NarrowScratch scratch;
    Tally tally;
    for (int i = 0; i < count; ++i) {
        const Geometry ga = random_convex(random, solids), gb = random_convex(random, solids);
        const shapes::Solid a = solids(ga), b = solids(gb);
        const double back = random(0, 1) < 0.2 ? random(0, 3) : random.size(1, 300);
        const V target = random.in_box(3), d = random.direction();
        const V from = of(coordinates(target - d * back)),
                way = of(coordinates(d * (back * random(0.5, 2.5))));
        if (norm(way) < 1e-3) continue;
        const Rotation r = to_rotation(random.rotation());
        const RelativePose pose{r, coordinates(from)};
        CastHit hit{};
        bool found = collide::cast_shape(a, b, pose, coordinates(way), scratch, hit);
        damage(found, hit);
        Nearest least{};
        Planes planes;
        const auto near = [&](double t) {
            collide::nearest_points(a, b, {r, coordinates(from + way * t)}, Coordinate(10000), scratch,
                                    least);
            planes.normals.push_back(of(least.normal));
            return value(least.distance);
        };
        near(0);
        near(1);
        double low = 0, high = found ? 0 : 1;
        for (int k = 0; k < 60 && high > low + 1e-8; ++k) {
            const double x = low + (high - low) / 3, y = high - (high - low) / 3;
            const bool falls = near(x) > near(y);
            if (k % 4 != 3 && high > low + 1e-6) planes.normals.resize(planes.normals.size() - 2);
            (falls ? low : high) = falls ? x : y;
        }
        const std::string wrong =
            complaint(core(a, Rotation::identity(), {0, 0, 0}), core(b, r, from), way, found, hit, planes);
        ++tally.casts;
        tally.hits += found;
        tally.starts += found && hit.normal == UnitVec3{};
        if (wrong.empty()) continue;
        if (tally.wrong++ == 0)
            tally.first = "cast " + std::to_string(i) + ", " + name_of(gb.kind) + " at " + name_of(ga.kind) +
                          ": " + wrong;
    }
    return tally;
}

constexpr auto undamaged = [](bool&, CastHit&) {};

} // namespace

TEST_CASE("a moving convex shape stops where it first touches another shape") {
    const Tally t = cast_many(samples(1500, 40000), undamaged);
    INFO(t.first);
    CHECK(t.wrong == 0);
    CHECK(t.hits > t.casts / 4);
    CHECK(t.casts - t.hits > t.casts / 10);
    CHECK(t.starts > 0);
}

TEST_CASE("planted: the test detects a wrong cast of a shape") {
    CHECK(cast_many(200, [](bool&, CastHit& hit) { hit.distance += decimal<Coordinate>("0.0005"); }).wrong >
          20);
    CHECK(cast_many(200, [](bool&, CastHit& hit) {
              hit.distance = hit.distance - decimal<Coordinate>("0.0005");
          }).wrong > 20);
    CHECK(cast_many(200, [](bool& found, CastHit&) { found = false; }).wrong > 20);
    CHECK(cast_many(200, [](bool&, CastHit& hit) { hit.normal = -hit.normal; }).wrong > 20);
}

TEST_CASE("a plane between two convex shapes proves their nearest points") {
    RandomCast random{std::mt19937_64(99)};
    Solids solids;
    collide::NarrowScratch scratch;
    int wrong = 0, apart = 0, overlapping = 0;
    for (int i = 0; i < samples(2000, 50000); ++i) {
        const shapes::Solid a = solids(random_convex(random, solids)),
                            b = solids(random_convex(random, solids));
        const Rotation r = to_rotation(random.rotation());
        const V p = of(coordinates(random.in_box(random.size(1, 50))));
        const oracle::DoubleCore ca = core(a, Rotation::identity(), {0, 0, 0}), cb = core(b, r, p);
        Nearest n{};
        REQUIRE(collide::nearest_points(a, b, {r, coordinates(p)}, Coordinate(1000), scratch, n));
        if (n.normal == UnitVec3{}) {
            ++overlapping;
            wrong += n.distance != Coordinate{};
            continue;
        }
        ++apart;
        const double distance = value(n.distance), tolerance = 2e-6 + 1e-7 * norm(p);
        wrong += std::abs(norm(of(n.on_b) - of(n.on_a)) - distance) > tolerance;
        wrong += parted(ca, cb, of(n.normal)) < distance - tolerance; // the distance is at least that
        const double near = tolerance + point_tolerance(ca, cb, distance);
        wrong += ca.outside(d3(of(n.on_a))) > ca.radius + near; // and these points are within it
        wrong += cb.outside(d3(of(n.on_b))) > cb.radius + near;
        Nearest beyond{};
        wrong += collide::nearest_points(a, b, {r, coordinates(p)}, n.distance - fixed<Coordinate>(1e-4),
                                         scratch, beyond);
    }
    CHECK(wrong == 0);
    CHECK(apart > 500);
    CHECK(overlapping > 50);
}
