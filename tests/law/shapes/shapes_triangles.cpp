// Meshes and height fields: queries against brute force, neighbours, edges, and a comparison of the two.
#include "lockstone/math/math.h"
#include "oracle/double_shapes.h"
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/mesh.h"
#include "shapes/mesh/triangle.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <tuple>

using namespace lockstone;
using namespace lockstone::shapes;
using oracle::as_double;

namespace {

using Indices = std::array<std::uint32_t, 3>;

struct Soup {
    std::vector<Vec3> vertices;
    std::vector<Indices> triangles;
    std::vector<std::uint16_t> materials;

    MeshDef def() const { return {.vertices = vertices, .triangles = triangles, .materials = materials}; }
};

Real real(double x) { return oracle::as_fixed<Real>(x); }
Vec3 random_point(oracle::RandomReal& random, double size) {
    const double x = random.uniform(-size, size), y = random.uniform(-size, size),
                 z = random.uniform(-size, size);
    return {real(x), real(y), real(z)};
}

/// Small triangles scattered over a cube, and a few as large as the cube.
Soup strewn(oracle::RandomReal& random, std::uint32_t count, double size) {
    Soup soup;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3 at = random_point(random, size * 0.9);
        for (int k = 0; k < 3; ++k)
            soup.vertices.push_back(i % 50 == 0 ? random_point(random, size)
                                                : at + random_point(random, size * 0.05));
        soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        soup.materials.push_back(static_cast<std::uint16_t>(i));
    }
    return soup;
}

/// A library with one asset, and the solid of that asset.
struct Holder {
    AssetLibrary library;
    Solid solid;

    explicit Holder(const Result<AssetBytes>& baked, LengthVec3 scale = scale_one) {
        Result<AssetId> id = library.add(baked);
        REQUIRE_MESSAGE(id.ok(), (id.ok() ? "" : id.error().message));
        const Asset* asset = library.find(*id);
        solid = {.geometry = library.geometry(*id, scale).value(),
                 .height_field = asset->height_field.get(),
                 .mesh = asset->mesh.get()};
    }
};

Extent bounds_of(const Triangle& t) {
    return {min(t.corner[0], min(t.corner[1], t.corner[2])), max(t.corner[0], max(t.corner[1], t.corner[2]))};
}

/// Boxes that start or end exactly at triangles' bounds, besides random ones.
Extent random_box(oracle::RandomReal& random, const Solid& solid) {
    const Extent all = extent_of(solid);
    const auto pick = [&](int axis) {
        if (random.below(2) == 0) {
            const Extent e = bounds_of(triangle_at(solid, random.below(triangle_count(solid))));
            const Coordinate at = random.below(2) == 0 ? e.lower[axis] : e.upper[axis];
            return Coordinate::from_raw(at.raw + static_cast<std::int64_t>(random.below(3)) - 1);
        }
        const double low = as_double(all.lower[axis]), high = as_double(all.upper[axis]);
        return oracle::as_fixed<Coordinate>(random.uniform(low - 1, high + 1));
    };
    Extent box{};
    const bool small = random.below(2) == 0;
    for (int k = 0; k < 3; ++k) {
        const Coordinate a = pick(k);
        const Coordinate b =
            small ? a + Coordinate::from_raw((all.upper[k] - all.lower[k]).raw / 20) : pick(k);
        box.lower[k] = min(a, b);
        box.upper[k] = max(a, b);
    }
    return box;
}

std::vector<std::uint32_t> brute_force(const Solid& solid, const Extent& box) {
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < triangle_count(solid); ++i) {
        if (solid.height_field != nullptr && solid.height_field->is_hole(i)) continue;
        if (overlap(bounds_of(triangle_at(solid, i)), box)) out.push_back(i);
    }
    return out;
}

