// Rays against every kind of solid, judged in double precision from the definitions.
#include "oracle/cast_double.h"
#include "support/rigs/scale_field.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <string>

using namespace cast_oracle;
using collide::CastHit;

namespace {

constexpr int quick = 3000, thorough = 100000;

struct Shot {
    V from, way;
};
/// Shots at the solid or past it, from near, far, and inside.
Shot random_shot(RandomCast& random, const Body& s) {
    const double size = reach(s);
    const V target{random(-1.2, 1.2) * (s.half.x + s.radius), random(-1.2, 1.2) * (s.half.y + s.radius),
                   random(-1.2, 1.2) * (s.half.z + s.radius)};
    const V d = random.direction();
    const double kind = random(0, 1);
    const double back = kind < 0.1   ? 0.3 * size
                        : kind < 0.8 ? random.size(size, 20 * size + 1)
                                     : random(size, 9000);
    const double length = std::min(16000.0, kind < 0.2 ? back * random(0.5, 1.5) : 2 * back + size);
    V way = d * length;
    if (random(0, 1) < 0.1) { // along an axis: exact zeros
        way = random(0, 1) < 0.5 ? V{way.x, 0, 0} : V{0, way.y, 0};
        if (norm(way) < 1e-3) way = {0, 0, length};
    }
    return {target - d * back, way};
}

/// Returns an error sentence or an empty string. Grazing cases, which rounding decides, pass.
std::string complaint(const Body& s, V from, V way, bool found, const CastHit& hit, double tolerance) {
    const double length = norm(way);
    const V d = unit(way);
    const double middle = -dot(from, d), r = reach(s) * 1.001 + 1e-3;
    const double begin = std::clamp(middle - r, 0.0, length), end = std::clamp(middle + r, 0.0, length);
    const Entry truth = entry_of([&](double t) { return outside(s, from + d * t); }, begin, end);
    // Within the tolerance of just touching, both answers are right.
    if (!found)
        return truth.at && outside(s, from + d * truth.lowest) + s.radius * 0 <= 0 &&
                       [&] {
                           Body thin = s;
                           thin.radius -= 2 * tolerance;
                           thin.half = {s.half.x - (s.radius > 0 ? 0 : 2 * tolerance),
                                        s.half.y - (s.radius > 0 ? 0 : 2 * tolerance),
                                        s.half.z - (s.radius > 0 ? 0 : 2 * tolerance)};
                           if (s.radius == 0) thin.radius = 0;
                           return entry_of([&](double t) { return outside(thin, from + d * t); }, begin, end)
                               .at.has_value();
                       }()
                   ? "missed"
                   : "";
    const double t = value(hit.distance);
    if (hit.normal == UnitVec3{}) {
        if (hit.distance != Coordinate{}) return "a zero normal beyond the start";
        return outside(s, from) <= tolerance ? "" : "starts inside, it says";
    }
    const double off = outside(s, of(hit.point));
    if (std::abs(off) > tolerance &&
        !(s.radius == 0 && off <= 0 &&
          support(s, of(hit.normal)) - dot(of(hit.normal), of(hit.point)) < tolerance))
        return "the point is " + std::to_string(off * 1e6) + " um off the surface";
    if (norm(from + d * t - of(hit.point)) > tolerance + t * 1e-9) return "the point is not on the ray";
    if (std::abs(value(hit.fraction) - t / length) > 2e-9 + 1e-7 / length)
        return "fraction and distance disagree";
    const V n = of(hit.normal);
    if (std::abs(norm(n) - 1) > 1e-8) return "the normal is not a unit vector";
    const double cosine = -dot(n, d);
    if (cosine < -1e-6) return "the normal is with the ray";
    if (support(s, n) - dot(n, of(hit.point)) > tolerance + 1e-6 * reach(s))
        return "the normal does not support the solid";
    if (!truth.at) return truth.least < tolerance * 4 ? "" : "there is nothing to hit";
    const double slack = tolerance / std::max(cosine, 1e-3);
    if (t > *truth.at + slack + 1e-7 && cosine > 0.02)
        return "late by " + std::to_string((t - *truth.at) * 1e6) + " um";
    if (t < *truth.at - slack - 1e-7 && cosine > 0.02)
        return "early by " + std::to_string((*truth.at - t) * 1e6) + " um";
    return "";
}

double tolerance_of(const Body& s) {
    return (s.radius > 0 && s.kind != ShapeKind::sphere && s.kind != ShapeKind::capsule ? 2e-6 : 2e-7) +
           4e-9 * reach(s);
}

struct Tally {
    int shots = 0, hits = 0, starts = 0, wrong = 0;
    std::string first;
};

template <class Damage>
Tally shoot(Solids& solids, ShapeKind kind, bool round, double scale, int count, Damage&& damage) {
    RandomCast random{std::mt19937_64(static_cast<std::uint64_t>(kind) * 2 + round + 17)};
    collide::NarrowScratch scratch;
    Tally tally;
    for (int i = 0; i < count; ++i) {
        Geometry g = random_primitive(random, kind, scale > 1 ? 1 : 0.01, scale > 1 ? 90 : 20, round);
        if (kind == ShapeKind::capsule && g.half_extent.y + g.radius > shape_size_max) continue;
        g = test::with_scale(g, real(scale));
        const Body s = body_of(g);
        const Shot shot = random_shot(random, s);
        const CoordinateVec3 from = coordinates(shot.from), way = coordinates(shot.way);
        if (norm(of(way)) < 1e-4) continue;
        CastHit hit{};
        bool found = collide::cast_ray(solids(g), from, way, scratch, hit);
        damage(found, hit);
        const std::string wrong = complaint(s, of(from), of(way), found, hit, tolerance_of(s));
        ++tally.shots;
        tally.hits += found;
        tally.starts += found && hit.normal == UnitVec3{};
        if (wrong.empty()) continue;
        if (tally.wrong++ == 0)
            tally.first =
                "shot " + std::to_string(i) + " at " + name_of(kind) + (round ? ", rounded: " : ": ") + wrong;
    }
    return tally;
}

constexpr auto undamaged = [](bool&, CastHit&) {};
constexpr ShapeKind primitives[] = {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::cylinder,
                                    ShapeKind::cone, ShapeKind::box};

} // namespace

