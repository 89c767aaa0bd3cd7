// The assets of stories: hulls with few and many corners, ground of triangles, compounds, and assets at the limits of
// every kind.
#include "attack/worlds/values.h"
#include "story.h"

namespace worlds {

namespace {

/// Corners near a sphere of `radius`, at different distances.
AssetBytes rock(std::uint32_t corners, Real radius, std::uint64_t seed) {
    Random random = Random::seeded(seed);
    std::vector<LengthVec3> points;
    for (std::uint32_t i = 0; i < corners; ++i) {
        const UnitVec3 along = random.unit_vector();
        points.push_back(to<Length>(scale<Real>(along, radius)));
    }
    return bake_hull(points).value();
}

/// A wedge: a slope of flat faces.
AssetBytes wedge() {
    const Real x = 0.5_r, y = 0.25_r, z = 0.4_r;
    const Vec3 corners[] = {{-x, -y, -z}, {x, -y, -z}, {-x, -y, z}, {x, -y, z}, {x, y, -z}, {x, y, z}};
    std::vector<LengthVec3> points;
    for (const Vec3& corner : corners) points.push_back(to<Length>(corner));
    return bake_hull(points).value();
}

const MaterialSurface surfaces[] = {{1, 0.2_r, 0.5_r, 0.1_r, {Real(1), Real{}, Real{}}}, {2, Real(1)}};

/// Hills: `side` cells of a metre in each direction around the origin.
AssetBytes hills(std::int32_t side, bool two_sided, std::uint64_t seed) {
    Random random = Random::seeded(seed);
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint16_t> materials;
    for (std::int32_t z = 0; z <= side; ++z)
        for (std::int32_t x = 0; x <= side; ++x) {
            const Real y = random.range(-0.15_r, 0.15_r);
            vertices.push_back({Real(x) - half(Real(side)), y, Real(z) - half(Real(side))});
        }
    const auto at = [&](std::int32_t x, std::int32_t z) {
        return static_cast<std::uint32_t>(z * (side + 1) + x);
    };
    for (std::int32_t z = 0; z < side; ++z)
        for (std::int32_t x = 0; x < side; ++x) {
            triangles.push_back({at(x, z), at(x, z + 1), at(x + 1, z)});
            triangles.push_back({at(x + 1, z), at(x, z + 1), at(x + 1, z + 1)});
            for (int i = 0; i < 2; ++i)
                materials.push_back(
                    static_cast<std::uint16_t>(random.below(8) == 0 ? 1 + random.below(2) : 0));
        }
    return bake_mesh({.vertices = vertices,
                      .triangles = triangles,
                      .materials = materials,
                      .surfaces = surfaces,
                      .two_sided = two_sided})
        .value();
}

AssetBytes terrain(std::uint32_t samples, Length spacing) {
    Random random = Random::seeded(samples);
    std::vector<Length> heights;
    std::vector<std::uint8_t> cells;
    for (std::uint32_t i = 0; i < samples * samples; ++i)
        heights.push_back(to<Length>(random.range(-0.2_r, 0.2_r)));
    for (std::uint32_t i = 0; i < (samples - 1) * (samples - 1); ++i) {
        const std::uint32_t of_32 = random.below(32);
        cells.push_back(static_cast<std::uint8_t>(of_32 == 0 ? 255 : of_32 < 4 ? 1 : 0));
    }
    return bake_height_field({.columns = samples,
                              .rows = samples,
                              .spacing = spacing,
                              .heights = heights,
                              .cells = cells,
                              .surfaces = surfaces})
        .value();
}

CompoundPart part(const Geometry& geometry, Real x, Real y, Real z) {
    return {geometry, {{x, y, z}, Quat::identity()}};
}

} // namespace

namespace {

struct Assets {
    std::shared_ptr<const AssetLibrary> library;
    std::vector<Geometry> ordinary;
};

const Assets& assets() {
    static const Assets made = [] {
        AssetLibrary library = attack::assets_at_limits();
        std::vector<AssetId> ordinary;
        const auto add = [&](const AssetBytes& bytes) {
            ordinary.push_back(library.add(bytes).value());
            return ordinary.back();
        };
        add(wedge());
        const AssetId stone = add(rock(4, 0.5_r, 1));
        for (const std::uint32_t corners : {8u, 12u, 24u, 25u, 60u, 200u}) add(rock(corners, 0.4_r, corners));
        add(hills(24, false, 1)), add(hills(24, true, 2));
        add(terrain(33, Length(1))), add(terrain(20, Length(1)));
        const Real leg = 0.35_r, thin = 0.05_r, tall = 0.2_r;
        const CompoundPart table[] = {part(box(0.45_r, thin, 0.45_r), Real{}, tall + thin, Real{}),
                                      part(box(thin, tall, thin), leg, Real{}, leg),
                                      part(box(thin, tall, thin), -leg, Real{}, leg),
                                      part(cylinder(thin, tall), leg, Real{}, -leg),
                                      part(capsule(thin, tall - thin), -leg, Real{}, -leg)};
        const CompoundPart weight[] = {part(sphere(0.2_r), 0.3_r, Real{}, Real{}),
                                       part(sphere(0.25_r), -0.3_r, Real{}, Real{}),
                                       part(instance(ShapeKind::hull, stone), Real{}, 0.1_r, Real{})};
        add(bake_compound(table).value()), add(bake_compound(weight).value());
        std::vector<CompoundPart> floor;
        for (std::int32_t i = 0; i < 400; ++i) {
            const Real x = Real(i % 20) - 9.5_r, z = Real(i / 20) - 9.5_r;
            const Real low = i % 3 == 0 ? 0.3_r : 0.25_r;
            floor.push_back(part(box(0.5_r, low, 0.5_r), x, Real{}, z));
        }
        add(bake_compound(floor).value());
        Assets out;
        for (const AssetId id : ordinary) out.ordinary.push_back(library.geometry(id).value());
        out.library = std::make_shared<const AssetLibrary>(std::move(library));
        return out;
    }();
    return made;
}

} // namespace

std::shared_ptr<const AssetLibrary> story_assets() { return assets().library; }

std::vector<Geometry> ordinary_assets(ShapeKind kind) {
    std::vector<Geometry> found;
    for (const Geometry& g : assets().ordinary)
        if (g.kind == kind) found.push_back(g);
    return found;
}

} // namespace worlds
