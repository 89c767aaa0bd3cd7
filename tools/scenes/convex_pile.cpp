// Hulls, cylinders, cones, rounded boxes and capsules fall into a walled pit of 8 x 8 m.
#include "lockstone/math/math.h"
#include "scenes/props.h"

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t layer_side = 7; ///< bodies along each side of a layer
constexpr Real size = 0.5_r;            ///< each body fits into a ball of this radius [m]
constexpr Real spacing = 1.1_r;         ///< [m] between centres
constexpr Real half_side = 4_r;         ///< of the pit [m]

class ConvexPile final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        Shelf shelf;
        const std::vector<Geometry> shapes = bake_props(shelf, size);
        const auto assets = std::move(shelf).finish();
        if (!assets) return assets.error();
        Builder build(world_for(options.size, options.seed), {}, *assets);
        build.ground();
        build_walls(build);
        add_props(build, options, shapes, place);
        return std::move(build).finish();
    }

  private:
    static Transform place(std::uint32_t i, Random& random) {
        const std::uint32_t layer = i / (layer_side * layer_side), in_layer = i % (layer_side * layer_side);
        const Real edge = half(spacing * Real(layer_side - 1));
        const Real x = spacing * Real(in_layer % layer_side) - edge + random.range(-0.04_r, 0.04_r);
        const Real z = spacing * Real(in_layer / layer_side) - edge + random.range(-0.04_r, 0.04_r);
        return at({x, 1_r + spacing * Real(layer), z}, random_turn(random));
    }

    /// Thick walls, as high as the highest bodies at the start.
    void build_walls(Builder& build) const {
        const std::uint32_t layers = 1 + options.size / (layer_side * layer_side);
        const Real half_height = half(spacing * Real(layers) + 4_r), offset = half_side + 1_r;
        const Geometry along_x = box(half_side, half_height, 1_r),
                       along_z = box(1_r, half_height, half_side + 2_r);
        const BodyId walls = build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::wall, 0)},
                                        {.geometry = along_z, .local = at({-offset, half_height, 0_r})});
        build.shape(walls, {.geometry = along_z, .local = at({offset, half_height, 0_r})});
        build.shape(walls, {.geometry = along_x, .local = at({0_r, half_height, -offset})});
        build.shape(walls, {.geometry = along_x, .local = at({0_r, half_height, offset})});
    }
};

} // namespace

std::unique_ptr<Scene> make_convex_pile(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<ConvexPile>(info, options, 1);
}

} // namespace lockstone::scenes_detail