TEST_CASE("a ray hits a primitive where double precision computes the hit") {
    Solids solids;
    for (const ShapeKind kind : primitives) {
        const Tally t = shoot(solids, kind, false, 1, samples(quick, thorough), undamaged);
        INFO(t.first);
        CHECK(t.wrong == 0);
        CHECK(t.hits > t.shots / 10);
        CHECK(t.starts > 0);
        const Tally large = shoot(solids, kind, false, 8, samples(quick / 10, thorough / 10), undamaged);
        INFO(large.first);
        CHECK(large.wrong == 0);
    }
}

TEST_CASE("a ray hits a rounded primitive where double precision computes the hit") {
    Solids solids;
    for (const ShapeKind kind : {ShapeKind::cylinder, ShapeKind::cone, ShapeKind::box}) {
        const Tally t = shoot(solids, kind, true, 1, samples(quick / 3, thorough / 3), undamaged);
        INFO(t.first);
        CHECK(t.wrong == 0);
        CHECK(t.hits > t.shots / 10);
    }
}

TEST_CASE("planted: the test detects a wrong distance or normal or verdict of a ray") {
    Solids solids;
    const auto wrong = [&](auto&& damage) {
        return shoot(solids, ShapeKind::cone, false, 1, 300, damage).wrong;
    };
    CHECK(wrong([](bool&, CastHit& hit) {
              hit.distance += decimal<Coordinate>("0.00001"), hit.point.x += decimal<Coordinate>("0.00001");
          }) > 20);
    CHECK(wrong([](bool&, CastHit& hit) { hit.normal = -hit.normal; }) > 20);
    CHECK(wrong([](bool&, CastHit& hit) { std::swap(hit.normal.x, hit.normal.y); }) > 20);
    CHECK(wrong([](bool& found, CastHit&) { found = false; }) > 20);
}
