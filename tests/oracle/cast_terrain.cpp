// Rays and balls against hulls, compounds, meshes and height fields: the reference tests every triangle in double
// precision.
#include "oracle/cast_double.h"

#include <doctest/doctest.h>

#include <array>
#include <cstdlib>
#include <string>

using namespace cast_oracle;
using collide::CastHit;

namespace {

struct Soup {
    std::vector<std::array<V, 3>> triangles;
};
Soup soup_of(const shapes::Solid& s) {
    Soup soup;
    std::vector<std::uint32_t> all;
    shapes::find_triangles(s, shapes::extent_of(s), all);
    for (const std::uint32_t i : all) {
        const shapes::Triangle t = shapes::triangle_at(s, i);
        soup.triangles.push_back({of(t.corner[0]), of(t.corner[1]), of(t.corner[2])});
    }
    return soup;
}

/// The fraction of the way at which a ray meets the front (or any side) of a triangle. `beside`: the distance of the
/// line from the rim, positive inside.
struct Meeting {
    double at, beside;
    bool is_front;
    double slack; ///< of `at`: a line 1e-7 m beside this one may meet a steep plane much earlier or later
};
std::optional<Meeting> meeting_of(const std::array<V, 3>& t, V from, V way) {
    const V n = cross(t[1] - t[0], t[2] - t[0]);
    const double slope = dot(n, way);
    if (slope == 0) return std::nullopt;
    const double at = dot(n, t[0] - from) / slope;
    const V p = from + way * at;
    double beside = 1e9;
    for (std::size_t k = 0; k < 3; ++k) {
        const V e = t[(k + 1) % 3] - t[k];
        beside = std::min(beside, dot(cross(n, e), p - t[k]) / (norm(n) * norm(e)));
    }
    return Meeting{at, beside, slope < 0, 1e-7 * norm(n) / std::abs(slope)};
}

/// The first meeting that is certainly inside a triangle, and the first that may be.
struct Bracket {
    double sure = 2, possible = 2; ///< plus the slack, minus the slack
};
Bracket bracket_of(const Soup& soup, V from, V way, bool two_sided, double tolerance) {
    Bracket b;
    for (const auto& t : soup.triangles) {
        const auto m = meeting_of(t, from, way);
        if (!m || (!m->is_front && !two_sided) || m->at < 0 || m->at > 1 || m->beside < -tolerance) continue;
        b.possible = std::min(b.possible, m->at - m->slack);
        if (m->beside > tolerance) b.sure = std::min(b.sure, m->at + m->slack);
    }
    return b;
}

std::string complaint(const Bracket& b, V way, bool found, const CastHit& hit) {
    const double slack = 2e-6;
    const double length = norm(way), t = found ? value(hit.distance) : 0;
    if (!found) return b.sure <= 1 ? "missed" : "";
    if (b.possible > 1) return "there is nothing to hit";
    if (t > std::min(b.sure, 1.0) * length + slack) return "late";
    if (t < b.possible * length - slack) return "early";
    return "";
}

struct Field {
    Solids solids;
    shapes::Solid solid;
    Soup soup;
};

std::vector<Length> bumps(RandomCast& random, std::uint32_t side, double height) {
    std::vector<Length> heights;
    for (std::uint32_t i = 0; i < side * side; ++i) heights.push_back(fixed<Length>(random(-height, height)));
    return heights;
}

shapes::Solid height_field(Solids& solids, RandomCast& random, std::uint32_t side, double spacing,
                           bool holes) {
    const std::vector<Length> heights = bumps(random, side, 2 * spacing);
    std::vector<std::uint8_t> cells;
    for (std::uint32_t i = 0; holes && i < (side - 1) * (side - 1); ++i)
        cells.push_back(random(0, 1) < 0.2 ? 255 : 1);
    const AssetId id = solids.library
                           ->add(bake_height_field({.columns = side,
                                                    .rows = side,
                                                    .spacing = fixed<Length>(spacing),
                                                    .heights = heights,
                                                    .cells = cells}))
                           .value();
    return solids(instance(ShapeKind::height_field, id));
}

/// A bumpy grid. `gap`: the distance by which one corner of one triangle is moved away from its neighbours.
shapes::Solid grid(Solids& solids, RandomCast& random, std::uint32_t side, double spacing, bool two_sided,
                   double gap) {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const double middle = spacing * (side - 1) / 2;
    for (std::uint32_t z = 0; z < side; ++z)
        for (std::uint32_t x = 0; x < side; ++x)
            vertices.push_back(
                {real(x * spacing - middle), real(random(-spacing, spacing)), real(z * spacing - middle)});
    for (std::uint32_t z = 0; z + 1 < side; ++z)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t at = z * side + x;
            triangles.push_back({at, at + side, at + side + 1});
            triangles.push_back({at, at + side + 1, at + 1});
        }
    if (gap != 0)
        for (auto& t : triangles) {
            const auto corner = static_cast<std::uint32_t>(vertices.size());
            Vec3 moved = vertices[t[0]];
            moved.x += real(gap);
            vertices.push_back(moved);
            t[0] = corner;
        }
    const AssetId id =
        solids.library->add(bake_mesh({.vertices = vertices, .triangles = triangles, .two_sided = two_sided}))
            .value();
    return solids(instance(ShapeKind::mesh, id));
}

