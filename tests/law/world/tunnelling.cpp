// Fast bodies against thin walls: none passes through.
#include "support/random.h"

#include <doctest/doctest.h>

#include <memory>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// The projectiles.
enum class Shot { ball, capsule, cylinder, cone, cube, plate, needle, rounded, group, count };
constexpr const char* shot_names[] = {"ball",  "capsule", "cylinder", "cone", "cube",
                                      "plate", "needle",  "rounded",  "group"};
/// The targets. Each separates the world near y = 0, over many metres.
enum class Wall { slab, tiles, plane, mesh, two_sided, height_field, compound, count };
constexpr const char* wall_names[] = {"slab",           "tiles",        "plane",   "mesh",
                                      "two-sided mesh", "height field", "compound"};

AssetId needle(AssetLibrary& library) {
    std::vector<LengthVec3> points;
    const auto length_of = [](double x) { return quantize<Length>(x); };
    for (double side : {-1.0, 1.0})
        for (double up : {-1.0, 1.0})
            points.push_back({length_of(0.01 * side), length_of(0.01 * up), Length{}});
    points.push_back({Length{}, Length{}, length_of(0.5)});
    points.push_back({Length{}, Length{}, length_of(-0.5)});
    return library.add(bake_hull(points)).value();
}

/// A flat grid of triangles about the origin, in the plane y = 0, with its front upwards.
AssetId grid(AssetLibrary& library, bool two_sided) {
    constexpr int side = 24;
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (int z = 0; z <= side; ++z)
        for (int x = 0; x <= side; ++x)
            vertices.push_back(vec(x - side / 2, 0.02 * ((x * 7 + z * 3) % 5 - 2), z - side / 2));
    for (int z = 0; z < side; ++z)
        for (int x = 0; x < side; ++x) {
            const auto at = [&](int dx, int dz) {
                return static_cast<std::uint32_t>((z + dz) * (side + 1) + x + dx);
            };
            triangles.push_back({at(0, 0), at(0, 1), at(1, 1)});
            triangles.push_back({at(0, 0), at(1, 1), at(1, 0)});
        }
    return library.add(bake_mesh({.vertices = vertices, .triangles = triangles, .two_sided = two_sided}))
        .value();
}

AssetId field(AssetLibrary& library) {
    constexpr std::uint32_t side = 25;
    std::vector<Length> heights;
    for (std::uint32_t i = 0; i < side * side; ++i)
        heights.push_back(quantize<Length>(0.03 * (static_cast<int>(i * 5 % 7) - 3)));
    return library
        .add(bake_height_field({.columns = side, .rows = side, .spacing = Length(1), .heights = heights}))
        .value();
}

AssetId planks(AssetLibrary& library) {
    std::vector<CompoundPart> parts;
    for (int i = -12; i < 12; ++i) parts.push_back({box(0.5_r, 0.005_r, 12_r), at(i + 0.5, 0, 0)});
    return library.add(bake_compound(parts)).value();
}

AssetId club(AssetLibrary& library) {
    const CompoundPart parts[] = {{box(0.02_r, 0.02_r, 0.4_r), Transform::identity()},
                                  {sphere(0.1_r), at(0, 0, 0.4)},
                                  {capsule(0.03_r, 0.1_r), at(0, 0, -0.4)}};
    return library.add(bake_compound(parts)).value();
}

struct Assets {
    std::shared_ptr<AssetLibrary> library = std::make_shared<AssetLibrary>();
    AssetId needle_id = needle(*library), mesh = grid(*library, false), two_sided = grid(*library, true),
            terrain = field(*library), plank = planks(*library), club_id = club(*library);
};

Geometry shot_geometry(const Assets& assets, Shot kind, double size) {
    const Real s = real(size);
    switch (kind) {
    case Shot::ball:
        return sphere(s);
    case Shot::capsule:
        return capsule(s / Real(2), s * 2);
    case Shot::cylinder:
        return cylinder(s, s / Real(2));
    case Shot::cone:
        return cone(s, s);
    case Shot::cube:
        return box(s, s, s);
    case Shot::plate:
        return box(s * 2, 0.005_r, s);
    case Shot::needle:
        return assets.library->geometry(assets.needle_id).value();
    case Shot::rounded:
        return rounded(box(s, s / Real(2), s), s / Real(4));
    default:
        return assets.library->geometry(assets.club_id).value();
    }
}