/// Counts the boxes whose query gives the brute-force result. `shifted` damages the queries.
int agreements(const Solid& solid, int boxes, Coordinate shifted = Coordinate{}) {
    oracle::RandomReal random(99);
    int good = 0;
    for (int i = 0; i < boxes; ++i) {
        Extent box = random_box(random, solid);
        std::vector<std::uint32_t> found;
        const std::vector<std::uint32_t> expected = brute_force(solid, box);
        box.lower.x += shifted;
        box.upper.x += shifted;
        find_triangles(solid, box, found);
        good += found == expected ? 1 : 0;
    }
    return good;
}

LengthVec3 factors(double x, double y, double z) {
    return {oracle::as_fixed<Length>(x), oracle::as_fixed<Length>(y), oracle::as_fixed<Length>(z)};
}

struct Terrain {
    std::uint32_t columns, rows;
    std::vector<Length> heights;
    std::vector<std::uint8_t> cells;

    HeightFieldDef def() const {
        return {.columns = columns,
                .rows = rows,
                .spacing = decimal<Length>("0.37"),
                .heights = heights,
                .cells = cells};
    }
};
Terrain random_terrain(oracle::RandomReal& random, std::uint32_t columns, std::uint32_t rows, bool holes) {
    Terrain t{columns, rows, {}, {}};
    for (std::uint32_t i = 0; i < columns * rows; ++i)
        t.heights.push_back(oracle::as_fixed<Length>(random.below(4) == 0 ? 0.25 : random.uniform(-2, 2)));
    for (std::uint32_t i = 0; holes && i < (columns - 1) * (rows - 1); ++i)
        t.cells.push_back(static_cast<std::uint8_t>(random.below(5) == 0 ? 255 : random.below(7)));
    return t;
}
/// The triangles of the terrain as a soup.
Soup soup_of(const Terrain& t) {
    Soup soup;
    const Real spacing = to<Real>(t.def().spacing);
    for (std::uint32_t r = 0; r < t.rows; ++r)
        for (std::uint32_t c = 0; c < t.columns; ++c)
            soup.vertices.push_back({spacing * c, to<Real>(t.heights[r * t.columns + c]), spacing * r});
    for (std::uint32_t r = 0; r + 1 < t.rows; ++r)
        for (std::uint32_t c = 0; c + 1 < t.columns; ++c) {
            const std::uint8_t cell = t.cells.empty() ? 0 : t.cells[r * (t.columns - 1) + c];
            if (cell == HeightField::hole) continue;
            const std::uint32_t a = r * t.columns + c, b = a + t.columns;
            soup.triangles.push_back({a, b, b + 1});
            soup.triangles.push_back({a, b + 1, a + 1});
            soup.materials.push_back(cell);
            soup.materials.push_back(cell);
        }
    return soup;
}

std::array<std::int64_t, 9> key_of(const Triangle& t) {
    std::array<std::int64_t, 9> key{};
    for (std::size_t i = 0; i < 9; ++i) key[i] = t.corner[i / 3][static_cast<int>(i % 3)].raw;
    return key;
}

/// Equal except for the last bit: one normal comes from slopes, the other from corners.
bool same(UnitVec3 a, UnitVec3 b) {
    const UnitVec3 d = abs(a - b);
    return max(d.x, max(d.y, d.z)) <= Unit::step();
}

/// Returns a sentence unless both have equal triangles with equal properties.
std::string difference(const Solid& field, const Solid& mesh) {
    std::map<std::array<std::int64_t, 9>, Triangle> of_mesh;
    for (std::uint32_t i = 0; i < triangle_count(mesh); ++i)
        of_mesh.emplace(key_of(triangle_at(mesh, i)), triangle_at(mesh, i));
    std::size_t seen = 0;
    for (std::uint32_t i = 0; i < triangle_count(field); ++i) {
        if (field.height_field->is_hole(i)) continue;
        const Triangle t = triangle_at(field, i);
        const auto other = of_mesh.find(key_of(t));
        if (other == of_mesh.end()) return "a triangle is missing";
        const Triangle& m = other->second;
        if (!same(t.normal, m.normal) || t.material != m.material) return "normal or material";
        if (t.sharp != m.sharp) return "sharp edges";
        for (int k = 0; k < 3; ++k)
            if (!same(t.beyond[k], m.beyond[k])) return "beyond";
        ++seen;
    }
    return seen == of_mesh.size() ? "" : "count";
}

} // namespace

