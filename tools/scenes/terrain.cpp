// Hills of 320 x 320 cells, 204,800 triangles: a height field of 160 x 160 m with a bowl in the middle. Bodies of every
// kind roll and slide into the bowl. An arch, which is a mesh, is at its bottom.
#include "lockstone/math/math.h"
#include "scenes/props.h"

#include <array>

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t samples = 321; ///< along each side
constexpr Real spacing = 0.5_r;        ///< [m] between samples
constexpr Real half_side = 80_r;       ///< [m]

/// The height at a place [m]; the origin is the middle of the field.
Real height_at(Real x, Real z) {
    const Real bowl =
        9_r * (1_r - cos(min(sqrt(x * x + z * z) / 24_r, pi))); // 0 in the middle, 18 m at 75 m and beyond
    const Real hills = 2.2_r * sin(x * 0.11_r) * cos(z * 0.13_r) + 0.8_r * sin(x * 0.31_r + z * 0.23_r);
    const Real bumps = 0.12_r * sin(x * 1.3_r) * sin(z * 1.1_r);
    return bowl + hills + bumps;
}

Result<AssetBytes> bake_hills() {
    std::vector<Length> heights;
    for (std::uint32_t row = 0; row < samples; ++row)
        for (std::uint32_t column = 0; column < samples; ++column)
            heights.push_back(
                to<Length>(height_at(spacing * Real(column) - half_side, spacing * Real(row) - half_side)));
    return bake_height_field(
        {.columns = samples, .rows = samples, .spacing = to<Length>(spacing), .heights = heights});
}

/// Half a ring with a square cross-section, upright along x: steps + 1 sections of four corners, and two ends.
Result<AssetBytes> bake_arch() {
    constexpr std::uint32_t steps = 24;
    constexpr Real inner = 4_r, outer = 5.5_r, half_width = 1.5_r;
    std::vector<Vec3> vertices;
    for (std::uint32_t i = 0; i <= steps; ++i) {
        const Real angle = pi * Real(i) / Real(steps);
        const Real x = cos(angle), y = sin(angle);
        for (const Real z : {half_width, -half_width}) vertices.push_back({outer * x, outer * y, z});
        for (const Real z : {-half_width, half_width}) vertices.push_back({inner * x, inner * y, z});
    }
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const auto add_face = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
    };
    // Seen from the end at angle 0, the corners of a section run counter-clockwise.
    for (std::uint32_t i = 0; i < steps; ++i)
        for (std::uint32_t k = 0; k < 4; ++k) {
            const std::uint32_t here = 4 * i + k, next = 4 * i + (k + 1) % 4;
            add_face(here, next, next + 4, here + 4);
        }
    add_face(3, 2, 1, 0);
    add_face(4 * steps, 4 * steps + 1, 4 * steps + 2, 4 * steps + 3);
    return bake_mesh({.vertices = vertices, .triangles = triangles});
}

class Terrain final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        Shelf shelf;
        const Geometry hills = shelf.add(bake_hills()), arch = shelf.add(bake_arch());
        std::vector<Geometry> shapes = bake_props(shelf, 0.6_r);
        shapes.push_back(sphere(0.45_r));
        shapes.push_back(box(0.4_r, 0.4_r, 0.4_r));
        const auto assets = std::move(shelf).finish();
        if (!assets) return assets.error();
        WorldDef def = world_for(options.size, options.seed);
        def.substeps = 4;
        Builder build(def, {}, *assets);
        build.body({.kind = BodyKind::static_,
                    .pose = at({-half_side, 0_r, -half_side}),
                    .user_key = user_key_of(Role::terrain, 0)},
                   {.geometry = hills});
        build.body({.kind = BodyKind::static_,
                    .pose = at({0_r, height_at(0_r, 0_r) - 1_r, 0_r}),
                    .user_key = user_key_of(Role::wall, 0)},
                   {.geometry = arch});
        add_props(build, options, shapes, place);
        return std::move(build).finish();
    }

  private:
    /// On rings around the bowl, apart from each other: 36 bodies on each ring.
    static Transform place(std::uint32_t i, Random& random) {
        constexpr std::uint32_t per_ring = 36;
        const std::uint32_t ring = i / per_ring;
        const Real radius = 12_r + 1.5_r * Real(ring % 30), lift = 2_r + 1.5_r * Real(ring / 30);
        const Real angle = two_pi * (Real(i % per_ring) + half(Real(ring % 2))) / Real(per_ring);
        const Real x = radius * cos(angle), z = radius * sin(angle);
        return at({x, height_at(x, z) + lift, z}, random_turn(random));
    }
};

} // namespace

std::unique_ptr<Scene> make_terrain(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Terrain>(info, options, 1);
}

} // namespace lockstone::scenes_detail