template <class Damage>
std::string shoot(const shapes::Solid& s, RandomCast& random, int count, bool two_sided, Damage&& damage,
                  int& hits) {
    const Soup soup = soup_of(s);
    const shapes::Extent e = shapes::extent_of(s);
    const V low = of(e.lower), high = of(e.upper);
    collide::NarrowScratch scratch;
    for (int i = 0; i < count; ++i) {
        const V target{random(low.x, high.x), random(low.y, high.y), random(low.z, high.z)};
        V d = random.direction();
        if (i % 4 == 0) d = {0, random(0, 1) < 0.5 ? -1.0 : 1.0, 0};
        const double back = random(0, 1) < 0.3 ? random(0, 5) : random.size(1, 7000);
        const V from = of(coordinates(target - d * back)),
                way = of(coordinates(d * std::min(2.0 * back + 10, 16000.0)));
        CastHit hit{};
        bool found = collide::cast_ray(s, coordinates(from), coordinates(way), scratch, hit);
        damage(found, hit);
        hits += found;
        const std::string wrong = complaint(bracket_of(soup, from, way, two_sided, 1e-6), way, found, hit);
        if (!wrong.empty()) return "ray " + std::to_string(i) + ": " + wrong;
    }
    return "";
}
constexpr auto undamaged = [](bool&, CastHit&) {};

/// Counts the rays at corners and edge points inside the grid that pass through it.
int slips(double gap, int count) {
    RandomCast random{std::mt19937_64(3)};
    Solids solids;
    constexpr std::uint32_t side = 16;
    const shapes::Solid s = grid(solids, random, side, 1, true, gap);
    const Soup soup = soup_of(s);
    collide::NarrowScratch scratch;
    int missed = 0;
    for (int i = 0; i < count; ++i) {
        const auto& t = soup.triangles[random.engine() % soup.triangles.size()];
        const std::size_t k = random.engine() % 3;
        // Exactly on the edge: at quarters of its length.
        const double part = 0.25 * static_cast<double>(random.engine() % 4);
        const V p = t[k] * (1 - part) + t[(k + 1) % 3] * part;
        if (std::abs(p.x) > 6.9 || std::abs(p.z) > 6.9) continue;
        // A closed grid stops every line that is steep enough, at any height.
        const V down = unit({random(-0.1, 0.1), -1, random(-0.1, 0.1)});
        const V half = of(coordinates(down * (i % 2 == 0 ? 3 : random.size(2.5, 5000))));
        CastHit hit{};
        missed += !collide::cast_ray(s, coordinates(p - half), coordinates(half * 2), scratch, hit);
    }
    return missed;
}