void add_wall_of(World& w, const Assets& assets, Wall kind) {
    const auto fixed = [&](const Geometry& g, const Transform& pose = Transform::identity()) {
        add(w, {.kind = BodyKind::static_, .pose = pose}, {.geometry = g});
    };
    switch (kind) {
    case Wall::slab:
        return fixed(box(12_r, 0.005_r, 12_r));
    case Wall::tiles:
        for (int x = -6; x < 6; ++x)
            for (int z = -2; z < 2; ++z) fixed(box(1_r, 0.005_r, 3_r), at(2 * x + 1, 0, 6 * z + 3));
        return;
    case Wall::plane:
        return fixed(plane());
    case Wall::mesh:
        return fixed(assets.library->geometry(assets.mesh).value());
    case Wall::two_sided:
        return fixed(assets.library->geometry(assets.two_sided).value());
    case Wall::height_field:
        return fixed(assets.library->geometry(assets.terrain).value(), at(-12, 0, -12));
    default:
        return fixed(assets.library->geometry(assets.plank).value());
    }
}

struct Tally {
    int shots = 0, through = 0;
    std::string first;
};

/// Shots from above, mostly downwards, at all speeds. Some aim at seams and corners, which lie at whole metres.
Tally shoot(Wall wall, Shot shot, int count, bool continuous) {
    static const Assets assets;
    RandomPoint random(static_cast<std::uint64_t>(wall) * 100 + static_cast<std::uint64_t>(shot));
    Tally tally;
    for (int i = 0; i < count; ++i) {
        WorldDef def = small_def();
        def.continuous = continuous ? 1 : 0;
        World w = made(World::create(def, {}, assets.library));
        add_wall_of(w, assets, wall);
        const double speed = random(50, 500), size = random(0.02, 0.3);
        const D3 aim{std::round(random(-4, 4)) * (i % 2) + random(-0.3, 0.3) * (i % 3), 0,
                     std::round(random(-4, 4)) * (i % 2) + random(-0.3, 0.3) * (i % 3)};
        D3 way = random.direction();
        way[1] = -std::abs(way[1]) - 0.5;
        way = (1 / length(way)) * way;
        const D3 start = aim - random(1.0, 4.0) * way;
        const D3 from{start[0], std::max(start[1], 0.9), start[2]};
        const D3 spin = random(0, 50) * random.direction();
        const BodyId body = add(w,
                                {.pose = {vec3(from), random.rotation()},
                                 .linear_velocity = vec3(speed * way),
                                 .angular_velocity = vec3(spin)},
                                {.geometry = shot_geometry(assets, shot, size)});
        double lowest = 1;
        for (int t = 0; t < 30; ++t) {
            w.tick();
            const D3 p = position(w, body);
            if (std::abs(p[0]) < 11.5 && std::abs(p[2]) < 11.5) lowest = std::min(lowest, p[1]);
        }
        ++tally.shots;
        if (lowest > -0.15) continue;
        if (tally.through++ == 0)
            tally.first = std::string(shot_names[static_cast<int>(shot)]) + " at " +
                          wall_names[static_cast<int>(wall)] + ", shot " + std::to_string(i) + ", " +
                          std::to_string(speed) + " m/s: down to " + std::to_string(lowest);
    }
    return tally;
}

} // namespace

TEST_CASE("thin walls of every shape stop shots of every shape") {
    for (int wall = 0; wall < static_cast<int>(Wall::count); ++wall)
        for (int shot = 0; shot < static_cast<int>(Shot::count); ++shot) {
            const Tally t = shoot(static_cast<Wall>(wall), static_cast<Shot>(shot), samples(6, 160), true);
            INFO(t.first);
            CHECK(t.through == 0);
        }
}

TEST_CASE("planted: shots pass through walls without continuous collision") {
    int through = 0;
    for (const Wall wall : {Wall::slab, Wall::two_sided, Wall::compound})
        for (const Shot shot : {Shot::ball, Shot::cube, Shot::needle})
            through += shoot(wall, shot, 6, false).through;
    CHECK(through > 20);
}
