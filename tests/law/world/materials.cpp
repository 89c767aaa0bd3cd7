// The triangle, cell or part that a hit reports, and the effect of their materials in contacts.
#include "shapes/asset/asset.h"
#include "shapes/asset/asset_file.h"
#include "support/about.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <memory>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr std::uint16_t rubber = 1, ice = 2, belt = 3, trampoline = 700;
const std::vector<MaterialSurface> surfaces = {
    {ice, Real{}}, {belt, Real(2), Real{}, Real{}, {Real(3), Real{}, Real{}}}, {trampoline, Real{}, Real(1)}};

/// A floor of n x n squares of 2 m about the origin, each of two triangles, listed in an odd order and mixed with
/// triangles of zero area, so that baking moves most of them.
struct Floor {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint16_t> materials;
    int side;

    template <class MaterialOf> Floor(int n, MaterialOf&& material_of) : side(n) {
        for (int z = 0; z <= n; ++z)
            for (int x = 0; x <= n; ++x) vertices.push_back(vec(2 * x - n, 0, 2 * z - n));
        const int squares = n * n;
        for (int i = 0; i < squares; ++i) {
            const int k = i * 7 % squares, x = k % n, z = k / n; // 7 and n^2 have no common factor
            const auto at = [&](int dx, int dz) {
                return static_cast<std::uint32_t>((z + dz) * (n + 1) + x + dx);
            };
            if (i % 5 == 0) triangles.push_back({at(0, 0), at(0, 0), at(1, 1)}), materials.push_back(9);
            triangles.push_back({at(0, 0), at(0, 1), at(1, 1)});
            triangles.push_back({at(0, 0), at(1, 1), at(1, 0)});
            for (int t = 0; t < 2; ++t) materials.push_back(material_of(2 * x + 1 - n, 2 * z + 1 - n));
        }
    }
    AssetBytes baked(std::span<const MaterialSurface> list = surfaces) const {
        return bake_mesh(
                   {.vertices = vertices, .triangles = triangles, .materials = materials, .surfaces = list})
            .value();
    }
    Vec3 middle(std::size_t t) const {
        const Vec3 sum = vertices[triangles[t][0]] + vertices[triangles[t][1]] + vertices[triangles[t][2]];
        return sum / Real(3);
    }
};

World world_on(const AssetBytes& bytes, WorldDef def = small_def(), ShapeDef shape = {}) {
    AssetLibrary library;
    const AssetId id = made(library.add(bytes));
    shape.geometry = made(library.geometry(id));
    World w = made(World::create(def, {}, std::make_shared<const AssetLibrary>(std::move(library))));
    add(w, {.kind = BodyKind::static_}, shape);
    return w;
}

std::uint16_t by_quarter(int x, int z) {
    return x < 0 ? (z < 0 ? rubber : ice) : (z < 0 ? belt : trampoline);
}

/// Returns how far a crate with this speed along z slides there.
double slide(World& w, double x, double z, double speed) {
    const BodyId b = add(w, {.pose = at(x, 0.25, z), .linear_velocity = vec(0, 0, speed)},
                         {.geometry = box(real(0.25), real(0.25), real(0.25)),
                          .friction = real(0.6),
                          .friction_mix = Mix::multiply});
    for (int t = 0; t < 60; ++t) w.tick();
    return std::abs(position(w, b)[2] - z);
}

} // namespace

TEST_CASE("a ray hit reports the source triangle and its material although baking moves triangles") {
    const Floor floor(9, [](int x, int z) { return static_cast<std::uint16_t>(1000 + 10 * x + z); });
    const World w = world_on(floor.baked());
    int moved = 0;
    for (std::uint32_t t = 0; t < floor.triangles.size(); ++t) {
        if (floor.materials[t] == 9) continue; // zero area
        const auto hit = w.cast_ray({floor.middle(t) + vec(0, 1, 0), vec(0, -2, 0)});
        REQUIRE(hit);
        CHECK(hit->part.source == t);
        CHECK(hit->part.material == floor.materials[t]);
        if (hit->feature != t) ++moved;
    }
    CHECK(moved > 100); // planted: the index in the baked mesh is that of another triangle
}