double to_triangle(V p, const std::array<V, 3>& t) {
    const V n = cross(t[1] - t[0], t[2] - t[0]);
    bool inside = true;
    double rim = 1e9;
    for (std::size_t k = 0; k < 3; ++k) {
        const V a = t[k], e = t[(k + 1) % 3] - a;
        inside &= dot(cross(n, e), p - a) >= 0;
        rim = std::min(rim, norm(p - a - e * std::clamp(dot(p - a, e) / dot(e, e), 0.0, 1.0)));
    }
    return inside ? std::abs(dot(n, p - t[0])) / norm(n) : rim;
}

} // namespace

TEST_CASE("a ray hits the first front side of a mesh or height field at short range and over kilometres") {
    RandomCast random{std::mt19937_64(1)};
    Solids solids;
    int hits = 0;
    const int count = samples(400, 10000);
    CHECK(shoot(grid(solids, random, 20, 1, false, 0), random, count, false, undamaged, hits) == "");
    CHECK(shoot(grid(solids, random, 12, 0.05, true, 0), random, count, true, undamaged, hits) == "");
    CHECK(shoot(grid(solids, random, 9, 1500, true, 0), random, count, true, undamaged, hits) == "");
    CHECK(shoot(height_field(solids, random, 24, 1, false), random, count, false, undamaged, hits) == "");
    CHECK(shoot(height_field(solids, random, 24, 1, true), random, count, false, undamaged, hits) == "");
    CHECK(shoot(height_field(solids, random, 60, 40, true), random, count, false, undamaged, hits) == "");
    CHECK(hits > 3 * count / 2);
}

TEST_CASE("planted: the test detects a late or early or missing hit on a mesh") {
    Solids solids;
    const auto said = [&](auto&& damage) {
        RandomCast random{std::mt19937_64(2)};
        int hits = 0;
        return shoot(grid(solids, random, 8, 1, true, 0), random, 60, true, damage, hits);
    };
    CHECK(said([](bool&, CastHit& hit) { hit.distance += decimal<Coordinate>("0.00001"); }) != "");
    CHECK(said([](bool&, CastHit& hit) { hit.distance = hit.distance - decimal<Coordinate>("0.00001"); }) !=
          "");
    CHECK(said([](bool& found, CastHit&) { found = false; }) != "");
    CHECK(said([](bool& found, CastHit&) { found = true; }) != "");
}

TEST_CASE("a ray never slips through a shared edge or corner") {
    CHECK(slips(0, samples(4000, 100000)) == 0);
}

TEST_CASE("planted: rays slip through a mesh with cracks") { CHECK(slips(0.001, 4000) > 0); }