TEST_CASE("a mesh answers box queries exactly as brute force at any scale and size") {
    oracle::RandomReal random(3);
    for (const auto& [count, size] :
         {std::pair(1u, 1.0), std::pair(9u, 1.0), std::pair(65u, 3.0), std::pair(700u, 10.0),
          std::pair(700u, 60.0), std::pair(700u, 1500.0), std::pair(600u, 7900.0)}) {
        const Soup soup = strewn(random, count, size);
        for (const LengthVec3& scale : {scale_one, factors(0.5, 2, 1.37), factors(1 / 128.0, 1, 0.01)}) {
            const Holder holder(bake_mesh(soup.def()), scale);
            CHECK(triangle_count(holder.solid) == count);
            CHECK(agreements(holder.solid, 60) == 60);
            CHECK(agreements(holder.solid, 60,
                             (extent_of(holder.solid).upper.x - extent_of(holder.solid).lower.x)) < 60);
        }
    }
}

TEST_CASE("a height field answers box queries exactly as brute force at any scale and with holes") {
    oracle::RandomReal random(5);
    for (const auto& [columns, rows] :
         {std::pair(2u, 2u), std::pair(2u, 30u), std::pair(40u, 25u), std::pair(17u, 18u)})
        for (const LengthVec3& scale : {scale_one, factors(0.5, 2, 1.37), factors(1 / 128.0, 100, 3)}) {
            const Terrain terrain = random_terrain(random, columns, rows, columns > 20);
            const Holder holder(bake_height_field(terrain.def()), scale);
            CHECK(agreements(holder.solid, 100) == 100);
            CHECK(agreements(holder.solid, 100,
                             (extent_of(holder.solid).upper.x - extent_of(holder.solid).lower.x)) < 100);
        }
}

TEST_CASE("a height field equals a mesh of the same triangles") {
    oracle::RandomReal random(7);
    for (int i = 0; i < 20; ++i) {
        const Terrain terrain =
            random_terrain(random, 2 + random.below(12), 2 + random.below(12), i % 2 == 1);
        const Soup soup = soup_of(terrain);
        if (soup.triangles.empty()) continue;
        for (const LengthVec3& scale : {scale_one, factors(3, 0.2, 1)}) {
            const Holder field(bake_height_field(terrain.def()), scale), mesh(bake_mesh(soup.def()), scale);
            REQUIRE(difference(field.solid, mesh.solid) == "");
        }
        Terrain other = terrain; // planted
        other.heights[0] = half(other.heights[0]) + decimal<Length>("0.37");
        const Holder field(bake_height_field(other.def())), mesh(bake_mesh(soup.def()));
        if (terrain.cells.empty() || terrain.cells[0] != HeightField::hole)
            CHECK(difference(field.solid, mesh.solid) != "");
    }
}

TEST_CASE("ridges and borders are sharp edges but flat edges are not and valleys only in a two-sided mesh") {
    // Four quads along x with z from 0 to 1: flat, ridge, valley between them.
    const double profile[] = {0, 0, 1, 0, 1};
    Soup soup;
    for (int i = 0; i < 5; ++i)
        for (int z = 0; z < 2; ++z) soup.vertices.push_back({Real(i), real(profile[i]), Real(z)});
    for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t a = 2 * i;
        soup.triangles.push_back({a, a + 1, a + 3});
        soup.triangles.push_back({a, a + 3, a + 2});
    }
    for (bool two_sided : {false, true}) {
        MeshDef def = soup.def();
        def.two_sided = two_sided;
        const Holder holder(bake_mesh(def));
        CHECK(is_two_sided(holder.solid) == two_sided);
        for (std::uint32_t i = 0; i < triangle_count(holder.solid); ++i) {
            const Triangle t = triangle_at(holder.solid, i);
            for (int k = 0; k < 3; ++k) {
                const CoordinateVec3 a = t.corner[k], b = t.corner[(k + 1) % 3];
                const bool border =
                    a.z == b.z || (a.x == b.x && (a.x == Coordinate(0) || a.x == Coordinate(4)));
                const bool ridge = a.x == b.x && a.x == Coordinate(2);
                const bool valley = a.x == b.x && (a.x == Coordinate(1) || a.x == Coordinate(3));
                CHECK(((t.sharp >> k) & 1u) == (border || ridge || (valley && two_sided) ? 1u : 0u));
                if (border) CHECK(t.beyond[k] == -t.normal);
                if (!border && !ridge && !valley) CHECK(t.beyond[k] == t.normal);
            }
        }
    }
}