TEST_CASE("contacts and events report the triangle or cell or part and its material of both sides") {
    const Floor floor(9, by_quarter);
    World w = world_on(floor.baked(), weightless());
    for (std::uint32_t t = 1; t < floor.triangles.size(); t += 3) {
        if (floor.materials[t] == 9) continue;
        World one = w.clone();
        const Vec3 m = floor.middle(t);
        ShapeDef ball{.geometry = sphere(real(0.1)), .material = 77};
        add(one, {.pose = {m + vec(0, 0.099, 0), Quat::identity()}}, ball);
        one.tick();
        REQUIRE(one.contacts().size() == 1);
        const SurfacePart ground{t, floor.materials[t]}, body{0, 77};
        CHECK(one.contacts()[0].part_a == ground);
        CHECK(one.contacts()[0].part_b == body);
        REQUIRE(one.events().size() == 1);
        CHECK(one.events()[0].part_a == ground);
        CHECK(one.events()[0].part_b == body);
        one.tick(); // the manifold is recycled
        CHECK(one.contacts()[0].part_a == ground);
    }
}

TEST_CASE(
    "a triangle sets friction and bounce and conveyor speed and the shape sets them for unlisted materials") {
    const Floor floor(17, by_quarter);
    World w = world_on(floor.baked(), small_def(), {.friction = real(0.5), .friction_mix = Mix::multiply});
    // On rubber v^2 / (2 mu g) with 0.6 * 0.5; on ice the whole way.
    CHECK(slide(w, -6, -8, 2) == test::about(4 / (2 * 0.3 * 9.81), 0.03));
    CHECK(slide(w, -6, 4, 2) == test::about(2, 0.01));
    const BodyId carried =
        add(w, {.pose = at(3, 0.25, -6)}, {.geometry = box(real(0.25), real(0.25), real(0.25))});
    const BodyId bouncing = add(w, {.pose = at(6, 2.3, 6)}, {.geometry = sphere(real(0.3))});
    double highest = 0;
    for (int t = 0; t < 75; ++t) {
        w.tick();
        if (t > 45) highest = std::max(highest, position(w, bouncing)[1]);
    }
    CHECK(velocity(w, carried)[0] == test::about(3, 0.02));
    CHECK(highest == test::about(2.3, 0.03));
}

TEST_CASE("planted fault: a floor without surfaces lets boxes slide less far and carries no crate") {
    const Floor floor(17, by_quarter);
    World w = world_on(floor.baked({}), small_def(), {.friction = real(0.5), .friction_mix = Mix::multiply});
    CHECK(slide(w, -6, 4, 2) < 1);
    const BodyId carried =
        add(w, {.pose = at(3, 0.25, -6)}, {.geometry = box(real(0.25), real(0.25), real(0.25))});
    for (int t = 0; t < 60; ++t) w.tick();
    CHECK(std::abs(velocity(w, carried)[0]) < 0.001);
}

TEST_CASE(
    "a crate half on ice and half on rubber has a manifold with each and only one where surfaces are equal") {
    const Floor floor(17, [](int x, int) { return x < 0 ? rubber : ice; });
    const auto materials_under = [&](std::span<const MaterialSurface> list) {
        World w = world_on(floor.baked(list));
        add(w, {.pose = at(-1, 0.25, -8)},
            {.geometry = box(real(0.25), real(0.25), real(0.25))}); // on the border
        w.tick();
        std::vector<std::uint32_t> found;
        for (const World::ContactPoint& p : w.contacts()) found.push_back(p.part_a.material);
        std::ranges::sort(found);
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    };
    CHECK(materials_under(surfaces) == std::vector<std::uint32_t>{rubber, ice});
    // planted: one manifold across both would report one material only
    CHECK(materials_under({}).size() == 1);
}

