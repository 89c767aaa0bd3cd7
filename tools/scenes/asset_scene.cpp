// A scene that shows one asset: it falls onto a plane, or is the ground onto which bodies fall.
#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "scenes/props.h"

#include <algorithm>

namespace lockstone {
namespace {

using namespace scenes_detail;

constexpr SceneInfo about{
    "asset", "falling bodies of an asset, or bodies that fall onto the asset", "bodies", 12, 1, 1000, 0, 0,
    0};

class AssetScene final : public Scene {
  public:
    AssetScene(std::shared_ptr<const AssetLibrary> library, const Geometry& geometry,
               const SceneOptions& chosen)
        : Scene(about, chosen, 1), assets(std::move(library)), shown(geometry) {
        const TriangleSoup soup = triangulate(shown, *assets, 2);
        if (soup.vertices.empty()) return;
        lower = upper = soup.vertices.front();
        for (const Vec3& v : soup.vertices) lower = min(lower, v), upper = max(upper, v);
    }

    std::uint64_t content_id() const override {
        const AssetId id = shown.asset;
        return hash_bytes(std::as_bytes(std::span(&id, 1)), Scene::content_id());
    }

    Result<World> start() const override {
        const bool is_ground = shown.kind == ShapeKind::mesh || shown.kind == ShapeKind::height_field;
        return is_ground ? start_ground() : start_drop();
    }

  private:
    /// Copies of the asset on a spiral, each above the last. All but the first have random orientations.
    Result<World> start_drop() const {
        Builder build(world_for(options.size, options.seed), {}, assets);
        build.ground();
        Random random = Random::seeded(options.seed);
        const Real reach = max(0.01_r, half(length(upper - lower)));
        for (std::uint32_t i = 0; i < options.size; ++i) {
            const Real angle = Real(i) * 2.4_r, distance = i == 0 ? 0_r : reach * (1_r + Real(i) * 0.1_r);
            const Vec3 middle{distance * cos(angle), reach * (1.3_r + 2.1_r * Real(i)),
                              distance * sin(angle)};
            Quat turn = Quat::identity();
            if (i > 0)
                turn = from_euler({random.range(-pi, pi), random.range(-1_r, 1_r), random.range(-pi, pi)});
            const Vec3 centre = (lower + upper) / 2_r;
            build.body(
                {.pose = at(middle - rotate(turn, centre), turn), .user_key = user_key_of(Role::prop, i)},
                {.geometry = shown});
        }
        return std::move(build).finish();
    }

    /// Bodies on a grid above the asset.
    Result<World> start_ground() const {
        AssetLibrary with_props;
        for (const AssetId id : assets->ids())
            if (const auto added = with_props.add(assets->bytes(id)); !added) return added.error();
        const Vec3 size = upper - lower;
        const Real prop = clamp(max(size.x, size.z) / 40_r, 0.05_r, 0.8_r);
        Shelf shelf(std::move(with_props));
        const std::vector<Geometry> shapes = bake_props(shelf, prop);
        const auto all = std::move(shelf).finish();
        if (!all) return all.error();
        const std::uint32_t count = options.size * 5;
        Builder build(world_for(count, options.seed), {}, *all);
        build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::terrain, 0)},
                   {.geometry = shown});
        build.body({.kind = BodyKind::static_,
                    .pose = at({0_r, lower.y - 4_r * prop, 0_r}),
                    .user_key = user_key_of(Role::terrain, 1)},
                   {.geometry = plane()});
        Random random = Random::seeded(options.seed);
        for (std::uint32_t i = 0; i < count; ++i) {
            const Real x = random.range(lower.x + size.x / 10_r, upper.x - size.x / 10_r);
            const Real z = random.range(lower.z + size.z / 10_r, upper.z - size.z / 10_r);
            const Vec3 place{x, upper.y + prop * (1.5_r + Real(i) * 0.5_r), z};
            build.body({.pose = at(place, from_euler({random.range(-pi, pi), 0_r, random.range(-pi, pi)})),
                        .user_key = user_key_of(Role::prop, i)},
                       {.geometry = shapes[i % shapes.size()]});
        }
        return std::move(build).finish();
    }

    const std::shared_ptr<const AssetLibrary> assets;
    const Geometry shown;
    Vec3 lower{}, upper{};
};

} // namespace

Result<std::unique_ptr<Game>> make_asset_scene(std::shared_ptr<const AssetLibrary> assets, AssetId shown,
                                               const SceneOptions& options) {
    const Result<Geometry> geometry = assets->geometry(shown);
    if (!geometry) return geometry.error();
    SceneOptions filled = options;
    if (filled.size == 0) filled.size = about.size_default;
    if (filled.size > about.size_max)
        return Error{"asset: size is " + std::to_string(filled.size) + ", it must be 1 to " +
                     std::to_string(about.size_max)};
    return std::unique_ptr<Game>(std::make_unique<AssetScene>(std::move(assets), *geometry, filled));
}

} // namespace lockstone