TEST_CASE("an edge with three triangles or with two that run in the same direction is a border") {
    Soup soup;
    soup.vertices = {{0_r, 0_r, 0_r}, {1_r, 0_r, 0_r}, {0_r, 1_r, 0_r}, {0_r, 0_r, 1_r}, {0_r, -1_r, 0.5_r}};
    soup.triangles = {{0, 1, 2}, {1, 0, 3}, {1, 0, 4}};
    for (int drop = 0; drop < 2; ++drop) {
        const Holder holder(bake_mesh(soup.def()));
        for (std::uint32_t i = 0; i < triangle_count(holder.solid); ++i)
            CHECK(triangle_at(holder.solid, i).sharp == 7u);
        soup.triangles = {{1, 0, 3}, {1, 0, 4}};
    }
    soup.triangles = {{0, 1, 2}, {1, 0, 3}};
    const Holder joined(bake_mesh(soup.def()));
    CHECK(triangle_at(joined.solid, 0).beyond[0] == triangle_at(joined.solid, 1).normal);
}

TEST_CASE("bake_mesh() welds vertices and drops degenerate triangles and keeps materials") {
    Soup soup;
    const Real tiny = Real::from_raw(3); // less than a step of 24 fraction bits
    soup.vertices = {{0_r, 0_r, 0_r},  {1_r, 0_r, 0_r}, {0_r, 1_r, 0_r}, {tiny, 0_r, 0_r},
                     {1_r, tiny, 0_r}, {1_r, 1_r, 0_r}, {2_r, 0_r, 0_r}};
    soup.triangles = {{0, 1, 2}, {0, 3, 1}, {2, 4, 5}, {0, 1, 6}};
    soup.materials = {7, 8, 9, 10};
    const Holder holder(bake_mesh(soup.def()));
    REQUIRE(triangle_count(holder.solid) == 2);
    CHECK(holder.solid.mesh->raw().vertices.size() == 4);
    CHECK(triangle_at(holder.solid, 0).material == 7);
    CHECK(triangle_at(holder.solid, 1).material == 9);
    CHECK(triangle_at(holder.solid, 0).sharp == 5u); // the diagonal, edge 1, is inside and flat
}

TEST_CASE(
    "at_scale_one() returns the box of exactly the points whose scaled positions are in the given box") {
    oracle::RandomReal random(17);
    for (int i = 0; i < 20000; ++i) {
        const LengthVec3 scale = factors(random.log_uniform(0.0079, 100), random.log_uniform(0.0079, 100), 1);
        const auto near = [&] {
            return Coordinate::from_raw(static_cast<std::int64_t>(random.below(4000)) - 2000);
        };
        const CoordinateVec3 p{near(), near(), near()}, q{near(), near(), near()};
        const Extent box{min(p, q), max(p, q)};
        const Extent back = at_scale_one(box, scale);
        const CoordinateVec3 point{near(), near(), near()};
        const CoordinateVec3 placed = scaled_by(point, scale);
        REQUIRE(overlap(back, {point, point}) == overlap(box, {placed, placed}));
    }
    const CoordinateVec3 far{Coordinate::max(), Coordinate::max(), Coordinate::max()};
    const Extent all = at_scale_one({-far, far}, factors(0.01, 1, 100));
    CHECK(all.lower.x < Coordinate(-8000));
    CHECK(all.upper.z > Coordinate(8000));
}