TEST_CASE("rays and contacts and surfaces and wheels use the material of their height field cell") {
    constexpr std::uint32_t samples = 9;
    const std::vector<Length> heights(samples * samples, Length{});
    std::vector<std::uint8_t> cells;
    for (std::uint32_t i = 0; i < (samples - 1) * (samples - 1); ++i)
        cells.push_back(static_cast<std::uint8_t>(i % (samples - 1) < 4 ? rubber : ice));
    const AssetBytes bytes = bake_height_field({.columns = samples,
                                                .rows = samples,
                                                .spacing = Length(2),
                                                .heights = heights,
                                                .cells = cells,
                                                .surfaces = std::span(surfaces).first(1)})
                                 .value();
    World w =
        world_on(bytes, small_def(), {.friction = real(0.5), .friction_mix = Mix::multiply, .material = 5});
    for (std::uint32_t row = 0; row < 8; ++row)
        for (std::uint32_t column = 0; column < 8; ++column) {
            const auto hit = w.cast_ray({vec(2 * column + 0.5, 1, 2 * row + 1.2), vec(0, -2, 0)});
            REQUIRE(hit);
            CHECK(hit->part.source == row * 8 + column);
            CHECK(hit->part.material == cells[row * 8 + column]);
        }
    CHECK(slide(w, 3, 2, 2) == test::about(4 / (2 * 0.3 * 9.81), 0.03));
    CHECK(slide(w, 13, 2, 2) == test::about(2, 0.01));
}

TEST_CASE("a hit and a contact with a compound report the part and the shape's own material") {
    AssetLibrary library;
    std::vector<CompoundPart> parts;
    for (int i = 0; i < 12; ++i)
        parts.push_back({box(real(0.5), real(0.5), real(0.5)), at(3.0 * (i * 5 % 12), 0, 0)});
    const AssetId id = made(library.add(bake_compound(parts)));
    const Geometry row = made(library.geometry(id));
    World w = made(World::create(weightless(), {}, std::make_shared<const AssetLibrary>(std::move(library))));
    add(w, {.kind = BodyKind::static_}, {.geometry = row, .material = 31});
    for (std::uint32_t i = 0; i < 12; ++i) {
        const Vec3 above = parts[i].local.position + vec(0, 0.59, 0);
        const auto hit = w.cast_ray({above, vec(0, -2, 0)});
        REQUIRE(hit);
        CHECK(hit->part == SurfacePart{i, 31});
        World one = w.clone();
        add(one, {.pose = {above, Quat::identity()}}, {.geometry = sphere(real(0.1))});
        one.tick();
        REQUIRE(one.contacts().size() == 1);
        CHECK(one.contacts()[0].part_a == SurfacePart{i, 31});
    }
}

TEST_CASE("a mesh stores no empty sections and the old version is read and written unchanged") {
    const auto version_of = [](const AssetBytes& bytes) { return static_cast<int>(bytes[10]); };
    const Floor small(1, by_quarter); // a degenerate triangle comes first, so baking moves the others
    CHECK(version_of(small.baked({})) == 1);
    Floor plain = small;
    plain.triangles.erase(plain.triangles.begin()), plain.materials.erase(plain.materials.begin());
    const AssetBytes old = plain.baked({});
    CHECK(version_of(old) == 0);
    for (const AssetBytes& bytes : {old, small.baked({}), small.baked()}) {
        AssetLibrary library;
        const AssetId id = made(library.add(bytes));
        CHECK(shapes::rebuilt(*library.find(id)) == bytes);
    }
    // Planted: a version that the content does not need, or one that lacks a part of it.
    AssetBytes bad = old;
    bad[10] = std::byte{1};
    AssetLibrary library;
    CHECK(library.add(bad).error().message.find("checksum") != std::string::npos);
}

TEST_CASE("bake_mesh() rejects surface lists that are out of order or too long or out of range and names the "
          "fault") {
    Floor floor(1, by_quarter);
    const auto why = [&](std::vector<MaterialSurface> list) {
        const auto baked =
            bake_mesh({.vertices = floor.vertices, .triangles = floor.triangles, .surfaces = list});
        return baked ? std::string() : baked.error().message;
    };
    CHECK(why({{1, Real(1)}, {2, Real(1)}}) == "");
    CHECK(why({{2, Real(1)}, {2, Real(1)}}).find("surface 1 is of material 2") != std::string::npos);
    CHECK(why({{65536, Real(1)}}).find("surface 0") != std::string::npos);
    CHECK(why({{1, Real(5)}}).find("friction") != std::string::npos);
    CHECK(why({{1, Real(1), Real(2)}}).find("restitution") != std::string::npos);
    CHECK(why({{1, Real(1), Real{}, Real{}, {Real(101), Real{}, Real{}}}}).find("surface_velocity") !=
          std::string::npos);
    CHECK(why(std::vector<MaterialSurface>(257)).find("257 surfaces") != std::string::npos);
}