TEST_CASE("a ray hits a hull at its triangles and a compound at its parts") {
    RandomCast random{std::mt19937_64(4)};
    Solids solids;
    collide::NarrowScratch scratch;
    int wrong = 0, hits = 0;
    for (int h = 0; h < samples(30, 300); ++h) {
        std::vector<LengthVec3> points;
        for (int i = 0; i < 40; ++i) {
            const V p = random.in_box(1);
            points.push_back({fixed<Length>(p.x), fixed<Length>(0.3 * p.y), fixed<Length>(p.z)});
        }
        const shapes::Solid s =
            solids(instance(ShapeKind::hull, solids.library->add(bake_hull(points)).value()));
        Soup soup;
        for (const auto& t : s.hull->triangles)
            soup.triangles.push_back(
                {of(s.hull->vertices[t[0]]), of(s.hull->vertices[t[1]]), of(s.hull->vertices[t[2]])});
        for (int i = 0; i < 40; ++i) {
            const V d = random.direction(),
                    from = of(coordinates(random.in_box(1) - d * random.size(3, 3000)));
            const V way = of(coordinates(d * std::min(16000.0, norm(from) * 2)));
            CastHit hit{};
            const bool found = collide::cast_ray(s, coordinates(from), coordinates(way), scratch, hit);
            hits += found;
            wrong += !complaint(bracket_of(soup, from, way, false, 1e-5), way, found, hit).empty();
        }
        // A compound of the solid and a box, each rotated.
        const CompoundPart parts[] = {
            {s.geometry, {{1_r, 2_r, 3_r}, random.rotation()}},
            {box(0.5_r, 0.2_r, 0.7_r), {{-(1_r), 1_r, 3_r}, random.rotation()}},
            {rounded(box(0.2_r, 0.2_r, 0.7_r), 0.1_r), {{-(1_r), 3_r, 3_r}, random.rotation()}}};
        const shapes::Solid c =
            solids(instance(ShapeKind::compound, solids.library->add(bake_compound(parts)).value()));
        for (int i = 0; i < 40; ++i) {
            const V d = random.direction(),
                    from = of(coordinates(random.in_box(4) - d * random.size(1, 100)));
            const V way = of(coordinates(d * norm(from) * 2));
            CastHit hit{}, part_hit{};
            const bool found = collide::cast_ray(c, coordinates(from), coordinates(way), scratch, hit);
            double first = 1e9;
            for (const CompoundPart& part : parts) {
                const Rotation r = to_rotation(part.local.rotation);
                const CoordinateVec3 local =
                    mul_transposed<Coordinate>(r, coordinates(from) - to<Coordinate>(part.local.position));
                if (collide::cast_ray(solids(part.geometry), local,
                                      mul_transposed<Coordinate>(r, coordinates(way)), scratch, part_hit))
                    first = std::min(first, value(part_hit.distance));
            }
            wrong += found != (first < 1e9) || (found && std::abs(first - value(hit.distance)) > 1e-4);
        }
    }
    CHECK(wrong == 0);
    CHECK(hits > 100);
}

TEST_CASE("a moving ball stops where a mesh or height field is one radius away") {
    RandomCast random{std::mt19937_64(5)};
    Solids solids;
    collide::NarrowScratch scratch;
    const shapes::Solid terrains[] = {grid(solids, random, 12, 1, true, 0),
                                      height_field(solids, random, 12, 1, false)};
    int wrong = 0, hits = 0;
    for (const shapes::Solid& s : terrains) {
        const Soup soup = soup_of(s);
        const V middle = (of(shapes::extent_of(s).lower) + of(shapes::extent_of(s).upper)) * 0.5;
        const auto distance = [&](V p) {
            double best = 1e9;
            for (const auto& t : soup.triangles) best = std::min(best, to_triangle(p, t));
            return best;
        };
        for (int i = 0; i < samples(150, 4000); ++i) {
            const double radius = random.size(0.05, 1);
            const V target = middle + random.in_box(5),
                    down = unit({random(-0.3, 0.3), -1, random(-0.3, 0.3)});
            const V from = of(coordinates(target - down * random(5, 100))), way = of(coordinates(down * 200));
            CastHit hit{};
            const bool found = collide::cast_shape(s, solids(sphere(real(radius))),
                                                   {Rotation::identity(), coordinates(from)},
                                                   coordinates(way), scratch, hit);
            // At samples before the hit the distance is never below the radius.
            const double end = found ? value(hit.distance) : norm(way);
            const V d = unit(way);
            const double r = value(fixed<Length>(radius));
            // Beside the border a ball can get under the surface, whose back stops nothing.
            const V off = of(hit.point) - middle;
            if (found && std::max(std::abs(off.x), std::abs(off.z)) > 4.5) continue;
            if (found && hit.normal == UnitVec3{}) {
                wrong += distance(from) > r + 5e-6;
                continue;
            }
            hits += found;
            if (found) wrong += std::abs(distance(from + d * end) - r) > 5e-6;
            for (int k = 0; k < 40; ++k)
                wrong += found && distance(from + d * (std::max(0.0, end - 3.0 * k / 40))) < r - 5e-6;
            if (!found)
                for (int k = 0; k < 200; ++k) wrong += distance(from + d * k) < r - 5e-6;
        }
    }
    CHECK(wrong == 0);
    CHECK(hits > 100);
}
